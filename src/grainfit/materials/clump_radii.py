"""Radii that limit the time step of the clumps of a family, as functions of their aspect ratio."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from grainfit.arrays import Array
from grainfit.materials.clumps import build_clump
from grainfit.materials.particle_shape import FAMILIES

#: Aspect ratios of a table, denser near 1, and lines across a clump: within 1 % of the clump's own.
_POINTS, _RESOLUTION = 64, 60
#: Root of the first excess of the aspect ratio over 1: a sphere has nothing that coincides.
_NEAREST = 1e-3


def rayleigh_radius(family: str, aspect_ratio: float) -> float:
    """Return `Clump.rayleigh_radius` of a family of clumps, interpolated.

    At an aspect ratio of 1, it is that of clumps whose spheres nearly coincide.
    """
    return float(np.interp(aspect_ratio, *rayleigh_radii(family)))


def extreme_aspect_ratios(family: str, low: float, high: float) -> tuple[float, float]:
    """Return the aspect ratios from a lower to a higher one of smallest and of largest radius."""
    ratios, radii = rayleigh_radii(family)
    within = np.hstack((low, ratios[(ratios > low) & (ratios < high)], high))
    found = np.interp(within, ratios, radii)
    return float(within[found.argmin()]), float(within[found.argmax()])


@lru_cache
def rayleigh_radii(family: str) -> tuple[Array, Array]:
    """Return aspect ratios of a family of clumps, and `Clump.rayleigh_radius` at each."""
    known = FAMILIES[family]
    ratios = 1 + (known.largest - 1) * np.linspace(_NEAREST, 1, _POINTS) ** 2
    clumps = (build_clump(known.spheres(ratio), _RESOLUTION) for ratio in ratios.tolist())
    return ratios, np.array([clump.rayleigh_radius for clump in clumps])
