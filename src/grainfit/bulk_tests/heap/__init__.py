"""Heap test (lifted cylinder): bulk density and angle of repose."""

from grainfit.bulk_tests.heap.bulk_test import Heap

__all__ = ["Heap"]
