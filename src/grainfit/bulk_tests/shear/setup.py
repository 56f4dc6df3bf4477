"""Geometry and procedure of a shear test: defaults resolved, impossible values rejected."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.shared.stress import scaled_stress, softness_faults
from grainfit.bulk_tests.shear.plates import PlateLayout, plate_layout
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import MOST_PARTICLES, mean_particle_volume
from grainfit.scenes.scene import Load, Velocity

#: The default stress for particles of 10 mm on Earth.
_REFERENCE_STRESS = 500.0
#: Young's modulus over stress, below which overlaps change the angle by more than two degrees.
SMALLEST_STIFFNESS = 700.0
#: Smallest gap, in diameters of the largest particles, and smallest periods.
_SMALLEST_GAP = 7.0
_SMALLEST_LENGTH, _SMALLEST_DEPTH = 6.0, 4.0
#: Solid fraction that gives the number of particles: that of a bed in shear.
_SOLID_FRACTION = 0.58
#: Layer at a plate that its own particles fill, over their diameter.
_LAYER = 0.5
#: Largest displacement between two snapshots, over the length: beyond half of it, a particle that
#: lags behind could not be told from one that went around.
_DISPLACEMENT = 0.4
#: Speed of the plate while it closes the gap, over sqrt(stress / density).
_CLOSING_SPEED = 0.5
_CLOSING_SHARE = 1.3
#: Stress of the plate's dashpot over its speed and sqrt(stress density). The bed dilates at a tenth
#: of the shear rate times its depth at most, so the dashpot takes a small share of the stress; in
#: one time step the plate still makes up for less than a fifth of a missing force.
_DASHPOT = 2.8
#: Records per strain of one.
_RECORDS = 200


@dataclass(frozen=True)
class ShearSetup:
    """Geometry and procedure of a shear test; lengths in m, times in s, stresses in Pa.

    Parameters
    ----------
    normal_stress : float
        Stress of the upper plate on the bed.
    inertial_number : float
        Shear rate times diameter over sqrt(stress / density).
    length, depth : float
        Periods along x (the direction of shear) and y.
    gap : float
        Distance between the middles of the plates at a usual solid fraction.
    transient_strain, averaged_strain : float
        Shear strain that is thrown away, and over which stresses are averaged.
    particle_count : int
        Loose particles.
    diameter, largest : float
        Sauter diameter, and the largest diameter.
    plate : PlateLayout
        Of both plates.
    gravity : float
        m/s^2: the default stress follows it, and nothing else.
    """

    normal_stress: float
    inertial_number: float
    length: float
    depth: float
    gap: float
    transient_strain: float
    averaged_strain: float
    particle_count: int
    diameter: float
    largest: float
    plate: PlateLayout
    gravity: float

    @property
    def area(self) -> float:
        """Area of a plate, m^2."""
        return self.length * self.depth

    @property
    def blocks(self) -> int:
        """Number of equal parts of the averaged strain, each with a snapshot at its end."""
        return max(2, math.ceil(self.averaged_strain * self.gap / (_DISPLACEMENT * self.length)))

    def shear_rate(self, material: Mapping[str, float]) -> float:
        """Return the shear rate at the usual gap, 1/s."""
        return self.inertial_number / self.diameter * self.speed(material)

    def speed(self, material: Mapping[str, float]) -> float:
        """Return sqrt(stress / density), m/s."""
        return math.sqrt(self.normal_stress / material["particle.density"])

    def closing_time(self, travel: float, material: Mapping[str, float]) -> float:
        """Return the time in which the upper plate closes the gap by a distance, s."""
        return _CLOSING_SHARE * travel / (_CLOSING_SPEED * self.speed(material))

    def record_interval(self, material: Mapping[str, float]) -> float:
        """Return the simulated time between two records, s."""
        return 1 / self.shear_rate(material) / _RECORDS

    def motions(self, material: Mapping[str, float]) -> tuple[Velocity, Load]:
        """Return the motions of the upper plate: it shears at its velocity and presses.

        Along z its speed is proportional to the missing force, as with a dashpot of a plate without
        mass (da Cruz et al. 2005, Phys. Rev. E 72, 021309).
        """
        impedance = math.sqrt(self.normal_stress * material["particle.density"])
        dashpot = _DASHPOT * impedance * self.area
        largest = _CLOSING_SPEED * self.speed(material)
        return (
            Velocity("x", self.shear_rate(material) * self.gap),
            Load("z", -self.normal_stress * self.area, largest, 1 / dashpot),
        )

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over why the test means nothing with a material, not all of which is known."""
        return softness_faults(
            "normal_stress",
            self.normal_stress,
            material,
            SMALLEST_STIFFNESS,
            "change the angle of internal friction.",
        )


def plan_setup(sizes: ParticleSizes, options: Mapping[str, float | None]) -> ShearSetup:
    """Resolve every default of a shear test.

    Parameters
    ----------
    sizes : ParticleSizes
        The length scale of all defaults is the Sauter diameter.
    options : mapping of str to float or None
        The options of `Shear`, each within its limits; None stands for the default.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """
    given = {name: value for name, value in options.items() if value is not None}
    real = sizes.real
    diameter, largest = real.sauter_diameter, max(real.diameters)
    usual = scaled_stress(_REFERENCE_STRESS, real, given["gravity"])
    length = given.get("length", max(10 * diameter, _SMALLEST_LENGTH * largest))
    depth = given.get("depth", max(5 * diameter, _SMALLEST_DEPTH * largest))
    gap = given.get("gap", max(8.5 * diameter, _SMALLEST_GAP * largest))
    faults = [*_size_faults(sizes, length, depth, gap)]
    if faults:
        raise InputError(faults)
    plate = plate_layout(sizes, length, depth)
    height = gap - 2 * _LAYER * plate.diameter
    count = _SOLID_FRACTION * length * depth * height / mean_particle_volume(sizes)
    if count > MOST_PARTICLES:
        raise InputError(
            Fault(
                "gap",
                f"between plates of {length:g} m x {depth:g} m, {gap:g} m apart, are "
                f"{count:.3g} particles; at most {MOST_PARTICLES:g} are allowed.",
                "Use smaller lengths, or larger particles.",
            )
        )
    return ShearSetup(
        normal_stress=given.get("normal_stress", usual),
        inertial_number=given["inertial_number"],
        length=length,
        depth=depth,
        gap=gap,
        transient_strain=given["transient_strain"],
        averaged_strain=given["averaged_strain"],
        particle_count=round(count),
        diameter=sizes.sauter_diameter,
        largest=max(sizes.diameters),
        plate=plate,
        gravity=given["gravity"],
    )


def _size_faults(sizes: ParticleSizes, length: float, depth: float, gap: float) -> Iterator[Fault]:
    largest = max(sizes.diameters)
    for name, value, fewest in (
        ("length", length, _SMALLEST_LENGTH),
        ("depth", depth, _SMALLEST_DEPTH),
        ("gap", gap, _SMALLEST_GAP),
    ):
        if value < (1 - 1e-9) * fewest * largest:
            yield Fault(
                name,
                f"{value:g} m is less than {fewest:g} of the largest particles ({largest:g} m).",
                f"Use at least {fewest * largest:g} m.",
            )
