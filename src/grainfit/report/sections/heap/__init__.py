"""Section of the report: heap."""
