"""Mass that stays in a vessel."""

from __future__ import annotations

import math

import numpy as np

from grainfit.evaluation import Response
from grainfit.measurement.particles import Particles

#: Parts of the bed whose masses are compared: of a round vessel sectors, of a slice one half of
#: them on each side.
_PARTS = 8


def residual_mass(end: Particles, depth: float | None, particle_mass: float) -> Response:
    """Return the mass above z = 0 and its standard error.

    The error follows from the differences between the masses in eight sectors about the axis, or
    in four parts along the depth on either side of the slot; it is that of one particle at least.

    Parameters
    ----------
    end : Particles
        The particles at rest.
    depth : float or None
        Period of a slice along y, m; None for a round vessel.
    particle_mass : float
        kg.

    Returns
    -------
    Response
        kg.
    """
    inside = end.select(end.positions[:, 2] > 0)
    x, y = inside.positions[:, 0], inside.positions[:, 1]
    if depth is None:
        part = (np.arctan2(y, x) / (2 * math.pi) + 0.5) * _PARTS
    else:
        part = (y % depth) / depth * (_PARTS // 2) + np.where(x < 0, 0, _PARTS // 2)
    number = np.minimum(part.astype(int), _PARTS - 1)
    masses = np.bincount(number, weights=inside.masses, minlength=_PARTS)
    scatter = float(masses.std(ddof=1)) * math.sqrt(_PARTS)
    return Response(float(masses.sum()), max(scatter, particle_mass))
