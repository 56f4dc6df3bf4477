"""Geometry and procedure of a compression test: defaults resolved, impossible values rejected."""

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
from grainfit.bulk_tests.shared.stress import scaled_stress, softness_faults
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Round, column_height
from grainfit.scenes.scene import Load, natural_speed, natural_time

#: The default stress for particles of 10 mm on Earth.
_REFERENCE_STRESS = 10e3
_SEATING_SHARE = 0.05

#: Lowest bed, in diameters of the largest particles.
_SHALLOWEST_BED = 4.0

#: Young's modulus over stress below which particles overlap by more than 2 % of their diameter.
SMALLEST_STIFFNESS = 1000.0
#: Largest weight of the bed over its cross-section, as a share of the stress.
_LARGEST_WEIGHT = 0.5
#: Solid fraction of a bed, to estimate its weight and its waves.
_SOLID_FRACTION = 0.57
#: Piston speed over sqrt(stress / density): half of it gives the same moduli within 1 %.
_SPEED = 0.0065
#: Modulus of a bed when it is unloaded, over sqrt(E stress).
_BED_MODULUS = 2.0
#: The control is a dashpot that pulls the piston to its load. Its impedance over that of the bed
#: (density times wave speed): 1 would swallow waves, but loose beds are softer than estimated.
_DASHPOT = 0.5
#: Records of a stage while the piston travels as far as an elastic bed would yield.
_RECORDS = 50


@dataclass(frozen=True)
class CompressionSetup:
    """Geometry and procedure of a compression test; lengths in m, times in s, stresses in Pa.

    Parameters
    ----------
    particle_count : int
        Particles rained in.
    cylinder_radius, strike_off_height : float
        Inner radius of the pot, and height above its floor at which the bed is struck off.
    column_height : float
        Height of the column of particles before it falls.
    stress, seating_stress : float
        Stress of the piston on the bed, and that under which strain is zero.
    piston_speed : float, optional
        Largest speed of the piston, m/s; None follows stress and density.
    piston_start : float
        Height of the piston above the floor before it moves.
    gravity : float
        m/s^2.
    quiet_speed : float
        A bed is at rest when its kinetic energy is less than if every particle had this speed, m/s.
    check_interval : float
        Simulated time between two looks at the end of a stage.
    fill_time : float
        Shortest simulated time of the fill stage: the particles have fallen by then.
    settling_time_limit : float
        Longest simulated time in which the bed may come to rest.
    """

    particle_count: int
    cylinder_radius: float
    strike_off_height: float
    column_height: float
    stress: float
    seating_stress: float
    piston_speed: float | None
    piston_start: float
    gravity: float
    quiet_speed: float
    check_interval: float
    fill_time: float
    settling_time_limit: float

    @property
    def area(self) -> float:
        """Cross-section of the pot, m^2."""
        return math.pi * self.cylinder_radius**2

    def largest_speed(self, material: Mapping[str, float]) -> float:
        """Return the largest speed of the piston, m/s."""
        density = material["particle.density"]
        return self.piston_speed or _SPEED * math.sqrt(self.stress / density)

    def travel_time(self, material: Mapping[str, float]) -> float:
        """Return the time in which the piston crosses half of the pot at its largest speed, s."""
        return self.strike_off_height / 2 / self.largest_speed(material)

    def record_interval(self, material: Mapping[str, float]) -> float:
        """Return the simulated time between two records of stress and strain, s."""
        strain = self.stress / _bed_modulus(material, self.stress)
        return strain * self.strike_off_height / self.largest_speed(material) / _RECORDS

    def load(self, stress: float, material: Mapping[str, float]) -> Load:
        """Return the motion of the piston to a stress, Pa.

        Its speed is proportional to the missing force, as with a dashpot: that is stable for every
        bed. Far from the stress it has its largest speed.
        """
        modulus = _bed_modulus(material, stress)
        density = _SOLID_FRACTION * material["particle.density"]
        impedance = math.sqrt(density * modulus) * self.area
        speed, gain = self.largest_speed(material), 1 / (_DASHPOT * impedance)
        return Load("z", -stress * self.area, speed, gain)

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Yield why the test means nothing with a material, of which not all need be known."""
        yield from softness_faults(
            "stress",
            self.stress,
            material,
            SMALLEST_STIFFNESS,
            "are compressed, not the bed.",
        )
        density = material.get("particle.density")
        if density is not None:
            weight = _SOLID_FRACTION * density * self.gravity * self.strike_off_height
            if weight > _LARGEST_WEIGHT * self.stress:
                yield Fault(
                    "stress",
                    f"{self.stress:g} Pa is not much more than the bed's own weight of about "
                    f"{weight:.3g} Pa (particle.density {density:g} kg/m^3).",
                    f"Use at least {weight / _LARGEST_WEIGHT:.2g} Pa, or a lower "
                    "strike_off_height.",
                )


def _bed_modulus(material: Mapping[str, float], stress: float) -> float:
    """Estimate the modulus of a bed that is unloaded, Pa."""
    return _BED_MODULUS * math.sqrt(material["particle.youngs_modulus"] * stress)


def plan_setup(sizes: ParticleSizes, options: Mapping[str, float | None]) -> CompressionSetup:
    """Resolve every default of a compression test.

    Parameters
    ----------
    sizes : ParticleSizes
        The length scale of all defaults is the Sauter diameter.
    options : mapping of str to float or None
        The options of `Compression`, each within its limits; None stands for the default.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """
    given = {name: value for name, value in options.items() if value is not None}
    real, gravity = sizes.real, given["gravity"]
    diameter, deepest = real.sauter_diameter, _SHALLOWEST_BED * max(real.diameters)
    radius = given.get("cylinder_radius", max(5 * diameter, least_radius(real)))
    fill = given.get("strike_off_height", max(8 * diameter, deepest))
    stress = given.get("stress", scaled_stress(_REFERENCE_STRESS, real, gravity))
    seating = given.get("seating_stress", _SEATING_SHARE * stress)
    count = int(given.get("particle_count", particles_to_fill(sizes, radius, fill)))
    faults = [*_shape_faults(sizes, radius, fill)]
    if not faults:
        lengths = {"cylinder_radius": radius, "strike_off_height": fill}
        faults += count_faults(count, lengths, count_is_given="particle_count" in given)
        faults += strike_off_faults(sizes, radius, fill, count)
    faults += _stress_faults(stress, seating)
    if faults:
        raise InputError(faults)
    height = column_height(sizes, count, Round(radius))
    fall = Fall(height, gravity)
    return CompressionSetup(
        particle_count=count,
        cylinder_radius=radius,
        strike_off_height=fill,
        column_height=height,
        stress=stress,
        seating_stress=seating,
        piston_speed=given.get("piston_speed"),
        # Above all particles whose centre is not above the height at which they are struck off.
        piston_start=fill + 0.501 * max(sizes.diameters),
        gravity=gravity,
        quiet_speed=0.0128 * natural_speed(sizes, gravity),
        check_interval=0.5 * natural_time(sizes, gravity),
        fill_time=fall.fill_time,
        settling_time_limit=given.get("settling_time_limit", fall.settling_time_limit),
    )


def _shape_faults(sizes: ParticleSizes, radius: float, fill: float) -> Iterator[Fault]:
    largest = max(sizes.diameters)
    yield from cylinder_faults(sizes, radius)
    if fill < _SHALLOWEST_BED * largest:
        yield Fault(
            "strike_off_height",
            f"a bed of {fill:g} m is less than {_SHALLOWEST_BED:g} of the largest particles "
            f"({largest:g} m) deep.",
            f"Use at least {_SHALLOWEST_BED * largest:g} m.",
        )


def _stress_faults(stress: float, seating: float) -> Iterator[Fault]:
    if seating > 0.4 * stress:
        yield Fault(
            "seating_stress",
            f"{seating:g} Pa leaves no curve between it and the stress of {stress:g} Pa.",
            f"Use about {_SEATING_SHARE * stress:g} Pa (the default).",
        )
