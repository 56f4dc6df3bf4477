"""Geometry and procedure of a heap test: every default resolved, impossible values rejected."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.shared.filling import (
    Fall,
    count_faults,
    cylinder_faults,
    least_radius,
    particles_to_fill,
    strike_off_faults,
)
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Round, column_height

#: The defaults are those of a test of 10 mm beads on Earth; other sizes follow by Froude's law.
_REFERENCE_DIAMETER = 0.010
_REFERENCE_GRAVITY = 9.81
#: Default radius of the cylinder, in diameters.
_RADIUS = 6


@dataclass(frozen=True)
class HeapSetup:
    """Geometry and procedure of one heap test; lengths in m, times in s, heights from the plate.

    Parameters
    ----------
    particle_count : int
        Particles rained in.
    cylinder_radius, cylinder_gap : float
        Inner radius, and height of the lower end before lifting.
    column_height : float
        Height of the column of particles before it falls.
    plate_radius, rim_height : float
        Plate under the cylinder; without rim, particles fall off its edge.
    strike_off_height : float
        Particles with their centre above are removed before the lift.
    bulk_density_bottom, bulk_density_top : float
        The bulk density is that of the bed between these heights.
    lift_speed, lift_height : float
        Speed, m/s, and longest travel of the cylinder.
    gravity : float
        m/s^2.
    quiet_speed : float
        A bed is at rest when its kinetic energy is less than if every particle had this speed, m/s.
    check_interval : float
        Simulated time between two checks of the kinetic energy.
    fill_time : float
        Shortest simulated time of the fill stage: the particles have fallen by then.
    settling_time_limit : float
        Longest simulated time in which a bed may come to rest.
    """

    particle_count: int
    cylinder_radius: float
    cylinder_gap: float
    column_height: float
    plate_radius: float
    rim_height: float
    strike_off_height: float
    bulk_density_bottom: float
    bulk_density_top: float
    lift_speed: float
    lift_height: float
    gravity: float
    quiet_speed: float
    check_interval: float
    fill_time: float
    settling_time_limit: float

    def expected_foot(self, angle: float, diameter: float) -> float:
        """Return about the base radius of the heap of this test, m.

        Half a diameter above its base, a cone of the volume of the bed is as wide as the heap, up
        to half a diameter: heaps of glass beads and of rough spheres of 18 to 23 degrees.

        Parameters
        ----------
        angle : float
            Angle of repose, degrees.
        diameter : float
            Of the particles, m.
        """
        slope = math.tan(math.radians(angle))
        base = math.pow(3 * self.cylinder_radius**2 * self.strike_off_height / slope, 1 / 3)
        return base - diameter / 2 / slope


def plan_setup(sizes: ParticleSizes, options: Mapping[str, float | None]) -> HeapSetup:
    """Resolve every default of a heap test.

    Parameters
    ----------
    sizes : ParticleSizes
        The length scale of all defaults is the Sauter diameter, or a larger one where the default
        cylinder would be too narrow for the largest particles.
    options : mapping of str to float or None
        The options of `Heap`, each within its limits; None stands for the default.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """
    given = {name: value for name, value in options.items() if value is not None}
    real, gravity = sizes.real, given["gravity"]
    diameter, narrowest = real.sauter_diameter, 0.0
    if "cylinder_radius" not in given:
        narrowest = least_radius(real)
        diameter = max(diameter, narrowest / _RADIUS)
    # The laboratory lifts its cylinder beside real particles; simulated ones come to rest.
    usual_speed = 0.05 * _froude_speed(diameter, gravity)
    simulated = sizes.sauter_diameter
    froude_time = math.sqrt(simulated / _REFERENCE_DIAMETER * _REFERENCE_GRAVITY / gravity)
    radius = given.get("cylinder_radius", max(_RADIUS * diameter, narrowest))
    strike_off = given.get("strike_off_height", 10.5 * diameter)
    default_count = particles_to_fill(sizes, radius, strike_off)
    count = int(given.get("particle_count", default_count))
    lengths = {"cylinder_radius": radius, "strike_off_height": strike_off}
    too_many = count_faults(count, lengths, count_is_given="particle_count" in given)
    faults = [*cylinder_faults(sizes, radius), *too_many]
    if faults:
        raise InputError(faults)
    height = column_height(sizes, count, Round(radius))
    fall = Fall(height, gravity)
    setup = HeapSetup(
        particle_count=count,
        cylinder_radius=radius,
        cylinder_gap=0.15 * min(sizes.diameters),
        column_height=height,
        plate_radius=given.get("plate_radius", 16 * diameter),
        rim_height=given["rim_height"],
        strike_off_height=strike_off,
        bulk_density_bottom=given.get("bulk_density_bottom", diameter),
        bulk_density_top=given.get("bulk_density_top", 9 * diameter),
        lift_speed=given.get("lift_speed", usual_speed),
        lift_height=given.get("lift_height", 10 * diameter),
        gravity=gravity,
        quiet_speed=0.004 * _froude_speed(simulated, gravity),
        check_interval=0.05 * froude_time,
        fill_time=fall.fill_time,
        settling_time_limit=given.get("settling_time_limit", fall.settling_time_limit),
    )
    faults = [*_geometry_faults(setup, sizes)]
    if faults:
        raise InputError(faults)
    return setup


def _froude_speed(diameter: float, gravity: float) -> float:
    """Return the speed at which a lift of this size looks as one of 10 mm beads at 1 m/s, m/s."""
    return math.sqrt(diameter / _REFERENCE_DIAMETER * gravity / _REFERENCE_GRAVITY)


def _geometry_faults(setup: HeapSetup, sizes: ParticleSizes) -> Iterator[Fault]:
    if setup.plate_radius <= setup.cylinder_radius:
        yield Fault(
            "plate_radius",
            f"a plate of {setup.plate_radius:g} m radius does not carry a cylinder of "
            f"{setup.cylinder_radius:g} m radius.",
            "Make the plate wider or the cylinder narrower.",
        )
    if setup.bulk_density_top - setup.bulk_density_bottom < max(sizes.diameters):
        yield Fault(
            "bulk_density_top",
            f"between {setup.bulk_density_bottom:g} m and {setup.bulk_density_top:g} m there is "
            "less than one particle diameter to measure the bulk density in.",
        )
    if setup.bulk_density_top > setup.strike_off_height:
        yield Fault(
            "bulk_density_top",
            f"{setup.bulk_density_top:g} m is above the strike-off height "
            f"{setup.strike_off_height:g} m.",
            "Measure lower or strike off higher.",
        )
    if setup.rim_height >= setup.strike_off_height:
        yield Fault(
            "rim_height",
            f"{setup.rim_height:g} m is not below the strike-off height "
            f"{setup.strike_off_height:g} m.",
        )
    if setup.lift_height < setup.strike_off_height / 4:
        yield Fault(
            "lift_height",
            f"{setup.lift_height:g} m leaves the cylinder in the heap.",
            f"Use about the strike-off height, {setup.strike_off_height:g} m.",
        )
    yield from strike_off_faults(
        sizes, setup.cylinder_radius, setup.strike_off_height, setup.particle_count
    )
