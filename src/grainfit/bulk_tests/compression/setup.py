"""Geometry and procedure of a compression test: what follows from its options and is possible."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property

from grainfit.bulk_tests.compression import messages
from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.filling import (
    Filling,
    count_faults,
    cylinder_faults,
    particles_to_fill,
    strike_off_faults,
)
from grainfit.bulk_tests.shared.servo import Control
from grainfit.bulk_tests.shared.stress import scaled_stress, softness_faults
from grainfit.errors import Fault
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
_CONTROL = Control(overcome=0.85, slower=1.6)
#: Records of a stage while the piston travels as far as an elastic bed would yield.
_RECORDS = 50


class CompressionSetup(Setup):
    """Geometry and procedure of a compression test."""

    @property
    def usual_height(self) -> float:
        """Default of the height at which the bed is struck off, m."""
        return max(8 * self.d, _SHALLOWEST_BED * max(self.real.diameters))

    @property
    def usual_stress(self) -> float:
        """Default of the stress, Pa. It does not follow the density of the particles."""
        return scaled_stress(_REFERENCE_STRESS, self.real, self.gravity)

    @property
    def usual_seating(self) -> float:
        """Default of the seating stress, Pa."""
        return _SEATING_SHARE * self.stress

    @property
    def usual_count(self) -> int:
        """Default of the number of particles."""
        return particles_to_fill(self.sizes, self.cylinder_radius, self.strike_off_height)

    @property
    def piston_start(self) -> float:
        """Height of the piston before it moves, m: above particles that are not struck off."""
        return self.strike_off_height + 0.501 * self.largest

    @cached_property
    def filling(self) -> Filling:
        """Particles rained in, and when they are at rest."""
        radius, count = self.cylinder_radius, self.particle_count
        return Filling(
            particle_count=count,
            column_height=column_height(self.sizes, count, Round(radius)),
            gravity=self.gravity,
            quiet_speed=0.0128 * natural_speed(self.sizes, self.gravity),
            check_interval=0.5 * natural_time(self.sizes, self.gravity),
        )

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
        bed, and slower where the dashpots of its contacts would overcome it. Far from the stress it
        has its largest speed.
        """
        modulus = _bed_modulus(material, stress)
        density = _SOLID_FRACTION * material["particle.density"]
        impedance = math.sqrt(density * modulus) * self.area
        usual = _DASHPOT * impedance
        d = self.sizes.sauter_diameter
        dashpot = _CONTROL.dashpot(usual, self.area, d, stress, material)
        return Load("z", -stress * self.area, self.largest_speed(material), 1 / dashpot)

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
                yield messages.BED_IS_HEAVY.fault(
                    "stress",
                    stress=self.stress,
                    weight=weight,
                    density=density,
                    least=weight / _LARGEST_WEIGHT,
                )

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the pot, its filling, and the stresses."""
        yield [*self._bed_faults(), *self._stress_faults()]

    def _bed_faults(self) -> Iterator[Fault]:
        radius, height, count = self.cylinder_radius, self.strike_off_height, self.particle_count
        if faults := [*cylinder_faults(self.sizes, radius), *self._depth_faults()]:
            yield from faults
            return
        lengths = {"cylinder_radius": radius, "strike_off_height": height}
        yield from count_faults(count, lengths, self.is_given("particle_count"))
        yield from strike_off_faults(self.sizes, radius, height, count)

    def _depth_faults(self) -> Iterator[Fault]:
        height, lowest = self.strike_off_height, _SHALLOWEST_BED * self.largest
        if height < lowest:
            yield messages.BED_IS_SHALLOW.fault(
                "strike_off_height",
                height=height,
                fewest=_SHALLOWEST_BED,
                largest=self.largest,
                lowest=lowest,
            )

    def _stress_faults(self) -> Iterator[Fault]:
        stress, seating = self.stress, self.seating_stress
        if seating > 0.4 * stress:
            yield messages.NO_CURVE.fault(
                "seating_stress", seating=seating, stress=stress, usual=_SEATING_SHARE * stress
            )


def _bed_modulus(material: Mapping[str, float], stress: float) -> float:
    """Estimate the modulus of a bed that is unloaded, Pa."""
    return _BED_MODULUS * math.sqrt(material["particle.youngs_modulus"] * stress)
