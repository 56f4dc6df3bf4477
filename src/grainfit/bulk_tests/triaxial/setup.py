"""Geometry and procedure of a triaxial test: what follows from its options and is possible."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property

from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.stress import scaled_stress, softness_faults
from grainfit.bulk_tests.triaxial import messages
from grainfit.errors import Fault
from grainfit.scenes.packing import MOST_PARTICLES, factor_for_fewer, mean_particle_volume
from grainfit.scenes.scene import Load, Velocity

#: The default stress for particles of 10 mm on Earth.
_REFERENCE_STRESS = 10e3
#: Young's modulus over confining stress below which particles are compressed, not the bed.
SMALLEST_STIFFNESS = 1000.0
#: Shortest side of the box, in diameters of the largest particles.
_SMALLEST = 6.0
#: Solid fraction that gives the number of particles.
_SOLID_FRACTION = 0.6
#: Lengths of the box at the beginning over those under the confining stress.
_ROOM = 1.4
#: Largest speed of the walls over sqrt(stress / density).
_CLOSING_SPEED = 0.1
#: Longest time in which the stress is reached, over the time of closing.
_CLOSING_SHARE = 20.0
#: Stress of a wall's dashpot over its speed and sqrt(stress density): a bed that dilates pushes the
#: side walls with 3 % more than the stress; a much smaller one makes walls swing.
_DASHPOT = 2.0
#: Share of the strain that is simulated beyond the wanted one: a loose bed is higher than planned.
_SURPLUS = 0.1
#: Records of a run.
_RECORDS = 400
#: Walls that stand and walls that move, by axis.
SIDES = {"x": ("left", "right"), "y": ("front", "back"), "z": ("bottom", "top")}


class TriaxialSetup(Setup):
    """Geometry and procedure of a triaxial test."""

    @property
    def usual_stress(self) -> float:
        """Default of the confining stress, Pa."""
        return scaled_stress(_REFERENCE_STRESS, self.real, self.gravity)

    def usual(self, diameters: float) -> float:
        """Return the default of a length, m."""
        return max(diameters * self.d, _SMALLEST * max(self.real.diameters))

    @property
    def particle_count(self) -> int:
        """Number of particles."""
        return round(self._count)

    @cached_property
    def _count(self) -> float:
        bed = _SOLID_FRACTION * self.width**2 * self.height
        return float(bed / mean_particle_volume(self.sizes))

    @property
    def first_width(self) -> float:
        """Width of the box at the beginning, m."""
        return float(_ROOM * self.width)

    @property
    def first_height(self) -> float:
        """Height of the box at the beginning, m."""
        return float(_ROOM * self.height)

    def speed(self, material: Mapping[str, float]) -> float:
        """Return sqrt(stress / density), m/s."""
        return math.sqrt(self.confining_stress / material["particle.density"])

    def strain_rate(self, material: Mapping[str, float]) -> float:
        """Return the axial strain rate at the planned height, 1/s."""
        return float(self.inertial_number / self.sizes.sauter_diameter * self.speed(material))

    def closing_time(self, material: Mapping[str, float]) -> float:
        """Return the time in which the walls close the box at their largest speed, s."""
        return (_ROOM - 1) * float(self.height) / (_CLOSING_SPEED * self.speed(material))

    def closing_limit(self, material: Mapping[str, float]) -> float:
        """Return the longest time in which the stress is reached, s."""
        return _CLOSING_SHARE * self.closing_time(material)

    def compression_time(self, material: Mapping[str, float]) -> float:
        """Return the time of the compression, s."""
        return (1 + _SURPLUS) * float(self.axial_strain) / self.strain_rate(material)

    def record_interval(self, material: Mapping[str, float]) -> float:
        """Return the simulated time between two records, s."""
        return self.compression_time(material) / _RECORDS

    @property
    def first_lengths(self) -> dict[str, float]:
        """Lengths of the box at the beginning by axis, m."""
        return {"x": self.first_width, "y": self.first_width, "z": self.first_height}

    def confinement(self, material: Mapping[str, float]) -> dict[str, Load]:
        """Return the motions of three walls that press with the confining stress.

        Speeds are proportional to the missing force, as with a dashpot.
        """
        lengths = self.first_lengths
        impedance = _DASHPOT * math.sqrt(self.confining_stress * material["particle.density"])
        found = {}
        for axis, (_, wall) in SIDES.items():
            others = [one for one in SIDES if one != axis]
            area = math.prod(lengths[one] for one in others)
            found[wall] = Load(
                axis,
                -self.confining_stress * area,
                # All sides close at once.
                _CLOSING_SPEED * self.speed(material) * lengths[axis] / max(lengths.values()),
                # Of the area that is left when they are closed.
                _ROOM**2 / (impedance * area),
                tuple(SIDES[one] for one in others),
            )
        return found

    def piston(self, material: Mapping[str, float]) -> Velocity:
        """Return the motion of the upper wall that compresses the bed."""
        return Velocity("z", -self.strain_rate(material) * float(self.height))

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over why the test means nothing with a material, not all of which is known."""
        return softness_faults(
            "confining_stress",
            self.confining_stress,
            material,
            SMALLEST_STIFFNESS,
            "are compressed, not the bed.",
        )

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the lengths and strains, then the particles."""
        lengths = {"width": _SMALLEST, "height": _SMALLEST}
        yield [*self.short_faults(lengths), *self._strain_faults()]
        yield [*self._count_faults()]

    def _strain_faults(self) -> Iterator[Fault]:
        if self.averaged_strain > self.axial_strain / 2:
            yield messages.NO_CURVE.fault(
                "averaged_strain", averaged=self.averaged_strain, strain=self.axial_strain
            )

    def _count_faults(self) -> Iterator[Fault]:
        if self._count > MOST_PARTICLES:
            yield messages.TOO_MANY_PARTICLES.fault(
                "width",
                width=self.width,
                height=self.height,
                count=self._count,
                most=MOST_PARTICLES,
                factor=factor_for_fewer(self._count),
            )
