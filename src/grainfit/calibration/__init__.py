"""Calibrations: ask a strategy, make the runs, verify the answer, build the result."""
