"""Calibrate: ask a strategy, run its proposals, verify the answer, build the result."""
