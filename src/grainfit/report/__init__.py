"""Report of a calibration: one page with the answer, its uncertainty and all runs."""
