"""Custom models: a command, a Python function, or a table of recorded runs."""
