"""Clumps: overlapping spheres as a rigid body, with the mass and inertia of their union."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from grainfit.materials.clump_contacts import OVERLAP, touching_of
from grainfit.materials.touching import Touching

#: Lines across the longest side of a clump along which its volume is integrated.
_LINES = 480
#: Products of inertia below this share of the largest moment are rounding errors.
_ROUNDING = 1e-4
#: Ratio of times, of two smallest spheres and of two clumps in contact, up to which the usual share
#: of the Rayleigh time is short enough: a third changes bulk densities by 1 % (docs/clumps.md).
_COVERED = 1.5
_DIRECTIONS = 400
#: Volume of a sphere of diameter 1.
_UNIT_VOLUME = math.pi / 6


@dataclass(frozen=True)
class Clump:
    """Overlapping spheres as one rigid body with the volume of a sphere of diameter 1.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres of the spheres; the centre of mass is at 0, the axes are the principal ones.
    radii : ndarray of shape (n,)
        Radii of the spheres.
    moments : tuple of float
        Principal moments of inertia over the mass.
    """

    positions: NDArray[np.float64]
    radii: NDArray[np.float64]
    moments: tuple[float, float, float]

    def __len__(self) -> int:
        return len(self.radii)

    @property
    def outer_radius(self) -> float:
        """Distance of the outermost point from the centre of mass."""
        return float((np.linalg.norm(self.positions, axis=1) + self.radii).max())

    @property
    def smallest_radius(self) -> float:
        """Radius of the smallest sphere."""
        return float(self.radii.min())

    @cached_property
    def rayleigh_radius(self) -> float:
        """Radius of the sphere whose Rayleigh time limits the time step of the clump.

        It is that of the smallest sphere, or less: spheres that nearly coincide touch at once, so
        that n of them make two clumps up to n^2 times as stiff as two spheres of their mass.
        """
        return self.smallest_radius * min(1.0, _COVERED / self._stiffest())

    @cached_property
    def touching(self) -> Touching:
        """Median contact of two of them, over one that their Rayleigh radius covers."""
        found = touching_of(self.positions, self.radii, self.moments)
        share = 2 * self.rayleigh_radius / _COVERED
        return found._replace(frequency=share * found.frequency)

    def _stiffest(self) -> float:
        """Return the largest ratio of times: of two smallest spheres, and of two clumps in contact.

        One clump is the mirror image of the other in the plane of contact, for many directions of
        its normal. The stiffness of Hertz is that of every pair that touches, as the root of its
        radius and of its overlap.
        """
        radii, largest = self.radii, float(self.radii.max())
        along = _directions(_DIRECTIONS) @ self.positions.T
        behind = (along + radii).max(axis=1, keepdims=True) - (along + radii)
        apart = ((self.positions[:, None] - self.positions) ** 2).sum(axis=2)
        beside = apart - (along[:, :, None] - along[:, None, :]) ** 2
        pair = 2 * radii[:, None] * radii / (radii[:, None] + radii)
        whole = 2 * largest * OVERLAP
        overlap = whole - behind[:, :, None] - behind[:, None, :] - beside / (4 * pair)
        of_pairs = np.sqrt(np.maximum(overlap, 0.0) * pair / (2 * OVERLAP))
        stiffness = of_pairs.sum(axis=(1, 2)).max()
        # A sphere of diameter 1 has the mass of the clump, and a stiffness of 1/2.
        return self.smallest_radius * math.sqrt(8 * float(stiffness))

    @property
    def overlap_factor(self) -> float:
        """Volume of the union over the sum of the volumes of the spheres."""
        return _UNIT_VOLUME / float(4 / 3 * math.pi * (self.radii**3).sum())


@lru_cache(maxsize=64)
def clump_of(spheres: tuple[tuple[float, float, float, float], ...]) -> Clump:
    """Return the clump of spheres, at the volume of a sphere of diameter 1.

    Parameters
    ----------
    spheres : tuple of tuple of float
        x, y, z and radius of each sphere, in any unit.
    """
    return build_clump(spheres)


def build_clump(
    spheres: Sequence[tuple[float, float, float, float]], resolution: int = _LINES
) -> Clump:
    """Return a clump, as `clump_of`, with so many lines across the union of its spheres."""
    table = np.array(spheres, dtype=float)
    positions, radii = table[:, :3], table[:, 3]
    volume, centre, inertia = body_of(positions, radii, resolution)
    turned = np.eye(3)
    products = inertia - np.diag(np.diag(inertia))
    if np.abs(products).max() > _ROUNDING * np.diag(inertia).max():
        turned = np.linalg.eigh(inertia)[1]
        turned[:, 2] *= np.linalg.det(turned)
    moments = np.diag(turned.T @ inertia @ turned)
    scale = (_UNIT_VOLUME / volume) ** (1 / 3)
    x, y, z = (float(m) * scale**2 / volume for m in moments)
    return Clump(scale * (positions - centre) @ turned, scale * radii, (x, y, z))


def body_of(
    positions: NDArray[np.float64], radii: NDArray[np.float64], resolution: int = _LINES
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return volume, centre and inertia about it of the union of spheres, at a density of 1.

    Along x, the union is integrated exactly: lines in that direction pass through it.

    Parameters
    ----------
    positions : ndarray of shape (n, 3)
        Centres.
    radii : ndarray of shape (n,)
        Radii.
    resolution : int, optional
        Lines across the larger side.
    """
    low, high = (positions - radii[:, None]).min(axis=0), (positions + radii[:, None]).max(axis=0)
    step = float((high - low)[1:].max()) / resolution
    y, z = (
        np.arange(round((high[axis] - low[axis]) / step)) * step + low[axis] + step / 2
        for axis in (1, 2)
    )
    lines = np.stack([a.ravel() for a in np.meshgrid(y, z, indexing="ij")], axis=1)
    beside = ((lines[:, None, :] - positions[None, :, 1:]) ** 2).sum(axis=2)
    half = np.sqrt(np.maximum(radii**2 - beside, 0.0))
    starts, ends = positions[:, 0] - half, positions[:, 0] + half
    starts[half == 0] = ends[half == 0] = np.inf
    powers = _moments_along(starts, ends)
    length, first, second = (part * step**2 for part in powers)
    volume = float(length.sum())
    by_line = np.column_stack((first, length * lines[:, 0], length * lines[:, 1]))
    centre = by_line.sum(axis=0) / volume
    squares = np.array(
        [
            [second.sum(), first @ lines[:, 0], first @ lines[:, 1]],
            [0.0, length @ lines[:, 0] ** 2, length @ (lines[:, 0] * lines[:, 1])],
            [0.0, 0.0, length @ lines[:, 1] ** 2],
        ]
    )
    squares += np.triu(squares, 1).T
    squares -= volume * np.outer(centre, centre)
    return volume, centre, np.trace(squares) * np.eye(3) - squares


def _directions(number: int) -> NDArray[np.float64]:
    """Return unit vectors spread evenly over a sphere, and the axes, shape (number + 3, 3)."""
    step = np.arange(number) + 0.5
    z, turn = 1 - 2 * step / number, math.pi * (1 + math.sqrt(5)) * step
    across = np.sqrt(1 - z**2)
    spread = np.column_stack((across * np.cos(turn), across * np.sin(turn), z))
    return np.vstack((spread, np.eye(3)))


def _moments_along(
    starts: NDArray[np.float64], ends: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Integrate 1, x and x^2 over the union of the intervals of each row; inf is no interval."""
    order = np.argsort(starts, axis=1)
    starts, ends = (np.take_along_axis(a, order, axis=1) for a in (starts, ends))
    found = [np.zeros(len(starts)) for _ in range(3)]
    reached = np.full(len(starts), -np.inf)
    for column in range(starts.shape[1]):
        begin = np.maximum(starts[:, column], reached)
        end = np.maximum(ends[:, column], begin)
        is_there = np.isfinite(begin)
        for power, total in enumerate(found, 1):
            total[is_there] += (end[is_there] ** power - begin[is_there] ** power) / power
        reached = np.where(is_there, end, reached)
    return found[0], found[1], found[2]
