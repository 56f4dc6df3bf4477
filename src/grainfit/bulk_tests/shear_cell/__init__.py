"""Shear cell (preshear, then shear to failure): yield locus, strength and flowability."""

from grainfit.bulk_tests.shear_cell.bulk_test import ShearCell

__all__ = ["ShearCell"]
