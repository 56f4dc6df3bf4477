"""Section of the report: surfaces."""
