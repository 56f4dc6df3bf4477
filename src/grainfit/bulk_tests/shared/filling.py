"""Filling of containers: how many particles, how they come to rest, and what is impossible."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.shared import messages
from grainfit.errors import Fault
from grainfit.formatting import unit_for_people
from grainfit.materials.sizes import ParticleSizes
from grainfit.one_line import OneLine
from grainfit.scenes.conditions import AtRest
from grainfit.scenes.packing import (
    MOST_PARTICLES,
    Footprint,
    Round,
    column_height,
    factor_for_fewer,
    mean_particle_volume,
)
from grainfit.scenes.scene import Stage, natural_speed, natural_time

#: Solid fraction to calculate the number of particles of beds that are struck off: a settled bed is
#: looser, so that it rises above the strike-off height. That of other beds is the one of a loose
#: bed: they settle lower than planned.
_OVERFULL_MONOSIZE = 0.66
_OVERFULL_POLYDISPERSE = 0.70
LOOSE = 0.58
#: A bed that is struck off needs this share of the calculated particles at least.
_FEWEST = 0.95
#: Narrowest cylinder, in diameters of the largest particles.
_NARROWEST_CYLINDER = 4.0
#: Shortest time of the fill stage, and the default of the longest in which the bed may come to
#: rest, over the time in which a particle falls from the top of the column.
_SHORTEST_FILL = 1.7
_PATIENCE = 10.0
#: Usual time of the fill stage over the shortest one.
_USUAL_SHARE = 1.25
#: Quiet speed over sqrt(g d), and time between two looks over sqrt(d/g). The kinetic energy is that
#: of one particle in a thousand that falls a fifth of its diameter.
_QUIET_SPEED = 0.02
_CHECK_INTERVAL = 1.57


@dataclass(frozen=True)
class Filling(OneLine):
    """Particles that fill a container, and when they are at rest; times in s, lengths in m.

    Parameters
    ----------
    particle_count : int
        Particles rained in.
    column_height : float
        Height of the column of particles before it falls.
    gravity : float
        m/s^2.
    quiet_speed : float
        A bed is at rest when its kinetic energy is less than if every particle had this speed, m/s.
    check_interval : float
        Simulated time between two checks of the kinetic energy.
    """

    particle_count: int
    column_height: float
    gravity: float
    quiet_speed: float
    check_interval: float

    @property
    def _fall_time(self) -> float:
        """Time in which a particle falls from the top of the column, s."""
        return math.sqrt(2 * self.column_height / self.gravity)

    @property
    def fill_time(self) -> float:
        """Shortest time of the fill stage: the particles have fallen by then."""
        return _SHORTEST_FILL * self._fall_time

    @property
    def usual_time(self) -> float:
        """Estimate of the time of the fill stage: the bed is at rest soon after the shortest."""
        return _USUAL_SHARE * self.fill_time

    @property
    def settling_time_limit(self) -> float:
        """Default of the longest time in which a bed may come to rest: ten times the fall."""
        return _PATIENCE * self._fall_time

    def stage(self, settling_time_limit: float, snapshot: str) -> Stage:
        """Return the first stage of a bulk test: the column falls and comes to rest.

        Parameters
        ----------
        settling_time_limit : float
            Longest simulated time beyond the shortest one, s.
        snapshot : str
            Name of the snapshot of the bed.
        """
        return Stage(
            "fill",
            AtRest(self.fill_time + settling_time_limit, at_least=self.fill_time),
            "the column falls and comes to rest",
            is_closed=True,
            snapshot=snapshot,
        )


def plan_filling(
    sizes: ParticleSizes, footprint: Footprint, height: float, gravity: float
) -> Filling:
    """Return the particles that fill a container up to about a height.

    Parameters
    ----------
    sizes : ParticleSizes
        Particle size distribution.
    footprint : Footprint
        Cross-section of the container.
    height : float
        Height of the bed at a solid fraction of 0.58, m; it settles lower.
    gravity : float
        m/s^2.
    """
    count = math.ceil(LOOSE * (footprint.area * height) / mean_particle_volume(sizes))
    column = column_height(sizes, count, footprint)
    return Filling(
        particle_count=count,
        column_height=column,
        gravity=gravity,
        quiet_speed=_QUIET_SPEED * natural_speed(sizes, gravity),
        check_interval=_CHECK_INTERVAL * natural_time(sizes, gravity),
    )


def particles_to_fill(sizes: ParticleSizes, radius: float, height: float) -> int:
    """Return the number of particles that fill a cylinder beyond a height, to be struck off.

    Parameters
    ----------
    sizes : ParticleSizes
        Particle size distribution.
    radius, height : float
        Inner radius of the cylinder and strike-off height, m.
    """
    filling = _OVERFULL_MONOSIZE if len(sizes.diameters) == 1 else _OVERFULL_POLYDISPERSE
    volume = Round(radius).area * height
    return math.ceil(filling * volume / mean_particle_volume(sizes) / 10) * 10


def cylinder_faults(sizes: ParticleSizes, radius: float) -> Iterator[Fault]:
    """Iterate over what is impossible about the option ``cylinder_radius``, m."""
    largest = max(sizes.diameters)
    if 2 * radius < _NARROWEST_CYLINDER * largest:
        yield messages.CYLINDER_IS_NARROW.fault(
            "cylinder_radius",
            radius=radius,
            fewest=_NARROWEST_CYLINDER,
            largest=largest,
            least=least_radius(sizes),
        )


def least_radius(sizes: ParticleSizes) -> float:
    """Return the radius of the narrowest cylinder for particles, m."""
    return _NARROWEST_CYLINDER / 2 * max(sizes.diameters)


def count_faults(
    count: int, dimensions: Mapping[str, float], count_is_given: bool = False, unit: str = "m"
) -> Iterator[Fault]:
    """Iterate over what is impossible about the number of particles.

    Parameters
    ----------
    count : int
        Particles rained in.
    dimensions : mapping of str to float
        Options that the number follows from; the largest of them is named.
    count_is_given : bool
        The user gave the number, as ``particle_count``, and not the dimensions alone.
    unit : str
        Of the dimensions.
    """
    if count <= MOST_PARTICLES:
        return
    largest = max(dimensions, key=lambda name: dimensions[name])
    shown = unit_for_people(unit)
    container = ", ".join(f"{name} {value:g} {shown}" for name, value in dimensions.items())
    yield messages.TOO_MANY_PARTICLES.fault(
        "particle_count" if count_is_given else largest,
        count=count,
        most=MOST_PARTICLES,
        factor=factor_for_fewer(count),
        container=container,
    )


def strike_off_faults(
    sizes: ParticleSizes, radius: float, strike_off: float, count: int
) -> Iterator[Fault]:
    """Iterate over why a cylinder is not filled up to its strike-off height.

    Parameters
    ----------
    sizes : ParticleSizes
        Particle size distribution.
    radius, strike_off : float
        Options ``cylinder_radius`` and ``strike_off_height``, m.
    count : int
        Option ``particle_count``.
    """
    needed = particles_to_fill(sizes, radius, strike_off)
    if count < _FEWEST * needed:
        yield messages.NOT_FILLED.fault(
            "particle_count", count=count, strike_off=strike_off, needed=needed
        )
