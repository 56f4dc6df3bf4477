"""The shear cell: preshear to steady flow, then shear to failure under smaller normal stresses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import Checks
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.options import STRESS, length_option
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.shear.flow import (
    COLUMNS,
    Frame,
    Profile,
    Record,
    angle_of,
    block_mean,
    friction_of,
    plate_speed,
    read_frame,
    velocity_profile,
)
from grainfit.bulk_tests.shear.plane_shear import STRAIN, PlaneShear
from grainfit.bulk_tests.shear.validity import require_sheared
from grainfit.bulk_tests.shear.view import ShearView
from grainfit.bulk_tests.shear_cell import messages
from grainfit.bulk_tests.shear_cell.failure import WINDOW, Failure, frictions_with_errors
from grainfit.bulk_tests.shear_cell.setup import ShearCellSetup
from grainfit.bulk_tests.shear_cell.view import ShearCellView, draw_shear_cell
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.checks import Found, check
from grainfit.contact_models.registry import COHESION
from grainfit.errors import RunFailedError
from grainfit.evaluation import Curve, Measured
from grainfit.materials.walls import plain_name
from grainfit.measurement.mohr_circles import ShearTest
from grainfit.measurement.particles import write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity, Whole
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.records import Series
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Stage

_SHOWN = "phi_lin"
#: Snapshots before the first preshear and at the end of a run, and the picture.
_FIRST, _LAST, _PICTURE = "consolidated", "sheared", "shear_cell.png"
#: Share of each preshear that is steady: the second half.
_STEADY = 0.5
#: Largest deviation of the mean normal stress in steady flow: a cohesive bed still settles a little
#: after it has dilated at a failure. The friction is a ratio, and does not care.
_HELD = 0.03
#: Largest deviation of the normal stress at a peak. A cohesive bed that dilates presses by a sixth
#: more; the point counts at the stress that it has.
_HELD_AT_PEAK = 0.25


_CONSOLIDATION = "major_consolidation_stress"
#: Major principal stress of steady flow over the normal stress: 1 / (1 - sin phi) of a circle that
#: touches a line of 5 and of 55 degrees through the origin.
_TIMES_PRESHEAR = (1.1, 5.5)
_STRENGTHS = ("ffc", "unconfined_strength", "cohesion")


@check("no-cohesion", "warning")
def no_cohesion(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Strength of a powder as a target, and a contact law without cohesion."""
    if any(value for name, value in checked.highest.items() if plain_name(name) in COHESION):
        return
    wanted = [name for name in _STRENGTHS if checked.targets.get(name)]
    if wanted:
        yield f"targets.{wanted[0]}", messages.NO_COHESION()


@check("preshear-stress", "warning")
def preshear_stress(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Major consolidation stresses that belong to another normal stress of the preshear."""
    target, stress = checked.targets.get(_CONSOLIDATION), checked.test.setup.normal_stress
    low, high = _TIMES_PRESHEAR
    if target and not low <= target / stress <= high:
        values = {"target": target, "stress": stress, "times": target / stress}
        yield f"targets.{_CONSOLIDATION}", messages.OTHER_PRESHEAR(**values, low=low, high=high)


_USUAL_APPARATUS = VariedOptions(
    "gap",
    Range(0.88, 1.4, power=-1),
    values={"inertial_number": Range(0.005, 0.05, power=0)},
    # The weight of the bed is nothing beside a large stress, which is the limit.
    loads={"normal_stress": Range(5.0, 500.0, power=-0.5)},
    per_load=("cohesion", "unconfined_strength", "major_consolidation_stress"),
    indifferent=(
        "transient_strain",
        # The bed repeats along the shear and across it.
        "length",
        "depth",
        # A dry material fails along a straight line: any of its points tell the same.
        "lowest_stress",
        "highest_stress",
        "points",
        "cycles",
    ),
)


@dataclass(frozen=True)
class ShearCell(PlaneShear):
    """Shear tester: yield locus, cohesion, unconfined strength and flowability.

    A bed between two rough plates, as in `Shear`, flows under the normal stress of the preshear
    until it is steady. Then the load is reduced, and the bed sheared to failure; each further point
    of the yield locus has a preshear of its own. It is the plane counterpart of ring shear testers
    and translational cells (ASTM D6773, ASTM D6128). The normal stresses at failure are evenly
    spaced from the highest to the lowest; all of them are repeated in cycles.

    Examples
    --------
    >>> ShearCell(diameter="10 mm").setup.stresses
    (375.0, 250.0, 125.0)
    """

    type: ClassVar[str] = "shear_cell"
    title: ClassVar[str] = "preshear, then shear to failure"
    checks: ClassVar[Checks] = (*PlaneShear.checks, no_cohesion, preshear_stress)
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS,)
    deck_title: ClassVar[str] = "Shear cell: preshear and shear to failure"
    shown: ClassVar[Shown] = Shown("bed", _SHOWN, snapshot_file(_LAST), _PICTURE)
    enter_instead: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(("internal_friction_angle", "phi"), messages.ENTER_STEADY_ANGLE()),
        **dict.fromkeys(("phi_i", "linear_angle"), messages.ENTER_LINEAR_ANGLE()),
        **dict.fromkeys(("shear_density", "density"), messages.ENTER_DENSITY()),
        **dict.fromkeys(("yield_locus", "points"), messages.ENTER_CURVE()),
        **dict.fromkeys(("sigma_c", "f_c", "fc"), messages.ENTER_STRENGTH()),
        **dict.fromkeys(("sigma_1", "mcs"), messages.ENTER_CONSOLIDATION()),
    }
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "cohesion": ResponseInfo(
            "Pa",
            "c",
            "cohesion: shear stress of the linearised yield locus without a normal stress",
            '{ value = "60 Pa", uncertainty = "10 Pa" }',
            lowest=0.0,
            above_zero=False,
        ),
        "phi_lin": ResponseInfo(
            "deg",
            "φ_lin",
            "angle of the linearised yield locus: its slope, as an angle",
            '{ value = "24 deg", uncertainty = "1 deg" }',
            highest=90.0,
            why="It is an arc tangent.",
        ),
        "phi_e": ResponseInfo(
            "deg",
            "φ_e",
            "effective angle of internal friction: slope of the line through the origin that "
            "touches the Mohr circle of steady flow",
            '{ value = "26 deg", uncertainty = "1 deg" }',
            highest=90.0,
            why="It is an arc sine.",
        ),
        "phi_sf": ResponseInfo(
            "deg",
            "φ_sf",
            "angle of steady flow: arc tangent of shear stress over normal stress at the preshear",
            '{ value = "23.5 deg", uncertainty = "0.5 deg" }',
            highest=90.0,
            why="It is an arc tangent.",
        ),
        "unconfined_strength": ResponseInfo(
            "Pa",
            "σ_c",
            "unconfined yield strength: major principal stress at which a bed without lateral "
            "support fails",
            '{ value = "200 Pa", uncertainty = "30 Pa" }',
            lowest=0.0,
            above_zero=False,
        ),
        "major_consolidation_stress": ResponseInfo(
            "Pa",
            "σ_1",
            "major consolidation stress: major principal stress of steady flow at the preshear",
            '{ value = "750 Pa", uncertainty = "5 %" }',
        ),
        "ffc": ResponseInfo(
            "",
            "ff_c",
            "flow function coefficient: major consolidation stress over unconfined yield strength",
            '{ value = 3.5, uncertainty = "10 %" }',
            absent="the material is free flowing: its unconfined_strength is zero within two "
            "standard errors, and ffc has no value",
        ),
        "bulk_density": ResponseInfo(
            "kg/m^3",
            "ρ_b",
            "bulk density: mass of the bed over its volume at the end of the preshear, voids "
            "included",
            '{ value = "1230 kg/m^3", uncertainty = "1 %" }',
        ),
    }
    curves: ClassVar[Mapping[str, CurveInfo]] = {
        "shear_stress": CurveInfo(
            "Pa",
            "τ",
            "shear stress over normal stress: points of the yield locus, at failure after the "
            "preshear",
            "normal stress",
            "Pa",
            lowest=0.0,
            rises=True,
            why="Points of a yield locus are above 0, and higher under a higher normal stress.",
        ),
    }

    normal_stress: Amount | None = option(
        STRESS,
        "Normal stress of the preshear. Young's modulus must be at least 700 times as much.",
        example='"500 Pa"',
        default=Derived("500 Pa for d = 10 mm", lambda s: s.usual_stress),
        starter="that of your preshear; by default that of d, 500 Pa for 10 mm",
    )
    lowest_stress: Amount | None = option(
        STRESS,
        "Lowest normal stress at which the bed is sheared to failure.",
        example='"125 Pa"',
        default=Derived("25 % of the normal stress", lambda s: s.usual_lowest),
    )
    highest_stress: Amount | None = option(
        STRESS,
        "Highest normal stress at which the bed is sheared to failure.",
        example='"375 Pa"',
        default=Derived("75 % of the normal stress", lambda s: s.usual_highest),
    )
    points: int = option(
        Whole(2, 20),
        "Number of points of the yield locus, evenly spaced in normal stress.",
        example="3",
        default=3,
    )
    cycles: int = option(
        Whole(2, 100),
        "Number of times that each point is measured.",
        example="3",
        default=3,
    )
    preshear_strain: Amount = option(
        STRAIN,
        "Shear strain of the preshear before each point; its second half is the steady flow.",
        example="0.5",
        default=0.5,
    )
    failure_strain: Amount = option(
        Quantity("", lowest=2 * WINDOW, highest=10.0),
        "Shear strain in which the peak of the shear stress is looked for.",
        example="0.25",
        default=0.25,
    )
    length: Amount | None = length_option("length", 14, "Period along the shear.")
    depth: Amount | None = length_option("depth", 7, "Period across the shear.")
    gap: Amount | None = length_option(
        "gap",
        8,
        "Distance between the plates at a solid fraction of 0.58; it gives the number of "
        "particles.",
    )

    setup = cached_property(ShearCellSetup)

    def curve_range(self, name: str) -> CurveRange:  # noqa: ARG002
        """Return the normal stresses at failure."""
        setup = self.setup
        return CurveRange(
            setup.lowest_stress, setup.highest_stress, "lowest_stress", "highest_stress"
        )

    def stages(self, material: Mapping[str, float], travel: float) -> tuple[Stage, ...]:
        """Return the stages: transient, and preshear, unloading and failure of every point."""
        transient = self._shear("transient", material, self.setup.transient_strain, _FIRST)
        points = (
            stage
            for number, stress in enumerate(self._stresses, 1)
            for stage in self._point(number, stress, material)
        )
        return (self.closing(material, travel), transient, *points)

    def _point(
        self, number: int, stress: float, material: Mapping[str, float]
    ) -> tuple[Stage, Stage, Stage]:
        setup = self.setup
        last = _LAST if number == len(self._stresses) else f"failed{number}"
        _, load = setup.motions(material, stress)
        unload = Stage(
            f"unload{number}",
            Elapsed(setup.unloading_strain / setup.shear_rate(material)),
            motions={"upper": load},
            is_closed=True,
            remark=f"the plate stops, and the load is reduced to {stress:g} Pa",
        )
        return (
            self._shear(f"preshear{number}", material, setup.preshear_strain, f"steady{number}"),
            unload,
            self._shear(f"shear{number}", material, setup.failure_strain, last, stress),
        )

    def _shear(
        self,
        name: str,
        material: Mapping[str, float],
        strain: float,
        snapshot: str,
        stress: float | None = None,
    ) -> Stage:
        """Return a stage of shear under the normal stress of the preshear, or another one."""
        setup = self.setup
        shear, load = setup.motions(material, stress)
        return Stage(
            name,
            Elapsed(strain * setup.gap / shear.speed),
            motions={"upper": (shear, load)},
            series=Series(COLUMNS, setup.record_interval(material)),
            snapshot=snapshot,
            is_closed=True,
            remark=f"shear strain of {strain:g} under {stress or setup.normal_stress:g} Pa",
        )

    @property
    def _stresses(self) -> tuple[float, ...]:
        """Normal stress at every failure, Pa."""
        return self.setup.stresses * self.cycles

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure all responses; leave a picture and a VTK file of the bed.

        Raises
        ------
        RunFailedError
            The simulation did not end as the test requires, see `Shear.measure`; or the normal
            stress was not held at a peak, or failure tells no yield locus.
        NotMeasurableError
            A file is missing or damaged.
        """
        names = [f"{stage}{n}" for n in self._numbers for stage in ("preshear", "unload", "shear")]
        run.require_complete(["close", "transient", *names], "gap between the plates")
        frames, profile = self._frames(run)
        require_separate(frames[-1].bed)
        steady = self._steady(run)
        speed = float(np.mean([plate_speed([record]) for record in steady]))
        require_sheared(
            self.setup, frames, steady, speed, profile, within=_HELD, longer="preshear_strain"
        )
        write_vtk(run.folder / "sheared.vtk", frames[-1].bed)
        failures = self._failures(run, profile.gap)
        self._require_held(failures)
        view = self._view(frames[-1], profile, steady, failures)
        friction = math.tan(math.radians(view.evaluation.steady_angle.value))
        draw_shear_cell(run.folder / _PICTURE, view, failures, friction)
        # Frames alternate between steady flow and failure.
        density = block_mean([frame.density(self.setup) for frame in frames[1::2]])
        return {
            **view.evaluation.responses,
            "bulk_density": density,
            "shear_stress": self._curve(view.evaluation),
        }

    @property
    def _numbers(self) -> range:
        return range(1, len(self._stresses) + 1)

    def _frames(self, run: RunOutput) -> tuple[list[Frame], Profile]:
        """Read all snapshots; the way of the plate is their time, so that speeds are shares."""
        stages = ["transient", *(f"{s}{n}" for n in self._numbers for s in ("preshear", "shear"))]
        names = [_FIRST, *(f"{s}{n}" for n in self._numbers for s in ("steady", "failed"))]
        names[-1] = _LAST
        ways = [float(self._record(run, stage).travels[-1]) for stage in stages]
        frames = [read_frame(run, *pair) for pair in zip(names, ways, strict=True)]
        return frames, velocity_profile(frames, self.setup.length, 1.0)

    def _record(self, run: RunOutput, stage: str) -> Record:
        return Record.of_stage(run, stage, self.setup, lower_alone=True)

    def _steady(self, run: RunOutput) -> list[Record]:
        """Read the steady part of every preshear."""
        return [self._record(run, f"preshear{n}").last(_STEADY) for n in self._numbers]

    def _failures(self, run: RunOutput, gap: float) -> list[Failure]:
        """Read the courses of failure at every normal stress, the lowest first."""
        records = [self._record(run, f"shear{n}") for n in self._numbers]
        points = len(self.setup.stresses)
        return [Failure.of(records[first::points], gap) for first in reversed(range(points))]

    def _require_held(self, failures: list[Failure]) -> None:
        for failure, wanted in zip(failures, reversed(self.setup.stresses), strict=True):
            if not abs(failure.normal_stress / wanted - 1) <= _HELD_AT_PEAK:
                raise RunFailedError(
                    messages.NOT_HELD_AT_FAILURE(stress=failure.normal_stress, wanted=wanted)
                )

    def _view(
        self, frame: Frame, profile: Profile, steady: list[Record], failures: list[Failure]
    ) -> ShearCellView:
        found = [angle_of(friction) for friction in frictions_with_errors(failures)]
        flow = angle_of(block_mean([friction_of(record) for record in steady]))
        stresses = [failure.normal_stress for failure in failures]
        try:
            evaluation = ShearTest(stresses, found, self.setup.normal_stress, flow)
        except ValueError as error:
            raise RunFailedError(messages.NO_YIELD_LOCUS(reason=error)) from None
        flow_view = ShearView.of(frame, profile, self.setup.length, self.setup.depth)
        return ShearCellView(**vars(flow_view), evaluation=evaluation)

    def _curve(self, evaluation: ShearTest) -> Curve:
        """Return the points, moved along the slope of the locus to the wanted normal stresses."""
        wanted = self.setup.stresses[::-1]
        pairs = zip(wanted, evaluation.normal_stresses, evaluation.angles, strict=True)
        slope = evaluation.circles.slope
        return Curve(
            wanted,
            [
                stress * math.tan(math.radians(angle.value)) + slope * (exact - stress)
                for exact, stress, angle in pairs
            ],
        )

    def view(self, run: RunOutput) -> ShearCellView:
        """Read the end of a run, to be drawn."""
        frames, profile = self._frames(run)
        failures = self._failures(run, profile.gap)
        return self._view(frames[-1], profile, self._steady(run), failures)
