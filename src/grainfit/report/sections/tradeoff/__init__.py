"""Section of the report: tradeoff."""
