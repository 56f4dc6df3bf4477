"""Rotating drum: dynamic angle of repose of a bed that flows down its own surface."""

from grainfit.bulk_tests.drum.bulk_test import Drum

__all__ = ["Drum"]
