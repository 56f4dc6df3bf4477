"""Section of the report: tests that took no part in the fit."""
