"""Section of the report: yield locus."""
