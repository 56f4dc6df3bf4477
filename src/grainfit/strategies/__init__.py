"""Strategies: choose the runs of a calibration, and decide when the answer is known."""
