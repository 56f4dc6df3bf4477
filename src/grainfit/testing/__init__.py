"""Contract tests for custom strategies, solvers, bulk tests and contact models."""

from grainfit.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
