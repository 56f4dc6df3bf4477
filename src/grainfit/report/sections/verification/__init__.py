"""Section of the report: verification."""
