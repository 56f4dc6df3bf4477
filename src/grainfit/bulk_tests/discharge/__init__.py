"""Discharge test (flat-bottomed container): mass flow and bulk density."""

from grainfit.bulk_tests.discharge.bulk_test import Discharge

__all__ = ["Discharge"]
