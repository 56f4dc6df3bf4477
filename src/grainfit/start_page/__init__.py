"""The page that leads from a material to a running calibration."""
