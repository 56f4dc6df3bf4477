"""Analysis of a calibration's runs: uncertainty, sensitivity, identifiability, Pareto front."""
