"""Geometry and procedure of a shear test: what follows from its options and is possible."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.servo import Control
from grainfit.bulk_tests.shared.stress import scaled_stress, softness_faults
from grainfit.bulk_tests.shear import messages
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.glued import Glued
from grainfit.scenes.packing import MOST_PARTICLES, factor_for_fewer, mean_particle_volume
from grainfit.scenes.scene import Load, Velocity

#: The default stress for particles of 10 mm on Earth.
_REFERENCE_STRESS = 500.0
#: Young's modulus over stress, below which overlaps change the angle by more than two degrees.
SMALLEST_STIFFNESS = 700.0
#: Smallest periods and smallest gap, in diameters of the largest particles.
_SMALLEST = {"length": 6.0, "depth": 4.0, "gap": 7.0}
#: Solid fraction that gives the number of particles: that of a bed in shear.
_SOLID_FRACTION = 0.58
#: Layer at a plate that its own particles fill, over their diameter.
_LAYER = 0.5
#: Largest displacement between two snapshots, over the length: beyond half of it, a particle that
#: lags behind could not be told from one that went around.
DISPLACEMENT = 0.4
#: Speed of the plate while it closes the gap, over sqrt(stress / density).
_CLOSING_SPEED = 0.5
_CLOSING_SHARE = 1.3
#: Stress of the plate's dashpot over its speed and sqrt(stress density). The bed dilates at a tenth
#: of the shear rate times its depth at most, so the dashpot takes a small share of the stress; in
#: one time step the plate still makes up for less than a fifth of a missing force.
_DASHPOT = 2.8
CONTROL = Control(overcome=1.3, slower=0.77)
#: Records per strain of one.
_RECORDS = 200
#: Distance of glued particles of the one size of a bed, and their roughness, in diameters. Between
#: particles that are glued more loosely, others leak through.
_SPACING = 1.0
_ROUGHNESS = 0.35
#: Radius of the hole between four particles that touch, in their diameters.
_HOLE = math.sqrt(0.5) - 0.5


class ShearSetup(Setup):
    """Geometry and procedure of a shear test."""

    @property
    def diameter(self) -> float:
        """Sauter diameter of the simulated particles, m."""
        return self.sizes.sauter_diameter

    @property
    def usual_stress(self) -> float:
        """Default of the normal stress, Pa."""
        return scaled_stress(_REFERENCE_STRESS, self.real, self.gravity)

    def usual(self, name: str, diameters: float) -> float:
        """Return the default of a length, m."""
        return max(diameters * self.d, _SMALLEST[name] * max(self.real.diameters))

    @cached_property
    def plate(self) -> PlateLayout:
        """Layout of both plates."""
        return plate_layout(self.sizes, self.length, self.depth)

    @property
    def particle_count(self) -> int:
        """Number of loose particles."""
        return round(self._count)

    @cached_property
    def _count(self) -> float:
        height = self.gap - 2 * _LAYER * self.plate.diameter
        bed = _SOLID_FRACTION * self.length * self.depth * height
        return bed / mean_particle_volume(self.sizes)

    @property
    def area(self) -> float:
        """Area of a plate, m^2."""
        return self.length * self.depth

    @property
    def blocks(self) -> int:
        """Number of equal parts of the averaged strain, each with a snapshot at its end."""
        return max(2, math.ceil(self.averaged_strain * self.gap / (DISPLACEMENT * self.length)))

    def shear_rate(self, material: Mapping[str, float]) -> float:
        """Return the shear rate at the usual gap, 1/s."""
        return self.inertial_number / self.diameter * self.speed(material)

    def speed(self, material: Mapping[str, float]) -> float:
        """Return sqrt(stress / density), m/s."""
        return math.sqrt(self.normal_stress / material["particle.density"])

    def closing_time(self, travel: float, material: Mapping[str, float]) -> float:
        """Return the time in which the upper plate closes the gap by a distance, s."""
        usual = _CLOSING_SHARE * travel / (_CLOSING_SPEED * self.speed(material))
        dashpots = self.usual_dashpot(material), self._dashpot(material)
        first, second = (self._free_speed(dashpot, material) for dashpot in dashpots)
        return usual * (first / second)

    def _free_speed(self, dashpot: float, material: Mapping[str, float]) -> float:
        """Return the speed of a plate that touches nothing, m/s; see `Load`."""
        largest = _CLOSING_SPEED * self.speed(material)
        wanted = self.normal_stress * self.area / dashpot
        return wanted / math.hypot(1.0, wanted / largest)

    def usual_dashpot(self, material: Mapping[str, float]) -> float:
        """Return the damping of the control of a plate that no contacts overcome, N s/m."""
        return _DASHPOT * math.sqrt(self.normal_stress * material["particle.density"]) * self.area

    def _dashpot(self, material: Mapping[str, float]) -> float:
        """Return the damping of the control of the plate, N s/m."""
        usual = self.usual_dashpot(material)
        return CONTROL.dashpot(usual, self.area, self.diameter, self.normal_stress, material)

    def record_interval(self, material: Mapping[str, float]) -> float:
        """Return the simulated time between two records, s."""
        return 1 / self.shear_rate(material) / _RECORDS

    def motions(
        self, material: Mapping[str, float], stress: float | None = None
    ) -> tuple[Velocity, Load]:
        """Return the motions of the upper plate: it shears at its velocity and presses.

        Along z its speed is proportional to the missing force, as with a dashpot of a plate without
        mass (da Cruz et al. 2005, Phys. Rev. E 72, 021309).

        Parameters
        ----------
        material : mapping of str to float
            Material parameters by dotted name.
        stress : float, optional
            Another normal stress, Pa. The dashpot stays as it is: a weaker one swings from step to
            step, because the dashpots of the contacts answer the plate's speed at once. The plate
            shears so much slower that a bed that dilates adds the same share of the stress.
        """
        stress = stress or self.normal_stress
        slower = stress / self.normal_stress
        return (
            Velocity("x", self.shear_rate(material) * self.gap * slower),
            Load(
                "z",
                -stress * self.area,
                _CLOSING_SPEED * self.speed(material),
                1 / self._dashpot(material),
            ),
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

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the lengths, then the number of particles."""
        yield [*self.short_faults(_SMALLEST)]
        yield [*self._count_faults()]

    def _count_faults(self) -> Iterator[Fault]:
        if self._count > MOST_PARTICLES:
            yield messages.TOO_MANY_PARTICLES.fault(
                "gap",
                length=self.length,
                depth=self.depth,
                gap=self.gap,
                count=self._count,
                most=MOST_PARTICLES,
                factor=factor_for_fewer(self._count),
            )


@dataclass(frozen=True)
class PlateLayout:
    """A closed layer: a square lattice whose particles stand out by different heights.

    Parameters
    ----------
    size_index : int
        Index of the glued particles' diameter in the particle size distribution.
    diameter : float
        Of the glued particles, m.
    columns, rows : int
        Particles along x and y.
    roughness : float
        Largest deviation of a particle from the middle of the plate, m.
    """

    size_index: int
    diameter: float
    columns: int
    rows: int
    roughness: float

    @property
    def count(self) -> int:
        """Number of glued particles of a plate."""
        return self.columns * self.rows

    @property
    def reach(self) -> float:
        """Distance from the middle of a plate to its farthest surface, m."""
        return self.roughness + self.diameter / 2

    def glued(self, length: float, depth: float, z: float, random: np.random.Generator) -> Glued:
        """Return a plate at a height, with random heights of its particles.

        Parameters
        ----------
        length, depth : float
            Periods along x and y, m.
        z : float
            Height of the middle of the plate: the mean of its particles, m.
        random : Generator
            Source of the heights.
        """
        x, y = np.meshgrid(
            (np.arange(self.columns) + 0.5) * length / self.columns,
            (np.arange(self.rows) + 0.5) * depth / self.rows,
        )
        heights = random.uniform(-self.roughness, self.roughness, self.count)
        heights = np.clip(heights - heights.mean(), -self.roughness, self.roughness)
        positions = np.column_stack((x.ravel(), y.ravel(), z + heights))
        return Glued(positions, np.full(self.count, self.size_index))


def plate_layout(sizes: ParticleSizes, length: float, depth: float) -> PlateLayout:
    """Return the layout of plates that no particle of a size distribution can pass.

    Glued particles have the size that is nearest to the Sauter diameter. They are as near to each
    other as the smallest particles demand.
    """
    ratios = [abs(math.log(d / sizes.sauter_diameter)) for d in sizes.diameters]
    index = ratios.index(min(ratios))
    diameter, smallest = sizes.diameters[index], min(sizes.diameters)
    share = min(1.0, smallest / diameter)
    spacing = min(_SPACING, math.sqrt(2) * (0.5 + _HOLE * share)) * diameter
    # A lattice that fits a period within a rounding error is not made closer.
    columns, rows = (math.ceil(period / spacing - 1e-9) for period in (length, depth))
    return PlateLayout(index, diameter, columns, rows, _ROUGHNESS * share * diameter)
