"""Section of the report: explorer."""
