"""Upper surface of a bed between two walls, periodic along the depth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.measurement.grid import MOST_CELLS_IN_PARTS, require_grid
from grainfit.measurement.particles import Particles

#: Pixels in a particle diameter.
_PIXELS = 8
_FARTHEST_PIXEL = 1e15
#: Pixels that are worked on at once, to use little memory.
_AT_ONCE = 5_000_000


@dataclass(frozen=True)
class HeightMap:
    """Heights of a surface over a rectangle.

    Parameters
    ----------
    heights : ndarray of shape (rows, columns)
        Height above the ground in every pixel, m; rows along y, columns along x; 0 where there is
        no particle.
    x : ndarray of shape (columns,)
        Middle of every column, m.
    depth : float
        Extent along y, m.
    """

    heights: NDArray[np.float64]
    x: NDArray[np.float64]
    depth: float

    @property
    def profile(self) -> NDArray[np.float64]:
        """Heights averaged over the depth, shape (columns,), m."""
        profile: NDArray[np.float64] = self.heights.mean(axis=0)
        return profile

    def slices(self, thickness: float) -> NDArray[np.float64]:
        """Return profiles of slices of about this thickness, shape (slices, columns), m."""
        count = max(1, min(len(self.heights), round(self.depth / thickness)))
        parts = np.array_split(self.heights, count)
        return np.array([part.mean(axis=0) for part in parts])


def height_map(
    particles: Particles, low: float, high: float, depth: float, ground: float
) -> HeightMap:
    """Render the upper surface of spheres between two walls, as seen from above.

    Parameters
    ----------
    particles : Particles
        The bed at rest; periodic in y from 0 to ``depth``.
    low, high : float
        Limits along x, m.
    depth : float
        Period along y, m.
    ground : float
        Height from which heights are counted, m.

    Raises
    ------
    NotMeasurableError
        It would have too many pixels.
    """
    pixel = particles.diameter / _PIXELS
    require_grid("surface of the bed", (high - low) / pixel, depth / pixel)
    columns = max(1, round((high - low) / pixel))
    rows = max(1, round(depth / pixel))
    across, along = (high - low) / columns, depth / rows
    x = np.array(low + across * (np.arange(columns) + 0.5), dtype=np.float64)
    heights = np.zeros((rows, columns))
    reach = float(particles.radii.max()) / min(across, along)
    around = 2 * reach + 3
    most = MOST_CELLS_IN_PARTS
    require_grid("surface of the bed", len(particles), around, around, most=most)
    steps = np.arange(-math.ceil(reach) - 1, math.ceil(reach) + 2)
    at_once = max(1, _AT_ONCE // len(steps) ** 2)
    for first in range(0, len(particles), at_once):
        few = slice(first, first + at_once)
        _raise_surface(heights, particles.select(few), steps, (low, across, along), ground)
    return HeightMap(heights, x, depth)


def _raise_surface(
    heights: NDArray[np.float64],
    particles: Particles,
    steps: NDArray[np.int64],
    grid: tuple[float, float, float],
    ground: float,
) -> None:
    """Raise the heights to the tops of spheres, in the pixels around each of them."""
    rows, columns = heights.shape
    low, across, along = grid
    column = _pixel((particles.positions[:, 0] - low) / across)[:, None] + steps
    row = _pixel(particles.positions[:, 1] / along)[:, None] + steps
    dx = low + across * (column + 0.5) - particles.positions[:, :1]
    dy = along * (row + 0.5) - particles.positions[:, 1:2]
    square = dx[:, None, :] ** 2 + dy[:, :, None] ** 2
    rise = particles.radii[:, None, None] ** 2 - square
    inside = (rise > 0) & ((column >= 0) & (column < columns))[:, None, :]
    number, i, j = np.nonzero(inside)
    top = particles.positions[number, 2] + np.sqrt(rise[number, i, j]) - ground
    np.maximum.at(heights, (row[number, i] % rows, column[number, j]), top)


def _pixel(place: NDArray[np.float64]) -> NDArray[np.int64]:
    # Whole numbers end before the places of particles that flew away.
    return np.floor(np.clip(place, -_FARTHEST_PIXEL, _FARTHEST_PIXEL)).astype(np.int64)
