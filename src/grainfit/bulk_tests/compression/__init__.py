"""Compression test (uniaxial, confined): moduli, bulk density, lateral stress ratio."""

from grainfit.bulk_tests.compression.bulk_test import Compression

__all__ = ["Compression"]
