"""The heap test: fill a cylinder, strike off, measure the bulk density, lift, measure the heap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import BulkTest, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.heap import messages
from grainfit.bulk_tests.heap.lift import fast_lift
from grainfit.bulk_tests.heap.plate import assumed_plate, small_plate, smooth_plate
from grainfit.bulk_tests.heap.setup import HeapSetup
from grainfit.bulk_tests.heap.view import HeapView
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.sensitivities import ROLLING, SLIDING, Sensitivities
from grainfit.bulk_tests.shared.narrow_cylinder import narrow_cylinder
from grainfit.bulk_tests.shared.options import LENGTH, settling_option
from grainfit.bulk_tests.shared.part_friction import (
    AS_PARTICLES,
    friction_of_part,
    friction_option,
)
from grainfit.bulk_tests.shared.responses import BULK_DENSITY
from grainfit.bulk_tests.shared.surplus_particles import surplus_particles
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.view import Shown
from grainfit.checks import Check
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Measured
from grainfit.measurement.angle_of_repose import (
    AngleOfRepose,
    angle_of_repose,
    heap_silhouettes,
    on_plate,
)
from grainfit.measurement.bulk_density import bulk_density
from grainfit.measurement.clinging import clinging
from grainfit.measurement.heap_picture import draw_heap
from grainfit.measurement.heap_size import base_radius, heap_height, heap_profile, reaches_edge
from grainfit.measurement.messages import NO_HEAP
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.measurement.silhouette import Silhouette
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity, Whole
from grainfit.scenes.conditions import AtRest, Clear
from grainfit.scenes.packing import Column, Footprint, Round
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import SCENES_REVISION, WALL, Box, Scene, Stage, Velocity, Wall
from grainfit.scenes.shapes import Cylinder, Disc

#: Part of the identity of runs: the hash of the hand-written decks of version 0.1.0, which are the
#: same simulation as those of today's scene.
DECK_REVISION = "e11f78288590e984"
#: Snapshots of a run, and its picture.
_SETTLED, _HEAP, _PICTURE = "settled", "heap", "heap.png"
#: Largest share of the particles that may hang on the lifted cylinder.
_LARGEST_CLINGING = 0.05
#: The bed is at rest soon after the shortest fill stage; the lift ends before its longest travel.
_FILL_SHARE = 1.25
_LIFT_SHARE = 0.9
#: Options that a definition of version 0.1.0 has beside geometry and procedure.
_OUTSIDE_SETUP = (
    "plate_sliding_friction",
    "plate_rolling_friction",
    "time_step_fraction",
    "views",
)
#: Why a heap has no shape of its own.
_AT_EDGE = (
    "the heap reaches the edge of the plate: use a larger plate_radius, or, if the plate of the "
    "laboratory is rough, plate_sliding_friction and plate_rolling_friction"
)
#: Remark of a first calibration file on the friction of the plate.
_STARTER = "rough; by default that of the walls, off which heaps slide"
#: Surface of plate and rim, when it is another one than that of the walls.
_PLATE = "plate"
#: Sliding friction of a rough plate.
_ROUGH = 0.5
_LENGTH_OR_ZERO = Quantity("m", lowest=0.0, highest=1e3)


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
    checks: ClassVar[tuple[Check[CheckedTest[Any]], ...]] = (
        surplus_particles,
        small_plate,
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
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "bulk_density": BULK_DENSITY,
        "angle_of_repose": ResponseInfo(
            "deg",
            "α",
            "angle of repose: inclination of the heap's flanks",
            '{ value = "22 deg", uncertainty = "0.5 deg" }',
            # Scatter: 20 seeds on each of three solvers (`benchmarks/data/solver_agreement.jsonl`).
            Sensitivities({SLIDING: 0.24, ROLLING: 0.57}, {SLIDING: 0.45, ROLLING: 0.29}, 0.039),
            highest=90.0,
            why="A flank is not steeper than a wall.",
            absent=_AT_EDGE,
        ),
        # A cone of given volume: r^3 tan(angle) is constant.
        "base_radius": ResponseInfo(
            "m",
            "r",
            "base radius: half the width of the heap, one particle diameter above the plate or at "
            "the height of its rim",
            '{ value = "130 mm", uncertainty = "2 mm" }',
            Sensitivities(
                {SLIDING: -0.09, ROLLING: -0.21},
                {SLIDING: -0.16, ROLLING: -0.11},
                0.01,
                larger=(0.65, 1.31),
            ),
            absent=_AT_EDGE,
        ),
        "heap_height": ResponseInfo(
            "m",
            "h",
            "heap height: highest point of the heap above the plate",
            '{ value = "53 mm", uncertainty = "1 mm" }',
            Sensitivities(
                {SLIDING: 0.17, ROLLING: 0.42},
                {SLIDING: 0.33, ROLLING: 0.21},
                0.032,
                larger=(0.56, 1.12),
            ),
            absent=_AT_EDGE,
        ),
    }

    curves: ClassVar[Mapping[str, CurveInfo]] = {
        "profile": CurveInfo(
            "m",
            "z",
            "height over radius: height of the heap's outline, averaged over both sides of all "
            "silhouettes",
            "radius",
            "m",
            absent=_AT_EDGE,
        ),
    }

    particle_count: int | None = option(
        Whole(1),
        "Number of particles rained in.",
        example="1500",
        default=Derived("as many as fill the cylinder", lambda s: s.usual_count),
    )
    cylinder_radius: Amount | None = option(
        LENGTH,
        "Inner radius of the cylinder.",
        example='"60 mm"',
        default=Derived("6 d", lambda s: s.usual_radius),
    )
    plate_radius: Amount | None = option(
        LENGTH,
        "Radius of the plate, whose edge is free unless it has a rim.",
        example='"160 mm"',
        default=Derived("16 d", lambda s: 16 * s.d),
    )
    rim_height: Amount = option(
        _LENGTH_OR_ZERO,
        "Height of a rim around the plate.",
        example='"10 mm"',
        default=0.0,
        default_text="0, a free edge",
    )
    strike_off_height: Amount | None = option(
        LENGTH,
        "Particles with their centre above are removed before the lift.",
        example='"105 mm"',
        default=Derived("10.5 d", lambda s: 10.5 * s.d),
    )
    bulk_density_bottom: Amount | None = option(
        LENGTH,
        "The bulk density is measured from this height on.",
        example='"10 mm"',
        default=Derived("1 d", lambda s: s.d),
    )
    bulk_density_top: Amount | None = option(
        LENGTH,
        "The bulk density is measured up to this height.",
        example='"90 mm"',
        default=Derived(
            "9 d, in lower beds 6/7 of the strike-off height", lambda s: s.usual_density_top
        ),
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
    plate_sliding_friction: Amount | None = friction_option(
        "Sliding", "plate", "plate.", "0.5", starter=_STARTER, recorded="apart"
    )
    plate_rolling_friction: Amount | None = friction_option(
        "Rolling",
        "plate",
        "plate. On a smooth plate heaps slide and roll apart, beyond its edge.",
        f'"{AS_PARTICLES}"',
        starter="rough; by default that of the walls",
        recorded="apart",
    )
    settling_time_limit: Amount | None = settling_option("the bed and the heap")
    views: int = option(
        Whole(1, 360),
        "Number of silhouettes on which the heap is measured.",
        example="12",
        default=12,
    )

    @cached_property
    def setup(self) -> HeapSetup:
        """Geometry and procedure, with every default resolved."""
        return HeapSetup(self)

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
        options = {**definition["setup"], **definition}
        if definition["revision"] == 1 and options["plate_rolling_friction"] is None:
            options["plate_rolling_friction"] = AS_PARTICLES
        return super().from_definition(options)

    @classmethod
    def options_for(cls, material: Mapping[str, float]) -> dict[str, Amount]:  # noqa: ARG003
        """Return a rough plate, on which all materials make heaps."""
        return {"plate_sliding_friction": _ROUGH, "plate_rolling_friction": AS_PARTICLES}

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
        surface = _PLATE if rough else WALL
        walls = {
            "cylinder": Wall(cylinder),
            "plate": Wall(Disc(setup.plate_radius, 0.0), surface),
        }
        if setup.rim_height > 0:
            walls["rim"] = Wall(Cylinder(setup.plate_radius, 0.0, setup.rim_height), surface)
        return Scene(
            title="Heap test with a lifted cylinder",
            material=material,
            sizes=self.sizes,
            particles=column,
            box=Box((-side, -side, -3 * largest), (side, side, ceiling)),
            walls=walls,
            stages=self._stages(),
            gravity=setup.gravity,
            time_step=self.time_step(material),
            quiet_speed=setup.filling.quiet_speed,
            check_interval=setup.filling.check_interval,
            surfaces={_PLATE: rough} if rough else {},
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

        A heap that reaches the edge of the plate is shaped by it: only the density is measured.

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
        setup = self.setup
        plate = setup.plate_radius
        try:
            heap = self._without_clinging(end)
        except NotMeasurableError as error:
            draw_heap(run.folder / _PICTURE, end, plate, self.ground, str(error))
            raise
        silhouettes = heap_silhouettes(on_plate(heap, plate), plate, self.views)
        density = bulk_density(
            bed, setup.cylinder_radius, setup.bulk_density_bottom, setup.bulk_density_top
        )
        if reaches_edge(silhouettes, self.ground, heap.diameter, plate):
            draw_heap(run.folder / _PICTURE, heap, plate, self.ground, _AT_EDGE)
            return {"bulk_density": density}
        angle = self._measure_angle(heap, silhouettes, run.folder / _PICTURE)
        return {
            "bulk_density": density,
            "angle_of_repose": angle.response,
            "base_radius": base_radius(silhouettes, self.ground, heap.diameter),
            "heap_height": heap_height(silhouettes, heap.diameter),
            "profile": heap_profile(silhouettes, heap.diameter, plate),
        }

    @property
    def number_of_particles(self) -> int:
        """Number of particles rained in."""
        return self.setup.particle_count

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Estimate the simulated time of a run, s."""
        setup = self.setup
        return (
            _FILL_SHARE * setup.filling.fill_time
            + _LIFT_SHARE * setup.lift_height / setup.lift_speed
        )

    def view(self, run: RunOutput) -> HeapView:
        """Read the heap of a run, to be drawn."""
        plate = self.setup.plate_radius
        heap = on_plate(self._without_clinging(run.snapshot(_HEAP)), plate)
        if not len(heap):
            raise NotMeasurableError("no particles are left on the plate")
        return HeapView(heap, plate, self.setup.rim_height, self.ground, self.views)

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
            raise NotMeasurableError(
                f"angle of repose: {100 * share:.0f} % of the particles cling to the lifted "
                "cylinder, so that the heap is not that of the bed; use a wider cylinder, or less "
                "cohesion on walls."
            )
        return end.select(~hanging)

    def _measure_angle(
        self, heap: Particles, silhouettes: Sequence[Silhouette], picture: Path
    ) -> AngleOfRepose:
        plate = self.setup.plate_radius
        try:
            angle = angle_of_repose(heap, self.ground, plate, self.views, silhouettes)
        except NotMeasurableError as error:
            draw_heap(picture, heap, plate, self.ground, str(error))
            if NO_HEAP.is_in(str(error)):
                raise NotMeasurableError(messages.NO_HEAP_ON_PLATE(reason=error)) from None
            raise
        draw_heap(picture, heap, plate, self.ground, angle)
        return angle
