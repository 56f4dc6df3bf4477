"""Funnel test (poured heap): angle of repose and size of a heap below a funnel."""

from grainfit.bulk_tests.funnel.bulk_test import Funnel

__all__ = ["Funnel"]
