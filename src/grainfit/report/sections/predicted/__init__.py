"""Section of the report: predicted."""
