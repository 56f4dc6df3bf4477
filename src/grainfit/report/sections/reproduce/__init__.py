"""Section of the report: reproduce."""
