"""Adapters to whatever simulates a bulk test, all behind `grainfit.solvers.base.Solver`."""
