"""Heap test (lifted cylinder): bulk density and angle of repose."""

from grainfit.bulk_tests.heap.cost import RunCost, estimate_cost
from grainfit.bulk_tests.heap.heap import HeapTest

__all__ = ["HeapTest", "RunCost", "estimate_cost"]
