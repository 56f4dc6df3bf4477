"""Work folders: what a calibration keeps, read and changed from outside."""
