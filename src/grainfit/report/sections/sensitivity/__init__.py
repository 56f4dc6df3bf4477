"""Section of the report: sensitivity."""
