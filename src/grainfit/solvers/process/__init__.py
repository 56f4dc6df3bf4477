"""Processes of solvers: start, end, and the faults they die of."""
