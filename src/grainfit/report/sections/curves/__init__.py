"""Section of the report: curves."""
