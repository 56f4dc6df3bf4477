"""Section of the report: particles at the end of a bulk test."""
