"""Geometry and procedure of a rotating drum: what follows from its options and is possible."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.drum import messages
from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.filling import count_faults
from grainfit.errors import Fault
from grainfit.formatting import turns_per_minute
from grainfit.scenes.packing import mean_particle_volume
from grainfit.scenes.scene import natural_time

#: Default lengths in Sauter diameters, and the least ones in diameters of the largest particles.
_RADIUS, _LENGTH = 8.0, 6.0
_LEAST_RADIUS, _LEAST_LENGTH = 5.0, 4.0
#: Default of the Froude number, and the largest one: laboratories turn drums of 84 mm at up to
#: 60 rpm (0.17). At 0.4 upper and lower half of the surface are 29 degrees apart.
FROUDE_NUMBER, FASTEST = 0.01, 0.2
#: Default of the averaged turns; and the shortest default, over sqrt(d/g): an avalanche takes 20 to
#: 40 of these units however fast the drum turns.
_TURNS, _AVALANCHES = 0.9, 150.0
#: Solid fraction of a bed, to calculate the number of particles; and the largest one at which
#: particles find places in the whole drum.
_SOLID_FRACTION, _LARGEST_FRACTION = 0.58, 0.45
#: Distance between two particles of the lining around the drum and along it, in their diameters.
_LINING_SPACING = 2.0
#: Snapshots in one turn.
_FRAMES = 120
#: Room between the caps that particles at the beginning leave, in the largest diameters.
_CLEAR_OF_CAPS = 1.02
_ROUNDING = 1e-9


class DrumSetup(Setup):
    """Geometry and procedure of a drum."""

    @property
    def usual_radius(self) -> float:
        """Default of the inner radius, m."""
        return max(_RADIUS * self.d, _LEAST_RADIUS * max(self.real.diameters))

    @property
    def usual_length(self) -> float:
        """Default of the period of the slice, m."""
        return max(_LENGTH * self.d, _LEAST_LENGTH * max(self.real.diameters))

    @property
    def usual_speed(self) -> float:
        """Default of the rotational speed, rad/s: that of the Froude number."""
        return math.sqrt(self.froude_number * self.gravity / self.drum_radius)

    @property
    def speed_as_froude_number(self) -> float:
        """Rotational speed squared times radius over gravity."""
        return float(self.rotational_speed**2 * self.drum_radius / self.gravity)

    @property
    def usual_turns(self) -> float:
        """Default of the averaged turns: several avalanches."""
        natural = natural_time(self.sizes, self.gravity)
        return max(_TURNS, _AVALANCHES * natural / self.turn_time)

    @property
    def gravity(self) -> float:
        """m/s^2; the identity of a run has it as a number with a point, however it was given."""
        return float(self.option("gravity"))

    @cached_property
    def lining_size(self) -> int:
        """Index of the particles that line the drum in the particle size distribution."""
        real = self.real.diameters
        return min(range(len(real)), key=lambda i: abs(real[i] - self.d))

    @property
    def lining_diameter(self) -> float:
        """Diameter of the particles that line the drum, m; 0 for a smooth drum."""
        return self.sizes.diameters[self.lining_size] if self.lining else 0.0

    @cached_property
    def particle_count(self) -> int:
        """Number of particles of the bed."""
        bed = self.fill_level * math.pi * self.drum_radius**2 * self.drum_length
        return math.floor(_SOLID_FRACTION * bed / mean_particle_volume(self.sizes))

    @property
    def turn_time(self) -> float:
        """Time of one turn, s."""
        return 2 * math.pi / self.rotational_speed

    @property
    def frame_interval(self) -> float:
        """Time between two snapshots, s."""
        return self.turn_time / _FRAMES

    @property
    def clear_radius(self) -> float:
        """Radius within the lining, m."""
        return self.drum_radius - self.lining_diameter / 2

    @property
    def clear_length(self) -> float:
        """Length in which the centres of particles have room at the beginning, m."""
        ends = _CLEAR_OF_CAPS * max(self.sizes.outer_diameters) if self.end_caps else 0.0
        return float(self.drum_length) - ends

    def lining_places(self) -> NDArray[np.float64]:
        """Return the centres of the particles of the lining, half sunk into the wall, m.

        A smooth drum has none.
        """
        if not self.lining_diameter:
            return np.empty((0, 3))
        spacing = _LINING_SPACING * self.lining_diameter
        around = math.floor(2 * math.pi * self.drum_radius / spacing)
        along = max(1, round(self.drum_length / spacing))
        row, column = np.divmod(np.arange(around * along), along)
        # Every other row is shifted by half a spacing.
        x = (column + 0.25 + 0.5 * (row % 2)) * self.drum_length / along
        azimuth = 2 * math.pi * row / around
        y, z = self.drum_radius * np.cos(azimuth), self.drum_radius * np.sin(azimuth)
        return np.column_stack((x, y, z))

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible."""
        yield [*self._faults()]

    def _faults(self) -> Iterator[Fault]:
        largest = self.largest
        least, length = _LEAST_RADIUS * largest, _LEAST_LENGTH * largest
        if self.drum_radius < least:
            yield messages.DRUM_IS_NARROW.fault(
                "drum_radius",
                drum_radius=self.drum_radius,
                fewest=_LEAST_RADIUS,
                largest=largest,
                least=least,
            )
        if self.drum_length < length:
            yield messages.DRUM_IS_SHORT.fault(
                "drum_length",
                drum_length=self.drum_length,
                fewest=_LEAST_LENGTH,
                largest=largest,
                length=length,
            )
        if self.is_given("rotational_speed") and self.is_given("froude_number"):
            yield messages.SPEED_GIVEN_TWICE.fault(
                "froude_number",
                froude_number=self.froude_number,
                rotational_speed=turns_per_minute(self.rotational_speed),
            )
        froude = self.speed_as_froude_number
        if froude > FASTEST * (1 + _ROUNDING):
            slowest = math.sqrt(FASTEST * self.gravity / self.drum_radius)
            yield messages.TOO_FAST.fault(
                "rotational_speed",
                rotational_speed=turns_per_minute(self.rotational_speed),
                froude=froude,
                fastest=FASTEST,
                # Rounded to three digits it is still within.
                slowest=turns_per_minute(0.99 * slowest),
                usual=FROUDE_NUMBER,
            )
        lengths = {"drum_radius": self.drum_radius, "drum_length": self.drum_length}
        too_many = [*count_faults(self.particle_count, lengths)]
        yield from too_many
        if not too_many and self.drum_radius >= least:
            yield from self._room_faults()

    def _room_faults(self) -> Iterator[Fault]:
        """Particles begin at places all over the drum, none touching another."""
        room = math.pi * (self.clear_radius - self.largest / 4) ** 2 * self.clear_length
        fraction = self.particle_count * mean_particle_volume(self.sizes) / room
        if fraction > _LARGEST_FRACTION:
            highest = math.floor(100 * self.fill_level * _LARGEST_FRACTION / fraction) / 100
            yield messages.NO_ROOM.fault(
                "fill_level",
                fill_level=self.fill_level,
                particle_count=self.particle_count,
                highest=highest,
            )
