"""The interview: questions that lead from a material and a laboratory to a calibration file."""
