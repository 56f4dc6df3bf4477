"""Checks of a calibration file before any run, and the registry of all checks."""
