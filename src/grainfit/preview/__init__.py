"""Preview of the tests of a calibration file: geometry, stages, particles and cost."""
