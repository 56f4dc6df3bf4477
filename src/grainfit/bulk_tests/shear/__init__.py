"""Shear test (plane shear between rough plates): angle of internal friction, density in shear."""

from grainfit.bulk_tests.shear.bulk_test import Shear
from grainfit.measurement.yield_locus import fit_yield_locus
from grainfit.result import YieldLocus

__all__ = ["Shear", "YieldLocus", "fit_yield_locus"]
