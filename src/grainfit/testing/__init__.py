"""Contract tests for custom strategies, solvers, bulk tests and contact models."""
