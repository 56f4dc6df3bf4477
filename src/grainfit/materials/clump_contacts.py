"""Contacts of two clumps in a bed, where several of their spheres touch at once."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from grainfit.arrays import Array
from grainfit.materials.touching import Touching

#: Overlap at which contacts of two clumps are counted, over the diameter of their largest sphere.
OVERLAP = 0.04
#: Places of a second clump above the first that are tried; fewer of clumps of so many spheres that
#: there would be more pairs than that, and the beginning of their random numbers.
_PLACES, _FEWEST_PLACES, _PAIRS = 1500, 100, 1_000_000
_SEED = 20261129
#: Stiffness of a sphere of diameter 1 at that overlap, over its modulus.
_OF_SPHERE = math.sqrt(0.25 * OVERLAP)


def touching_of(positions: Array, radii: Array, moments: tuple[float, ...]) -> Touching:
    """Return the median contact of a clump with its like, at random orientations and places.

    A clump comes down on another until the first two spheres overlap by `OVERLAP`. All pairs that
    touch then add their springs of Hertz and their dashpots, which solvers give each pair as if it
    were alone. Both clumps give way by turning, too.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres of its spheres, along its principal axes; its volume is that of a sphere of
        diameter 1.
    radii : ndarray of shape (n,)
        Radii of its spheres.
    moments : tuple of float
        Principal moments of inertia over the mass.
    """
    random = np.random.default_rng(_SEED)
    places = max(_FEWEST_PLACES, min(_PLACES, _PAIRS // len(radii) ** 2))
    lower, upper = (_turned(places, positions, np.array(moments), random) for _ in range(2))
    reach = float((np.linalg.norm(positions, axis=1) + radii).max())
    beside = random.uniform(-1.4, 1.4, (places, 2)) * reach
    sums = radii[:, None] + radii
    apart = upper.places[:, None, :, :] - lower.places[:, :, None, :]
    apart[..., :2] += beside[:, None, None, :]
    squares = sums**2 - (apart[..., :2] ** 2).sum(axis=3)
    heights = np.sqrt(np.maximum(squares, 0.0)) - apart[..., 2]
    heights[squares <= 0] = -np.inf
    met = np.isfinite(heights).any(axis=(1, 2))
    return _median(radii, lower.of(met), upper.of(met), apart[met], heights[met])


class _Turned(NamedTuple):
    """Clumps at random orientations: places of their spheres, axes, and moments of inertia."""

    places: Array
    axes: Array
    moments: Array

    def of(self, chosen: Array) -> _Turned:
        return _Turned(self.places[chosen], self.axes[chosen], self.moments)

    def yields(self, point: Array, normal: Array) -> Array:
        """Return 1 / effective mass at points along normals, over the mass, shape (n,)."""
        torque = np.einsum("nji,nj->ni", self.axes, np.cross(point, normal))
        found: Array = 1 + (torque**2 / self.moments).sum(axis=1)
        return found


def _turned(places: int, positions: Array, moments: Array, random: np.random.Generator) -> _Turned:
    w, x, y, z = random.normal(size=(4, places))
    axes = Rotation.from_quat(np.column_stack((x, y, z, w))).as_matrix()
    return _Turned(np.einsum("nij,kj->nki", axes, positions), axes, moments)


def _median(radii: Array, lower: _Turned, upper: _Turned, apart: Array, heights: Array) -> Touching:
    """Return the median of contacts in which the upper clump rests on the lower one."""
    rows = np.arange(len(apart))
    first, second = np.divmod(heights.reshape(len(apart), -1).argmax(axis=1), len(radii))
    apart[..., 2] += heights[rows, first, second][:, None, None]
    normal = apart[rows, first, second]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    apart -= 2 * radii.max() * OVERLAP * normal[:, None, None, :]
    distance = np.linalg.norm(apart, axis=3)
    sums = radii[:, None] + radii
    effective = radii[:, None] * radii / sums
    springs = np.sqrt(effective * np.maximum(sums - distance, 0.0))
    along = np.einsum("nijk,nk->nij", apart / distance[..., None], normal) ** 2
    stiffness = (springs * along).sum(axis=(1, 2))
    dashpots = (np.sqrt(springs) * along).sum(axis=(1, 2))
    below = lower.places[rows, first] + normal * radii[first, None]
    above = upper.places[rows, second] - normal * radii[second, None]
    give = lower.yields(below, normal) + upper.yields(above, normal)
    frequency = np.sqrt(stiffness * give / (2 * _OF_SPHERE))
    damping = dashpots / np.sqrt(stiffness) * np.sqrt(give / 2)
    return Touching(float(np.median(frequency)), float(np.median(damping)))
