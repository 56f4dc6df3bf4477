"""One reader of tables in text files: separators, decimal marks, headings, units, and faults."""
