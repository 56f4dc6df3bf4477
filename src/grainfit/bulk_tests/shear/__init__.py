"""Shear test (plane shear between rough plates): angle of internal friction, density in shear."""

from grainfit.bulk_tests.shear.bulk_test import Shear
from grainfit.bulk_tests.shear.yield_locus import YieldLocus, fit_yield_locus

__all__ = ["Shear", "YieldLocus", "fit_yield_locus"]
