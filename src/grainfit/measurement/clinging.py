"""Particles that cling to a wall which has been lifted off a heap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from grainfit.measurement.particles import Particles

#: Particles touch at this distance of their surfaces, in mean diameters.
_TOUCHING = 0.01


def clinging(particles: Particles, radius: float) -> NDArray[np.bool_]:
    """Return which particles hang on a cylinder about the z axis, over a plate at z = 0.

    A particle hangs on the cylinder if a chain of contacts joins it to the cylinder, and none to
    the plate.

    Parameters
    ----------
    particles : Particles
        Particles at rest.
    radius : float
        Of the cylinder, m; particles touch it from inside or from outside.
    """
    if not len(particles):
        return np.zeros(0, dtype=bool)
    group = _groups(particles)
    slack = _TOUCHING * particles.diameter
    positions, radii = particles.positions, particles.radii
    from_wall = np.abs(np.hypot(positions[:, 0], positions[:, 1]) - radius)
    at_wall = np.unique(group[from_wall < radii + slack])
    on_plate = np.unique(group[positions[:, 2] < radii + slack])
    return np.isin(group, np.setdiff1d(at_wall, on_plate))


def _groups(particles: Particles) -> NDArray[np.int32]:
    """Return for each particle the number of the group that contacts join it to."""
    positions, radii = particles.positions, particles.radii
    slack = _TOUCHING * particles.diameter
    near = cKDTree(positions).query_pairs(2 * radii.max() + slack, output_type="ndarray")
    gaps = np.linalg.norm(positions[near[:, 0]] - positions[near[:, 1]], axis=1)
    touching = near[gaps < radii[near].sum(axis=1) + slack]
    count = len(particles)
    graph = coo_array((np.ones(len(touching)), (touching[:, 0], touching[:, 1])), (count, count))
    _, group = connected_components(graph, directed=False)
    found: NDArray[np.int32] = group
    return found
