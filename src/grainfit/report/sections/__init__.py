"""Sections of the report, a folder each: the section, its page, script and style."""
