"""Section of the report: answer."""
