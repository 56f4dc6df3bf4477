"""The calibration file: TOML with units in, problem and solvers out."""
