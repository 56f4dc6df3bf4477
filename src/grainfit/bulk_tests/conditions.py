"""Conditions under which a bulk test uses a material."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from grainfit.materials.sizes import ParticleSizes

if TYPE_CHECKING:
    from grainfit.bulk_tests.base import BulkTest


@dataclass(frozen=True)
class Conditions:
    """Conditions under which a test uses a material: a material card states them."""

    sizes: ParticleSizes
    gravity: float
    time_step_fraction: float


def conditions_of(test: BulkTest) -> Conditions:
    """Return the conditions under which a test uses a material."""
    return Conditions(test.sizes, float(test.gravity), test.setup.time_step_fraction)
