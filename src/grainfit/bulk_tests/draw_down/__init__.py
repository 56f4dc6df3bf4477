"""Draw-down test (two boxes): bulk density, mass flow, share, shear angle and angle of repose."""

from grainfit.bulk_tests.draw_down.bulk_test import DrawDown

__all__ = ["DrawDown"]
