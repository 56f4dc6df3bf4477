"""Packings of spheres from which beds and heaps of known shape are cut, in particle diameters."""

from __future__ import annotations

import math
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.measurement.particles import Particles

Kind = Literal["random", "polydisperse", "lattice"]
DIAMETER = 0.01
_TILE = 12.0
_SOLID_FRACTION = 0.6


@cache
def _tile(kind: Kind) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A periodic random packing: spheres thrown at random, pushed apart until none overlap."""
    rng = np.random.default_rng(7)
    spread = 0.3 if kind == "polydisperse" else 0.0
    radii = 0.5 * rng.uniform(1 - spread, 1 + spread, int(_TILE**3 * 2))
    volume = np.cumsum(4 / 3 * math.pi * radii**3)
    radii = radii[: np.searchsorted(volume, _SOLID_FRACTION * _TILE**3)]
    centres = rng.uniform(0, _TILE, (len(radii), 3))
    for _ in range(120):
        tree = cKDTree(centres, boxsize=_TILE)
        i, j = tree.query_pairs(2 * radii.max(), output_type="ndarray").T
        apart = centres[i] - centres[j]
        apart -= _TILE * np.round(apart / _TILE)
        distance = np.linalg.norm(apart, axis=1)
        overlap = np.maximum(radii[i] + radii[j] - distance, 0.0)
        push = apart * (0.45 * overlap / distance)[:, None]
        for axis in range(3):
            centres[:, axis] += np.bincount(i, push[:, axis], len(centres))
            centres[:, axis] -= np.bincount(j, push[:, axis], len(centres))
        centres %= _TILE
    return centres, radii


def packing(
    radius: float, height: float, seed: int, kind: Kind = "random"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres and radii that fill a cylinder, differently turned and shifted for every seed."""
    rng = np.random.default_rng(seed)
    if kind == "lattice":
        n = math.ceil(1.3 * radius)
        i, j, k = np.mgrid[-n : n + 1, -n : n + 1, 0 : math.ceil(height / 0.8) + 1]
        x = i + 0.5 * (j % 2) + 0.5 * (k % 2)
        y = 0.866 * j + 0.289 * (k % 2)
        centres = np.stack([x, y, 0.8165 * k], axis=-1).reshape(-1, 3)
        centres = 1.03 * centres + rng.normal(0, 0.12, centres.shape) + rng.uniform(0, 1, 3)
        radii = np.full(len(centres), 0.5)
    else:
        tile, tile_radii = _tile(kind)
        shifted = (tile + rng.uniform(0, _TILE, 3)) % _TILE
        m = math.ceil(radius / _TILE)
        cells = np.mgrid[-m:m, -m:m, 0 : math.ceil(height / _TILE)].reshape(3, -1).T * _TILE
        centres = (shifted[None] + cells[:, None]).reshape(-1, 3)
        radii = np.tile(tile_radii, len(cells))
    inside = (np.hypot(centres[:, 0], centres[:, 1]) < radius) & (centres[:, 2] < height)
    centres, radii = centres[inside], radii[inside]
    turn = rng.uniform(0, 2 * math.pi)
    cos, sin = math.cos(turn), math.sin(turn)
    centres[:, :2] = centres[:, :2] @ np.array([[cos, -sin], [sin, cos]])
    return centres, radii


def particles_of(
    centres: NDArray[np.float64], radii: NDArray[np.float64], density: float = 2500.0
) -> Particles:
    """Particles in SI units from centres and radii in diameters."""
    metres = radii * DIAMETER
    return Particles(centres * DIAMETER, metres, 4 / 3 * math.pi * metres**3 * density)


def heap(
    angle: float, height: float, seed: int, plateau: float = 0.0, kind: Kind = "random"
) -> Particles:
    """All spheres of a packing that lie wholly inside a cone, or a truncated one."""
    slope = math.tan(math.radians(angle))
    base = plateau + height / slope
    centres, radii = packing(base, height, seed, kind)
    distance = np.hypot(centres[:, 0], centres[:, 1])
    under_flank = centres[:, 2] + radii / math.cos(math.radians(angle)) < (base - distance) * slope
    under_plateau = centres[:, 2] + radii < height
    inside = under_flank & under_plateau & (centres[:, 2] > radii)
    return particles_of(centres[inside], radii[inside])
