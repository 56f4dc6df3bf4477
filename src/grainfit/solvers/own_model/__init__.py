"""A user's own model: a command, a Python function, or a table of recorded runs."""
