"""Plane shear: a bed between two rough plates, of which the upper one presses and moves."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.bulk_tests.shared.options import STRESS, laboratory_gravity_option, length_option
from grainfit.bulk_tests.shared.stress import typical_load
from grainfit.bulk_tests.shear import messages
from grainfit.bulk_tests.shear.setup import ShearSetup
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.stiffness import IN_SHEAR, OverlapLaw
from grainfit.checks import Found, check
from grainfit.errors import Fault
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import (
    Column,
    Footprint,
    PeriodicRectangle,
    column_height,
    random_column,
)
from grainfit.scenes.scene import Box, Scene, Stage

#: No stage ends at rest; a solver asks for a speed all the same, over sqrt(stress / density).
_QUIET = 0.01
#: Shear strain between two lines of the solver's log.
_LOOK = 0.1

STRAIN = Quantity("", above_zero=True, highest=1e4)


#: Inertial number up to which shear is quasi-static within the scatter of the angle.
_SLOWEST = 0.01


@check("fast-shear")
def fast_shear(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Shear that is not quasi-static, as that of a shear tester is."""
    number = float(checked.test.inertial_number)
    if number > _SLOWEST:
        yield "inertial_number", messages.FAST_SHEAR(number=number, slowest=_SLOWEST)


@dataclass(frozen=True)
class PlaneShear(BulkTest):
    """A bed between two rough plates, without gravity and periodic in both other directions.

    The upper plate closes the gap, presses with a normal stress and moves sideways, so fast that
    the inertial number is the wanted one. A subclass has the stages, and measures.
    """

    vessel: ClassVar[str] = "gap"
    revision: ClassVar[int] = 2
    checks: ClassVar[Checks] = (fast_shear,)
    #: Both plates are glued particles.
    parts: ClassVar[Parts] = {}
    overlap_law: ClassVar[OverlapLaw] = IN_SHEAR
    worse_ends: ClassVar[Mapping[str, int]] = {MODULUS: 0}
    size_powers: ClassVar[Mapping[str, float | None]] = {}
    #: First line of a deck.
    deck_title: ClassVar[str]

    normal_stress: Amount | None = option(
        STRESS,
        "Stress of the upper plate on the bed. Young's modulus must be at least 700 times as much.",
        example='"500 Pa"',
        default=Derived("500 Pa for d = 10 mm", lambda s: s.usual_stress),
    )
    inertial_number: Amount = option(
        Quantity("", above_zero=True, highest=0.3),
        "Shear rate times d over sqrt(normal stress / particle density): 0.005 is quasi-static, "
        "0.1 a fast flow.",
        example="0.02",
        default=0.02,
    )
    length: Amount | None = length_option("length", 10, "Period along the shear.")
    depth: Amount | None = length_option("depth", 5, "Period across the shear.")
    gap: Amount | None = length_option(
        "gap",
        8.5,
        "Distance between the plates at a solid fraction of 0.58; it gives the number of "
        "particles.",
    )
    transient_strain: Amount = option(
        STRAIN, "Shear strain that is thrown away.", example="1.5", default=1.5
    )
    gravity: Amount = laboratory_gravity_option("sheared")

    setup = cached_property(ShearSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        return scaled(self, scale, length=1, depth=1, gap=1)

    @abstractmethod
    def stages(self, material: Mapping[str, float], travel: float) -> tuple[Stage, ...]:
        """Return the stages, each of which lasts for a given time.

        Parameters
        ----------
        material : mapping of str to float
            Material parameters by dotted name.
        travel : float
            Distance by which the plate closes the gap, m.
        """

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Yield why the test means nothing with a material: too soft for the stress."""
        return self.setup.material_faults(material)

    def stiffness_number(self, material: Mapping[str, float]) -> float:
        """Return Young's modulus of the particles over the normal stress."""
        return material[MODULUS] / self.setup.normal_stress

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the bed."""
        return PeriodicRectangle(self.setup.length, self.setup.depth)

    def column(self, seed: int) -> Column:
        """Return the bed at the beginning."""
        return random_column(self.sizes, self.setup.particle_count, self.footprint, seed)

    def scene(self, material: Mapping[str, float], seed: int) -> Scene:
        """Return the experiment with a material and an insertion seed."""
        test = self.of_material(material)
        column = test.column(seed)
        # Another stream of the same seed: plates do not resemble beds.
        return test._between_plates(column, material, np.random.default_rng([seed, 1]))

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment with a bed of particles from z = 0 upwards."""
        return self._between_plates(column, material, np.random.default_rng(0))

    def _between_plates(
        self, column: Column, material: Mapping[str, float], random: np.random.Generator
    ) -> Scene:
        """Put a column between plates, the lower one at z = 0."""
        setup, plate = self.setup, self.setup.plate
        reach = 1.001 * plate.reach
        top = column.height + 2 * reach
        room = 3 * setup.largest
        return self.scene_with(
            material,
            title=self.deck_title,
            particles=column.raised(reach),
            box=Box((0.0, 0.0, -room), (setup.length, setup.depth, top + room), periodic="xy"),
            walls={},
            glued={
                "lower": plate.glued(setup.length, setup.depth, 0.0, random),
                "upper": plate.glued(setup.length, setup.depth, top, random),
            },
            stages=self.stages(material, top - setup.gap),
            gravity=0.0,
            quiet_speed=setup.speed(material) * _QUIET,
            check_interval=_LOOK / setup.shear_rate(material),
            typical_load=typical_load(setup.normal_stress, setup.diameter, material),
        )

    def closing(self, material: Mapping[str, float], travel: float) -> Stage:
        """Return the stage in which the upper plate closes the gap by a distance, m."""
        setup = self.setup
        return Stage(
            "close",
            Elapsed(setup.closing_time(travel, material)),
            motions={"upper": setup.motions(material)},
            is_closed=True,
            remark=f"the upper plate closes the gap, and presses with {setup.normal_stress:g} Pa",
        )

    @property
    def number_of_particles(self) -> int:
        """Number of particles, glued ones included."""
        return self.setup.particle_count + self.number_of_glued

    @property
    def number_of_glued(self) -> int:
        """Number of particles of both plates."""
        return int(2 * self.setup.plate.count)

    def simulated_time(self, material: Mapping[str, float]) -> float:
        """Estimate the simulated time of a run, s."""
        setup = self.setup
        height = column_height(self.sizes, setup.particle_count, self.footprint)
        travel = height + 2 * setup.plate.reach - setup.gap
        ends = (stage.until for stage in self.stages(material, travel))
        return sum(end.time for end in ends if isinstance(end, Elapsed))
