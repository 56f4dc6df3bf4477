"""Geometry and procedure of a rotating drum: every default resolved, impossible values rejected."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.shared.filling import count_faults
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import mean_particle_volume
from grainfit.scenes.scene import natural_time

#: Default lengths in Sauter diameters, and the least ones in diameters of the largest particles.
_RADIUS, _LENGTH = 8.0, 6.0
_LEAST_RADIUS, _LEAST_LENGTH = 5.0, 4.0
#: Default of the Froude number. Faster than 1, a drum carries its particles all the way round.
_FROUDE_NUMBER = 0.01
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


@dataclass(frozen=True)
class DrumSetup:
    """Geometry and procedure of one drum; lengths in m, times in s.

    Parameters
    ----------
    drum_radius, drum_length : float
        Inner radius, and period of the slice.
    fill_level : float
        Share of the drum that the bed takes at a solid fraction of 0.58.
    rotational_speed : float
        rad/s.
    discarded_turns, averaged_turns : float
        Turns before the averaging, and during it.
    lining_diameter : float
        Diameter of the particles that line the drum; 0 for a smooth drum.
    lining_size : int
        Their index in the particle size distribution.
    particle_count : int
        Particles of the bed.
    gravity : float
        m/s^2.
    """

    drum_radius: float
    drum_length: float
    fill_level: float
    rotational_speed: float
    discarded_turns: float
    averaged_turns: float
    lining_diameter: float
    lining_size: int
    particle_count: int
    gravity: float
    #: The speed is recorded as `rotational_speed`, however it was given.
    froude_number: None = None

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


def plan_setup(sizes: ParticleSizes, options: Mapping[str, Any]) -> DrumSetup:
    """Resolve every default of a drum.

    Parameters
    ----------
    sizes : ParticleSizes
        The length scale of all defaults is the Sauter diameter.
    options : mapping of str to object
        The options of `Drum`, each within its limits; None stands for the default.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """
    given = {name: value for name, value in options.items() if value is not None}
    real = sizes.real
    diameter, largest = real.sauter_diameter, max(real.diameters)
    radius = given.get("drum_radius", max(_RADIUS * diameter, _LEAST_RADIUS * largest))
    length = given.get("drum_length", max(_LENGTH * diameter, _LEAST_LENGTH * largest))
    gravity, fill_level = float(given["gravity"]), given["fill_level"]
    size = min(range(len(sizes.diameters)), key=lambda i: abs(real.diameters[i] - diameter))
    bed = fill_level * math.pi * radius**2 * length
    froude = given.get("froude_number", _FROUDE_NUMBER)
    speed = given.get("rotational_speed", math.sqrt(froude * gravity / radius))
    natural, turn = natural_time(sizes, gravity), 2 * math.pi / speed
    setup = DrumSetup(
        drum_radius=radius,
        drum_length=length,
        fill_level=fill_level,
        rotational_speed=speed,
        discarded_turns=given["discarded_turns"],
        averaged_turns=given.get("averaged_turns", max(_TURNS, _AVALANCHES * natural / turn)),
        lining_diameter=sizes.diameters[size] if given["lining"] else 0.0,
        lining_size=size,
        particle_count=math.floor(_SOLID_FRACTION * bed / mean_particle_volume(sizes)),
        gravity=gravity,
    )
    faults = [*_faults(setup, sizes, given)]
    if faults:
        raise InputError(faults)
    return setup


def _faults(setup: DrumSetup, sizes: ParticleSizes, given: Mapping[str, Any]) -> Iterator[Fault]:
    largest = max(sizes.diameters)
    least, length = _LEAST_RADIUS * largest, _LEAST_LENGTH * largest
    if setup.drum_radius < least:
        yield Fault(
            "drum_radius",
            f"a drum of {setup.drum_radius:g} m radius is narrower than {_LEAST_RADIUS:g} of the "
            f"largest particles ({largest:g} m).",
            f"Use at least {least:g} m.",
        )
    if setup.drum_length < length:
        yield Fault(
            "drum_length",
            f"a length of {setup.drum_length:g} m repeats after less than {_LEAST_LENGTH:g} of the "
            f"largest particles ({largest:g} m).",
            f"Use at least {length:g} m.",
        )
    if "rotational_speed" in given and "froude_number" in given:
        yield Fault(
            "froude_number",
            f"{given['froude_number']:g} is given beside the rotational_speed "
            f"{given['rotational_speed']:g} rad/s.",
            "Give one of them.",
        )
    froude = setup.rotational_speed**2 * setup.drum_radius / setup.gravity
    if froude > 1:
        slowest = math.sqrt(setup.gravity / setup.drum_radius)
        yield Fault(
            "rotational_speed",
            f"{setup.rotational_speed:g} rad/s is a Froude number of {froude:.3g}: above 1 the "
            "particles are carried all the way round.",
            f"Use less than {slowest:g} rad/s; the default is a Froude number of "
            f"{_FROUDE_NUMBER:g}.",
        )
    lengths = {"drum_radius": setup.drum_radius, "drum_length": setup.drum_length}
    too_many = [*count_faults(setup.particle_count, lengths, count_is_given=False)]
    yield from too_many
    if not too_many and setup.drum_radius >= least:
        yield from _room_faults(setup, sizes)


def _room_faults(setup: DrumSetup, sizes: ParticleSizes) -> Iterator[Fault]:
    """Particles begin at places all over the drum, none touching another."""
    room = math.pi * (setup.clear_radius - max(sizes.diameters) / 4) ** 2 * setup.drum_length
    fraction = setup.particle_count * mean_particle_volume(sizes) / room
    if fraction > _LARGEST_FRACTION:
        highest = math.floor(100 * setup.fill_level * _LARGEST_FRACTION / fraction) / 100
        yield Fault(
            "fill_level",
            f"{setup.fill_level:g} leaves no room to place {setup.particle_count} particles at "
            "random.",
            f"Use at most {highest:g}, or a larger drum.",
        )
