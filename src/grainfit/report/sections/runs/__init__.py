"""Section of the report: runs."""
