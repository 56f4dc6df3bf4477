"""The heap test: fill a cylinder, strike off, measure the bulk density, lift, measure the heap."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.heap import messages
from grainfit.bulk_tests.heap.setup import USUAL_RADIUS, HeapSetup
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.heap_view import HeapView
from grainfit.bulk_tests.shared.narrow_cylinder import narrow_cylinder
from grainfit.bulk_tests.shared.options import (
    LENGTH,
    cylinder_option,
    density_bottom_option,
    density_top_option,
    settling_option,
)
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES, friction_of_part
from grainfit.bulk_tests.shared.plate import (
    ON_DISC,
    ON_PLATE,
    PLATE,
    ROUGH_PLATE,
    assumed_plate,
    base_of_disc,
    base_option,
    plate_friction,
    plate_walls,
    rim_option,
    small_plate,
    smooth_plate,
    views_option,
)
from grainfit.bulk_tests.shared.responses import AT_EDGE, BULK_DENSITY, HEAP_PROFILE, heap_responses
from grainfit.bulk_tests.shared.surplus_particles import surplus_particles
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.varied_options import OF_FLANKS, Range, VariedOptions
from grainfit.bulk_tests.view import SeenOutline, Shown
from grainfit.checks import Found, check
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Measured
from grainfit.measurement.bulk_density import bulk_density
from grainfit.measurement.clinging import clinging
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity, Whole
from grainfit.scenes.conditions import AtRest, Clear
from grainfit.scenes.packing import Column, Footprint, Round
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import SCENES_REVISION, Box, Scene, Stage, Velocity, Wall
from grainfit.scenes.shapes import Cylinder

#: Part of the identity of runs: the hash of the hand-written decks of version 0.1.0, which are the
#: same simulation as those of today's scene.
DECK_REVISION = "e11f78288590e984"
#: Snapshots of a run, and its picture.
_SETTLED, _HEAP, _PICTURE = "settled", "heap", "heap.png"
#: Largest share of the particles that may hang on the lifted cylinder.
_LARGEST_CLINGING = 0.05
#: The lift ends before its longest travel.
_LIFT_SHARE = 0.9
#: Options that a definition of version 0.1.0 has beside geometry and procedure.
_OUTSIDE_SETUP = (
    "plate_sliding_friction",
    "plate_rolling_friction",
    "time_step_fraction",
    "views",
)


#: Lift speed over sqrt(g d) above which the column collapses beside the cylinder. Beads of 10 mm
#: make heaps of 22 degrees at 0.16, of 19 degrees at 0.32 and of 15 degrees at 3.2.
_FASTEST = 0.4


@check("fast-lift", "warning")
def fast_lift(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Lifts so fast that the column collapses."""
    setup = checked.test.setup
    natural = math.sqrt(setup.gravity * setup.d)
    speed = setup.lift_speed / natural
    if speed > _FASTEST:
        yield (
            "lift_speed",
            messages.FAST_LIFT(
                lift_speed=setup.lift_speed,
                speed=speed,
                fastest=_FASTEST,
                usual=setup.usual_lift_speed,
            ),
        )


_USUAL_APPARATUS = VariedOptions(
    "cylinder_radius",
    Range(0.7, 1.3, power=-1),
    factors={"strike_off_height": Range(0.6, 1.5), "lift_speed": Range(0.3, 3.0, power=0)},
    values={"plate_sliding_friction": Range(0.2, 1.0)},
    wider={"plate_radius": 1.6},
    same={"plate_rolling_friction": AS_PARTICLES},
    indifferent=(
        "particle_count",
        "plate_radius",
        "bulk_density_bottom",
        "bulk_density_top",
        "lift_height",
        "views",
    ),
    left=("bulk_density_top",),
    particles=("cohesive", "clumps"),
    surface_energy=OF_FLANKS,
)
#: Real discs are as wide as their cylinder, the bed is high, and the lift slow.
_ON_DISC = replace(
    _USUAL_APPARATUS,
    # Small discs have uneven heaps, and many of them none.
    size=Range(0.9, 1.5, power=-1),
    name="disc",
    title="on a disc",
    factors={"strike_off_height": Range(0.7, 1.6), "lift_speed": Range(0.15, 1.5, power=0)},
    wider={},
    same={**_USUAL_APPARATUS.same, "base": ON_DISC},
    indifferent=tuple(one for one in _USUAL_APPARATUS.indifferent if one != "plate_radius"),
    particles=(),
    surface_energy=None,
)


@dataclass(frozen=True)
class Heap(BulkTest):
    """Lifted cylinder: bulk density, and angle of repose and size of the heap, from one test.

    Particles rain into an upright cylinder on a plate. Once the bed is at rest its bulk density is
    measured, particles above the strike-off height are removed, the cylinder is lifted slowly,
    and once the heap is at rest it is measured on silhouettes. Every stage ends
    when the particles are at rest, not after a fixed time.

    Defaults follow the Sauter diameter d of the particles, or a third of the largest diameter, so
    that the default cylinder has room for four of these; speeds and times follow it by Froude's
    law, so that the test is the same test at every size. The options are the fields below, as in
    the calibration file.

    Examples
    --------
    >>> Heap(diameter="10 mm").setup.cylinder_radius
    0.06
    >>> Heap(diameter="10 mm", lift_speed="5 cm/s").setup.lift_speed
    0.05
    """

    type: ClassVar[str] = "heap"
    checks: ClassVar[Checks] = (
        surplus_particles,
        small_plate,
        base_of_disc,
        smooth_plate,
        assumed_plate,
        narrow_cylinder,
        fast_lift,
    )
    title: ClassVar[str] = "lifted cylinder"
    vessel: ClassVar[str] = "cylinder_radius"
    revision: ClassVar[int] = 2
    parts: ClassVar[Parts] = {
        "cylinder": ("cylinder",),
        "plate": ("plate", "rim"),
    }
    shown: ClassVar[Shown] = Shown("heap", "angle_of_repose", snapshot_file(_HEAP), _PICTURE)
    size_powers: ClassVar[Mapping[str, float | None]] = {"base_radius": 1, "heap_height": 1}
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS, _ON_DISC)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "bulk_density": BULK_DENSITY,
        **heap_responses(
            {
                # Scatter: 20 seeds on each of three solvers
                # (`benchmarks/data/solver_agreement.jsonl`).
                "angle_of_repose": RecordedTrials(0.039),
                # A cone of given volume: r^3 tan(angle) is constant.
                "base_radius": RecordedTrials(0.01, (0.65, 1.31)),
                "heap_height": RecordedTrials(0.032, (0.56, 1.12)),
            },
        ),
    }
    curves: ClassVar[Mapping[str, CurveInfo]] = {"profile": HEAP_PROFILE}

    particle_count: int | None = option(
        Whole(1),
        "Number of particles rained in.",
        example="1500",
        default=Derived("as many as fill the cylinder", lambda s: s.usual_count),
    )
    cylinder_radius: Amount | None = cylinder_option("cylinder", USUAL_RADIUS)
    plate_radius: Amount | None = option(
        LENGTH,
        "Radius of plate or disc, whose edge is free unless it has a rim.",
        example='"160 mm"',
        default=Derived("16 d; of a disc, the radius of the cylinder", lambda s: s.usual_plate),
    )
    base: str = base_option()
    rim_height: Amount = rim_option()
    strike_off_height: Amount | None = option(
        LENGTH,
        "Particles with their centre above are removed before the lift.",
        example='"105 mm"',
        default=Derived("10.5 d", lambda s: 10.5 * s.d),
    )
    bulk_density_bottom: Amount | None = density_bottom_option()
    bulk_density_top: Amount | None = density_top_option(
        "9 d, in lower beds 6/7 of the strike-off height", lambda s: s.usual_density_top
    )
    lift_speed: Amount | None = option(
        Quantity("m/s", above_zero=True),
        "Speed of the cylinder. It affects the angle of repose: use the speed of the laboratory.",
        example='"0.05 m/s"',
        default=Derived("0.05 m/s for d = 10 mm", lambda s: s.usual_lift_speed),
    )
    lift_height: Amount | None = option(
        LENGTH,
        "Longest travel of the cylinder; the lift ends earlier once the cylinder is clear of a "
        "heap at rest.",
        example='"100 mm"',
        default=Derived(
            "10 d, in beds above 40 d half of the strike-off height", lambda s: s.usual_lift_height
        ),
    )
    plate_sliding_friction: Amount | None = plate_friction("Sliding")
    plate_rolling_friction: Amount | None = plate_friction("Rolling")
    settling_time_limit: Amount | None = settling_option("the bed and the heap")
    views: int = views_option()

    setup = cached_property(HeapSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        setup = self.setup
        options = scaled(self, scale, cylinder_radius=1, plate_radius=1, strike_off_height=1)
        options |= scaled(self, scale, bulk_density_top=1, lift_height=1, lift_speed=0.5)
        # Particles stay as large: a small cylinder is not clear of them earlier.
        least = min(setup.lift_height, setup.layers_lifted)
        return options | {"lift_height": max(float(options["lift_height"]), least)}

    def definition(self) -> dict[str, Any]:
        """Return everything in the test that affects a run's outcome, as JSON.

        It is written as in version 0.1.0, but for its revision: the plate was rough by default
        then, and a heap at its edge had an angle.
        """
        setup, filling = self.setup, self.setup.filling
        recorded = {
            "column_height": filling.column_height,
            "cylinder_gap": setup.cylinder_gap,
            "quiet_speed": filling.quiet_speed,
            "check_interval": filling.check_interval,
            "fill_time": filling.fill_time,
        }
        options = self.resolved_options()
        if not setup.is_disc:
            # Heaps on a plate are those from before there were discs.
            del options["base"]
        return {
            "type": self.type,
            "revision": self.revision,
            "deck": DECK_REVISION,
            "packing": SCENES_REVISION,
            **self.sizes.definition(),
            **{name: options.pop(name) for name in _OUTSIDE_SETUP},
            "setup": {**options, **recorded},
        }

    @classmethod
    def from_definition(cls, definition: Mapping[str, Any]) -> Self:
        """Rebuild the test from the definition in the record of a run."""
        # Geometry and procedure are recorded with every default resolved.
        options = {"base": ON_PLATE, **definition["setup"], **definition}
        if definition["revision"] == 1 and options["plate_rolling_friction"] is None:
            options["plate_rolling_friction"] = AS_PARTICLES
        return super().from_definition(options)

    @classmethod
    def options_for(cls, material: Mapping[str, float]) -> dict[str, Amount]:  # noqa: ARG003
        """Return a rough plate, on which all materials make heaps."""
        return dict(ROUGH_PLATE)

    @property
    def ground(self) -> float:
        """Height from which flanks and base of the heap are measured, m; see `angle_of_repose`."""
        return max(self.setup.rim_height, self.sizes.sauter_diameter)

    def curve_range(self, name: str) -> CurveRange:  # noqa: ARG002
        """Return the distances from the axis: beyond the heap, its height is 0."""
        return CurveRange(low=0.0)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container that is filled."""
        return Round(self.setup.cylinder_radius)

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls, is struck off, and the cylinder is lifted."""
        setup, largest = self.setup, self.setup.largest
        top = column.height + 1.25 * largest
        side = setup.plate_radius + 1.5 * largest
        ceiling = top + setup.lift_height + 2 * largest
        cylinder = Cylinder(setup.cylinder_radius, setup.cylinder_gap, top)
        rough = friction_of_part(material, self.plate_sliding_friction, self.plate_rolling_friction)
        return self.scene_with(
            material,
            setup.filling,
            title="Heap test with a lifted cylinder",
            particles=column,
            box=Box((-side, -side, -3 * largest), (side, side, ceiling)),
            walls={
                "cylinder": Wall(cylinder),
                **plate_walls(setup.plate_radius, setup.rim_height, bool(rough)),
            },
            stages=self._stages(),
            surfaces={PLATE: rough} if rough else {},
        )

    def _stages(self) -> tuple[Stage, ...]:
        setup = self.setup
        limit = setup.settling_time_limit
        return (
            setup.filling.stage(limit, _SETTLED),
            Stage(
                "lift",
                Clear("cylinder", setup.lift_height / setup.lift_speed),
                "until the cylinder is clear of a heap at rest",
                strike_off=setup.strike_off_height,
                motions={"cylinder": Velocity("z", setup.lift_speed)},
            ),
            Stage("heap", AtRest(limit), "comes to rest", snapshot=_HEAP),
        )

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure bed and heap; leave a picture and a VTK file of the heap.

        A heap that reaches the edge of a plate is shaped by it: only the density is measured. One
        on a disc must cover it.

        Raises
        ------
        RunFailedError
            The simulation did not end as a heap test requires: a bed did not come to rest,
            particles broke out or overlap grossly, or a stage is missing.
        NotMeasurableError
            A response has no value, with the reason.
        """
        run.require_complete([stage.name for stage in self._stages()], "cylinder")
        bed = run.snapshot(_SETTLED)
        require_separate(bed)
        end = run.snapshot(_HEAP)
        write_vtk(run.folder / "heap.vtk", end)
        setup, picture = self.setup, run.folder / _PICTURE
        try:
            heap = self._heap(self._without_clinging(end))
        except NotMeasurableError as error:
            self._heap(end).picture(picture, str(error))
            raise
        density = bulk_density(
            bed, setup.cylinder_radius, setup.bulk_density_bottom, setup.bulk_density_top
        )
        found = heap.measure(picture, "" if setup.is_disc else AT_EDGE)
        if setup.is_disc:
            heap.require_covered()
        return {"bulk_density": density, **found}

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Estimate the simulated time of a run, s."""
        setup = self.setup
        return setup.filling.usual_time + _LIFT_SHARE * setup.lift_height / setup.lift_speed

    def view(self, run: RunOutput) -> HeapView:
        """Read the heap of a run, to be drawn."""
        return self._heap(self._without_clinging(run.snapshot(_HEAP)))

    def seen_outline(self, responses: Mapping[str, Measured]) -> SeenOutline | None:
        """Return the mean outline of all sides of the heap."""
        return SeenOutline.of_profile(responses.get("profile"))

    def _heap(self, end: Particles) -> HeapView:
        setup = self.setup
        return HeapView(end, setup.plate_radius, setup.rim_height, self.ground, self.views)

    def _without_clinging(self, end: Particles) -> Particles:
        """Return the particles without those that hang on the lifted cylinder.

        Raises
        ------
        NotMeasurableError
            They are so many that the heap is not that of the bed.
        """
        hanging = clinging(end, self.setup.cylinder_radius)
        share = float(end.masses[hanging].sum() / end.masses.sum()) if len(end) else 0.0
        if share > _LARGEST_CLINGING:
            raise NotMeasurableError(messages.CLINGING(percent=100 * share))
        return end.select(~hanging)
