"""Rough plates of a shear test: closed layers of glued particles that none can pass."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.glued import Glued

#: Distance of glued particles of the one size of a bed, and their roughness, in diameters. Between
#: particles that are glued more loosely, others leak through.
_SPACING = 1.0
_ROUGHNESS = 0.35
#: Radius of the hole between four particles that touch, in their diameters.
_HOLE = math.sqrt(0.5) - 0.5


@dataclass(frozen=True)
class PlateLayout:
    """A closed layer: a square lattice whose particles stand out by different heights.

    Parameters
    ----------
    size_index : int
        Index of the glued particles' diameter in the particle size distribution.
    diameter : float
        Of the glued particles, m.
    columns, rows : int
        Particles along x and y.
    roughness : float
        Largest deviation of a particle from the middle of the plate, m.
    """

    size_index: int
    diameter: float
    columns: int
    rows: int
    roughness: float

    @property
    def count(self) -> int:
        """Number of glued particles of a plate."""
        return self.columns * self.rows

    @property
    def reach(self) -> float:
        """Distance from the middle of a plate to its farthest surface, m."""
        return self.roughness + self.diameter / 2

    def glued(self, length: float, depth: float, z: float, random: np.random.Generator) -> Glued:
        """Return a plate at a height, with random heights of its particles.

        Parameters
        ----------
        length, depth : float
            Periods along x and y, m.
        z : float
            Height of the middle of the plate: the mean of its particles, m.
        random : Generator
            Source of the heights.
        """
        x, y = np.meshgrid(
            (np.arange(self.columns) + 0.5) * length / self.columns,
            (np.arange(self.rows) + 0.5) * depth / self.rows,
        )
        heights = random.uniform(-self.roughness, self.roughness, self.count)
        heights = np.clip(heights - heights.mean(), -self.roughness, self.roughness)
        positions = np.column_stack((x.ravel(), y.ravel(), z + heights))
        return Glued(positions, np.full(self.count, self.size_index))


def plate_layout(sizes: ParticleSizes, length: float, depth: float) -> PlateLayout:
    """Return the layout of plates that no particle of a size distribution can pass.

    Glued particles have the size that is nearest to the Sauter diameter. They are as near to each
    other as the smallest particles demand.
    """
    ratios = [abs(math.log(d / sizes.sauter_diameter)) for d in sizes.diameters]
    index = ratios.index(min(ratios))
    diameter, smallest = sizes.diameters[index], min(sizes.diameters)
    share = min(1.0, smallest / diameter)
    spacing = min(_SPACING, math.sqrt(2) * (0.5 + _HOLE * share)) * diameter
    # A lattice that fits a period within a rounding error is not made closer.
    columns, rows = (math.ceil(period / spacing - 1e-9) for period in (length, depth))
    return PlateLayout(index, diameter, columns, rows, _ROUGHNESS * share * diameter)
