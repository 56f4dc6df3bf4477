"""A page that follows a calibration while it runs."""
