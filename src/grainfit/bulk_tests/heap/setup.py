"""Geometry and procedure of a heap test: what follows from its options, and what is impossible."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

from grainfit.bulk_tests.heap import messages
from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.filling import (
    Filling,
    count_faults,
    cylinder_faults,
    least_radius,
    particles_to_fill,
    strike_off_faults,
)
from grainfit.bulk_tests.shared.plate import ON_DISC
from grainfit.errors import Fault
from grainfit.scenes.packing import Round, column_height

#: The defaults are those of a test of 10 mm beads on Earth; other sizes follow by Froude's law.
_REFERENCE_DIAMETER = 0.010
_REFERENCE_GRAVITY = 9.81
#: Default radius of the cylinder, in diameters.
USUAL_RADIUS = 6


class HeapSetup(Setup):
    """Geometry and procedure of a heap test; heights are above the plate."""

    @property
    def d(self) -> float:
        """Diameter that the defaults follow, m: larger where mixtures need a wider cylinder."""
        if self.is_given("cylinder_radius"):
            return super().d
        return max(super().d, least_radius(self.real) / USUAL_RADIUS)

    @property
    def is_disc(self) -> bool:
        """Whether the heap covers a disc, off which the surplus falls."""
        return bool(self.base == ON_DISC)

    @property
    def usual_plate(self) -> float:
        """Default of the radius of plate or disc, m."""
        return float(self.cylinder_radius) if self.is_disc else 16 * self.d

    @property
    def usual_count(self) -> int:
        """Default of the number of particles."""
        return particles_to_fill(self.sizes, self.cylinder_radius, self.strike_off_height)

    @property
    def usual_density_top(self) -> float:
        """Default of the height up to which the bulk density is measured, m."""
        usual = 9 * self.d
        return usual if usual <= self.strike_off_height else 6 / 7 * self.strike_off_height

    @property
    def usual_lift_height(self) -> float:
        """Default of the longest travel of the cylinder, m."""
        usual = self.layers_lifted
        return usual if usual >= self.strike_off_height / 4 else self.strike_off_height / 2

    @property
    def layers_lifted(self) -> float:
        """Travel of a usual cylinder, m: with it, no bed of this size stays in it."""
        return 10 * self.d

    @property
    def usual_lift_speed(self) -> float:
        """Default of the speed of the cylinder, m/s: laboratories lift it beside real particles."""
        return 0.05 * _froude_speed(self.d, self.gravity)

    @property
    def cylinder_gap(self) -> float:
        """Height of the lower end of the cylinder before it is lifted, m."""
        return 0.15 * min(self.sizes.diameters)

    @cached_property
    def filling(self) -> Filling:
        """Particles rained in, and when they are at rest: that follows the simulated ones."""
        diameter, count = self.sizes.sauter_diameter, self.particle_count
        time = math.sqrt(diameter / _REFERENCE_DIAMETER * _REFERENCE_GRAVITY / self.gravity)
        return Filling(
            particle_count=count,
            column_height=column_height(self.sizes, count, Round(self.cylinder_radius)),
            gravity=self.gravity,
            quiet_speed=0.004 * _froude_speed(diameter, self.gravity),
            check_interval=0.05 * time,
        )

    @property
    def heap_volume(self) -> float:
        """Bulk volume of the heap, m^3: that of the bed that is struck off."""
        return float(math.pi * self.cylinder_radius**2 * self.strike_off_height)

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the filled cylinder, then everything about it."""
        names = ("cylinder_radius", "strike_off_height")
        lengths = {name: self.option(name) for name in names}
        yield [
            *cylinder_faults(self.sizes, self.cylinder_radius),
            *count_faults(self.particle_count, lengths, self.is_given("particle_count")),
        ]
        yield [*self._geometry_faults()]

    def _geometry_faults(self) -> Iterator[Fault]:
        narrow = self.plate_radius < self.cylinder_radius
        if narrow or (self.plate_radius == self.cylinder_radius and not self.is_disc):
            yield messages.PLATE_IS_NARROW.fault(
                "plate_radius", plate_radius=self.plate_radius, cylinder_radius=self.cylinder_radius
            )
        if self.bulk_density_top - self.bulk_density_bottom < self.largest:
            yield messages.NOTHING_TO_MEASURE.fault(
                "bulk_density_top",
                bulk_density_bottom=self.bulk_density_bottom,
                bulk_density_top=self.bulk_density_top,
            )
        if self.bulk_density_top > self.strike_off_height:
            yield messages.MEASURED_ABOVE_BED.fault(
                "bulk_density_top",
                bulk_density_top=self.bulk_density_top,
                strike_off_height=self.strike_off_height,
            )
        if self.rim_height >= self.strike_off_height:
            yield messages.RIM_ABOVE_BED.fault(
                "rim_height", rim_height=self.rim_height, strike_off_height=self.strike_off_height
            )
        if self.lift_height < self.strike_off_height / 4:
            yield messages.LIFT_IS_SHORT.fault(
                "lift_height",
                lift_height=self.lift_height,
                strike_off_height=self.strike_off_height,
            )
        yield from strike_off_faults(
            self.sizes, self.cylinder_radius, self.strike_off_height, self.particle_count
        )


def _froude_speed(diameter: float, gravity: float) -> float:
    """Return the speed at which a lift of this size looks as one of 10 mm beads at 1 m/s, m/s."""
    return math.sqrt(diameter / _REFERENCE_DIAMETER * gravity / _REFERENCE_GRAVITY)
