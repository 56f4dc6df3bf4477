"""Heap test (lifted cylinder): bulk density and angle of repose."""

from grainfit.bulk_tests.heap.bulk_test import HeapTest, RunCost, estimate_cost

__all__ = ["HeapTest", "RunCost", "estimate_cost"]
