"""Hopper test (cone, wedge or flat floor): discharge time, mass flow, residual mass."""

from grainfit.bulk_tests.hopper.bulk_test import Hopper

__all__ = ["Hopper"]
