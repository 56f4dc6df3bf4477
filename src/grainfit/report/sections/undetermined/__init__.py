"""Section of the report: undetermined."""
