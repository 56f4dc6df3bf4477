"""Surfaces at the end of a draw-down: the wedges on the shelf, and the heap on the floor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from grainfit.bulk_tests.draw_down import messages
from grainfit.bulk_tests.draw_down.setup import DrawDownSetup
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.grid import require_grid
from grainfit.measurement.height_map import HeightMap, height_map
from grainfit.measurement.inclination import (
    WEDGE_CORRELATION,
    Inclination,
    error_of_mean,
    inclination_of_pile,
    inclination_of_wedges,
)
from grainfit.measurement.messages import NO_ANGLE
from grainfit.measurement.particles import Particles

#: Thickness of the slices whose residual masses are compared, in diameters.
_SLICE = 2.0


@dataclass(frozen=True)
class Surfaces:
    """Particles at the end of a draw-down.

    Parameters
    ----------
    setup : DrawDownSetup
        Geometry of the test.
    particles : Particles
        All that are left.
    diameter : float
        Median particle diameter, m.
    """

    setup: DrawDownSetup
    particles: Particles
    diameter: float

    @classmethod
    def of(cls, particles: Particles, setup: DrawDownSetup) -> Self:
        """Return the surfaces of the particles at the end.

        Raises
        ------
        NotMeasurableError
            No particles are left.
        """
        if not len(particles):
            raise NotMeasurableError(messages.NONE_LEFT())
        return cls(setup, particles, particles.diameter)

    @cached_property
    def upper(self) -> Particles:
        """Particles that are still in the upper box."""
        return self.particles.select(self.particles.positions[:, 2] > self.setup.underside)

    @cached_property
    def on_floor(self) -> Particles:
        """Particles on the lower floor."""
        x, z = self.particles.positions[:, 0], self.particles.positions[:, 2]
        below = (z <= self.setup.underside) & (z > self.setup.floor)
        return self.particles.select(below & (np.abs(x) < self.setup.floor_half_width))

    @cached_property
    def wedges(self) -> HeightMap:
        """Surface of the material in the upper box, above the shelf."""
        half = self.setup.box.width / 2
        return height_map(self._some(self.upper), -half, half, self.setup.box.depth, 0.0)

    @cached_property
    def heap(self) -> HeightMap:
        """Surface of the heap, above the lower floor."""
        half, ground = self.setup.floor_half_width, self.setup.floor
        return height_map(self._some(self.on_floor), -half, half, self.setup.box.depth, ground)

    def _some(self, particles: Particles) -> Particles:
        if not len(particles):
            raise NotMeasurableError(messages.ONE_SIDE())
        return particles

    @cached_property
    def apex(self) -> float:
        """Height of the heap's ridge above the floor, averaged over the depth, m."""
        return float(self.heap.profile.max())

    def shear_angle(self) -> Inclination:
        """Measure the inclination of the wedges.

        Raises
        ------
        NotMeasurableError
            There are no two wedges, and why.
        """
        try:
            return inclination_of_wedges(self.wedges, self.setup.box.slot_width, self.diameter)
        except NotMeasurableError as error:
            raise NotMeasurableError(messages.NO_SHEAR_ANGLE(reason=error)) from None

    def angle_of_repose(self) -> Inclination:
        """Measure the inclination of the heap's flanks.

        Raises
        ------
        NotMeasurableError
            There is no heap with two flanks, and why.
        """
        try:
            return inclination_of_pile(self.heap, self.diameter)
        except NotMeasurableError as error:
            raise NotMeasurableError(NO_ANGLE(reason=error)) from None

    def discharged_share(self, filled: float) -> Response:
        """Return the share of the mass that has left the upper box, and its standard error.

        The standard error is that of the residual mass, from its scatter along the depth and
        between the two sides.

        Parameters
        ----------
        filled : float
            Mass filled in, kg.
        """
        depth, upper = self.setup.box.depth, self.upper
        require_grid("discharged share", depth / (_SLICE * self.diameter))
        count = max(1, round(depth / (_SLICE * self.diameter)))
        edges = np.linspace(0, depth, count + 1)
        y = upper.positions[:, 1] % depth
        masses = [
            np.histogram(y[side], edges, weights=upper.masses[side])[0]
            for side in (upper.positions[:, 0] < 0, upper.positions[:, 0] >= 0)
        ]
        correlation = WEDGE_CORRELATION * self.diameter
        error = error_of_mean(np.array(masses), depth, correlation) * 2 * count
        return Response(1 - float(upper.masses.sum()) / filled, error / filled)
