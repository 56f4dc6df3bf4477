"""The funnel test: a heap is poured out of a funnel, on a plate or on a disc."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.funnel import messages
from grainfit.bulk_tests.funnel.setup import FunnelSetup, cone_height
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.heap_view import HeapView
from grainfit.bulk_tests.shared.options import LENGTH, flow_settling_option
from grainfit.bulk_tests.shared.orifice import narrow_orifice
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES, friction_of_part
from grainfit.bulk_tests.shared.plate import (
    ON_DISC,
    ROUGH_PLATE,
    STEEPEST,
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
from grainfit.bulk_tests.shared.plate import PLATE as PLATE_SURFACE
from grainfit.bulk_tests.shared.responses import AT_EDGE, HEAP_PROFILE, heap_responses
from grainfit.bulk_tests.shared.validity import arch, require_separate
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import SeenOutline, Shown
from grainfit.checks import Found, check
from grainfit.errors import Fault, NotMeasurableError, RunFailedError
from grainfit.evaluation import Measured
from grainfit.formatting import millimetres
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.measurement.messages import TWO_SLOPES
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Quantity
from grainfit.scenes.conditions import AtRest
from grainfit.scenes.packing import Column, Footprint, Round
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Scene, Stage, Velocity, Wall
from grainfit.scenes.shapes import Cone, Cylinder, Disc

_BED, _HEAP, _PICTURE = "bed", "heap", "funnel.png"
#: Stage in which the funnel is open.
_POUR = "pour"
#: Distance between apex and outlet at which particles still leave the funnel, in diameters.
_CLEARANCE = 1.5
#: Largest share of the particles that may stay in an open funnel.
_LARGEST_REST = 0.02


@check("funnel-in-heap", "warning")
def funnel_in_heap(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Funnels so low that the measured heap grows into them."""
    setup, diameter = checked.test.setup, checked.test.sizes.sauter_diameter
    angle, apex = (checked.targets.get(name) for name in ("angle_of_repose", "heap_height"))
    if apex is None and angle is not None and 0 < angle < STEEPEST:
        apex = cone_height(setup.heap_volume, angle)
        if setup.is_disc:
            apex = min(apex, setup.plate_radius * math.tan(math.radians(angle)))
    if apex is not None and setup.raise_speed == 0 and apex > setup.funnel_height - diameter:
        yield (
            "funnel_height",
            messages.FUNNEL_IN_HEAP(
                apex=millimetres(apex),
                height=millimetres(setup.funnel_height),
                least=millimetres(apex + 2 * diameter),
            ),
        )


_USUAL_APPARATUS = VariedOptions(
    "poured_volume",
    Range(0.75, 1.35, power=-1),
    size_power=3,
    factors={"outlet_diameter": Range(0.95, 1.4), "funnel_height": Range(0.6, 2.0)},
    values={"plate_sliding_friction": Range(0.2, 1.0)},
    wider={"plate_radius": 1.6},
    same={"plate_rolling_friction": AS_PARTICLES},
    indifferent=("funnel_radius", "plate_radius", "views"),
)
#: The funnel stands still above the apex, and the surplus falls off.
_ON_DISC = replace(
    _USUAL_APPARATUS,
    size_option="plate_radius",
    size_power=1,
    name="disc",
    title="on a disc",
    factors={
        "poured_volume": Range(0.95, 1.4),
        "outlet_diameter": Range(0.85, 1.3),
        "funnel_height": Range(1.0, 2.5),
    },
    wider={},
    same={**_USUAL_APPARATUS.same, "base": ON_DISC, "raise_speed": 0.0},
    indifferent=("funnel_radius", "views"),
)


@dataclass(frozen=True)
class Funnel(BulkTest):
    """Poured heap: angle of repose and size of a heap below a funnel.

    Particles rain into a closed funnel: a cone, with a tube above it and, if given, a stem below.
    Once they are at rest the outlet is opened, and they fall on a plate. The outlet stays at its
    height, or the funnel is raised while the heap grows. The heap lies free on a wide plate, or it
    covers a small disc, off which the surplus falls (fixed base). Once it is at rest it is
    measured on silhouettes, as that of the heap test is.

    Defaults follow the Sauter diameter d of the particles; times follow d by Froude's law. The
    options are the fields below, as in the calibration file.

    Examples
    --------
    >>> Funnel(diameter="10 mm").setup.outlet_diameter
    0.06
    >>> Funnel(diameter="10 mm", base="disc", plate_radius="80 mm").number_of_particles
    644
    """

    type: ClassVar[str] = "funnel"
    title: ClassVar[str] = "poured heap"
    vessel: ClassVar[str] = "poured_volume"
    parts: ClassVar[Parts] = {
        "funnel": ("cone", "tube", "stem", "door"),
        "plate": ("plate", "rim"),
    }
    shown: ClassVar[Shown] = Shown("heap", "angle_of_repose", snapshot_file(_HEAP), _PICTURE)
    checks: ClassVar[Checks] = (
        narrow_orifice(lambda test: test.setup.outlet),
        funnel_in_heap,
        small_plate,
        base_of_disc,
        smooth_plate,
        assumed_plate,
    )
    worse_ends: ClassVar[Mapping[str, int]] = {ASPECT_RATIO: 1}
    size_powers: ClassVar[Mapping[str, float | None]] = {"base_radius": 1, "heap_height": 1}
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS, _ON_DISC)
    responses: ClassVar[Mapping[str, ResponseInfo]] = heap_responses(
        {
            "angle_of_repose": RecordedTrials(0.049),
            # Sliding friction has no effect on it beyond its error at the first material.
            "base_radius": RecordedTrials(0.0155),
            "heap_height": RecordedTrials(0.027),
        },
    )
    curves: ClassVar[Mapping[str, CurveInfo]] = {"profile": HEAP_PROFILE}

    poured_volume: Amount | None = option(
        Quantity("m^3", above_zero=True),
        "Bulk volume that is poured, at a solid fraction of 0.58; it gives the number of "
        "particles. It is the poured mass over the bulk density.",
        example='"1350 cm^3"',
        default=Derived(
            "1350 d^3; on a disc that is given, 1.3 times a cone of 40 degrees",
            lambda s: s.usual_volume,
        ),
    )
    outlet_diameter: Amount | None = option(
        LENGTH,
        "Inner diameter of the outlet, and of the stem.",
        example='"50 mm"',
        default=Derived("5 d", lambda s: s.usual_outlet),
    )
    funnel_height: Amount | None = option(
        LENGTH,
        "Height of the outlet above the plate, at the beginning. Particles that fall far flatten "
        "the heap: use the height of the laboratory.",
        example='"75 mm"',
        default=Derived(
            "4 d; of a funnel that is not raised, 2 d above a heap of 40 degrees",
            lambda s: s.usual_height,
        ),
    )
    raise_speed: Amount | None = option(
        Quantity("m/s", lowest=0.0),
        "Speed at which the funnel is raised from when it is opened; 0 if it stands still.",
        example='"5 mm/s"',
        default=Derived(
            "so that the outlet ends 2 d above a heap of 40 degrees; 0 if it begins there",
            lambda s: s.usual_raise,
        ),
    )
    half_angle: Amount = option(
        Quantity("deg", lowest=5.0, highest=80.0),
        "Inclination of the funnel's wall from the vertical.",
        example='"30 deg"',
        default=30.0,
    )
    funnel_radius: Amount | None = option(
        LENGTH,
        "Inner radius of the funnel above its cone.",
        example='"80 mm"',
        default=Derived("cone and a little of the tube are full", lambda s: s.usual_radius),
    )
    stem_length: Amount = option(
        Quantity("m", lowest=0.0, highest=1e3),
        "Length of a stem below the cone.",
        example='"10 mm"',
        default=0.0,
        default_text="0, none",
    )
    base: str = base_option()
    plate_radius: Amount | None = option(
        LENGTH,
        "Radius of plate or disc.",
        example='"200 mm"',
        default=Derived(
            "2 d more than a heap of 12 degrees has; of a disc, the one that 77 % of the volume "
            "covers at 40 degrees",
            lambda s: s.usual_plate,
        ),
    )
    rim_height: Amount = rim_option()
    plate_sliding_friction: Amount | None = plate_friction("Sliding")
    plate_rolling_friction: Amount | None = plate_friction("Rolling")
    settling_time_limit: Amount | None = flow_settling_option('"8 s"', "four", "the heap")
    views: int = views_option()

    setup = cached_property(FunnelSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large.

        An outlet becomes no narrower than the usual one, which may be wide for a small heap.
        Dimensions that follow from others, and are not given, follow from them at any size.
        """
        options = scaled(
            self,
            scale,
            poured_volume=3,
            funnel_radius=1,
            outlet_diameter=1,
            funnel_height=1,
            raise_speed=0.5,
            stem_length=1,
            plate_radius=1,
        )
        for name in ("funnel_radius", "funnel_height", "raise_speed"):
            if getattr(self, name) is None:
                options.pop(name, None)
        # A narrower outlet than the usual one may arch.
        wide = min(self.setup.outlet_diameter, self.setup.usual_outlet)
        options["outlet_diameter"] = max(float(options["outlet_diameter"]), wide)
        return options

    @classmethod
    def options_for(cls, material: Mapping[str, float]) -> dict[str, Amount]:  # noqa: ARG003
        """Return a rough plate, on which all materials make heaps."""
        return dict(ROUGH_PLATE)

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over why enlarged particles would arch over the outlet."""
        return self.setup.outlet.coarse_graining_faults(self._sizes_of(material))

    def curve_range(self, name: str) -> CurveRange:  # noqa: ARG002
        """Return the distances from the axis: beyond the heap, its height is 0."""
        return CurveRange(low=0.0)

    @property
    def ground(self) -> float:
        """Height from which flanks and base of the heap are measured, m; see `angle_of_repose`."""
        return max(float(self.rim_height), self.sizes.sauter_diameter)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the funnel above its cone."""
        return Round(float(self.setup.funnel_radius))

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls into a funnel, which is opened."""
        setup, largest = self.setup, self.setup.largest
        above = np.array([0.0, 0.0, setup.cone_top])
        top = setup.cone_top + column.height + 1.25 * largest
        side = max(setup.plate_radius, setup.funnel_radius) + 1.5 * largest
        ceiling = top + setup.highest_raise + 2 * largest
        rough = friction_of_part(material, self.plate_sliding_friction, self.plate_rolling_friction)
        return self.scene_with(
            material,
            setup.filling,
            title="Funnel test: a poured heap",
            particles=replace(column, positions=column.positions + above),
            box=Box((-side, -side, -3 * largest), (side, side, ceiling)),
            walls={
                **self._funnel(top),
                **plate_walls(setup.plate_radius, setup.rim_height, bool(rough)),
            },
            stages=self._stages(),
            surfaces={PLATE_SURFACE: rough} if rough else {},
        )

    def _funnel(self, top: float) -> dict[str, Wall]:
        """Return the walls of the funnel, whose tube ends at a height, m."""
        setup = self.setup
        outlet, bottom = setup.outlet_diameter / 2, setup.cone_bottom
        walls = {
            "cone": Wall(Cone(outlet, setup.funnel_radius, bottom, setup.cone_top)),
            "tube": Wall(Cylinder(setup.funnel_radius, setup.cone_top, top)),
        }
        if setup.stem_length > 0:
            walls["stem"] = Wall(Cylinder(outlet, setup.funnel_height, bottom))
        return {**walls, "door": Wall(Disc(outlet, setup.funnel_height))}

    def _stages(self) -> tuple[Stage, ...]:
        setup, speed = self.setup, float(self.setup.raise_speed)
        moving = {"cone", "tube", "stem"} - (set() if setup.stem_length > 0 else {"stem"})
        limit = setup.shortest_flow + setup.settling_time_limit
        return (
            setup.filling.stage(setup.settling_time_limit, _BED),
            Stage(
                _POUR,
                AtRest(limit, at_least=setup.shortest_flow),
                "the outlet is opened; until the heap is at rest",
                take_away=("door",),
                motions={n: Velocity("z", speed) for n in sorted(moving)} if speed > 0 else {},
                snapshot=_HEAP,
            ),
        )

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure the heap; leave a picture and a VTK file of it.

        A heap that reaches the edge of a plate is shaped by it and has no responses; one that is to
        cover a disc must do so.

        Raises
        ------
        RunFailedError
            The simulation did not end as a poured heap requires: a bed did not come to rest,
            particles broke out or overlap grossly, the outlet is blocked, the heap has grown into
            the funnel or does not cover its disc.
        NotMeasurableError
            A response has no value, with the reason.
        """
        run.require_complete([stage.name for stage in self._stages()], "funnel")
        require_separate(run.snapshot(_BED))
        end = run.snapshot(_HEAP)
        write_vtk(run.folder / "heap.vtk", end)
        outlet, picture = self._outlet_height(run), run.folder / _PICTURE
        view = self._below(end, outlet)
        try:
            self._require_empty(end, outlet)
            measured = view.measure(picture, "" if self.setup.is_disc else AT_EDGE)
        except RunFailedError as error:
            view.picture(picture, str(error))
            raise
        except NotMeasurableError as error:
            if TWO_SLOPES.is_in(str(error)):
                raise NotMeasurableError(messages.FLAT_TOP(reason=error)) from None
            raise
        if self.setup.is_disc:
            view.require_covered()
        return measured

    def _outlet_height(self, run: RunOutput) -> float:
        """Height of the outlet at the end, m."""
        poured = run.stages[-1].time - run.stages[-2].time
        return float(self.setup.funnel_height + self.setup.raise_speed * poured)

    def _require_empty(self, end: Particles, outlet: float) -> None:
        """Raise `RunFailedError` if the flow did not end by itself."""
        diameter = self.sizes.sauter_diameter
        above = end.positions[:, 2] > outlet
        rest = float(end.masses[above].sum() / end.masses.sum()) if len(end) else 0.0
        across = np.hypot(end.positions[:, 0], end.positions[:, 1])
        held = end.select(above & (across < self.setup.outlet_diameter / 4))
        if rest <= _LARGEST_REST and not arch(held, "outlet"):
            return
        below = end.positions[~above]
        inside = below[across[~above] < self.setup.outlet_diameter / 2]
        apex = float(inside[:, 2].max(initial=0.0)) + diameter / 2
        if apex > outlet - _CLEARANCE * diameter:
            raise RunFailedError(
                messages.HEAP_AT_FUNNEL(apex=apex / diameter, outlet=outlet / diameter)
            )
        found = arch(held, "outlet") or "the material rests on the wall of the funnel"
        raise RunFailedError(messages.STILL_IN_FUNNEL(arch=found, percent=100 * rest))

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Estimate the simulated time of a run, s."""
        return self.setup.filling.usual_time + self.setup.pour_time

    def view(self, run: RunOutput) -> HeapView:
        """Read the heap of a run, to be drawn."""
        return self._below(run.snapshot(_HEAP), self._outlet_height(run))

    def seen_outline(self, responses: Mapping[str, Measured]) -> SeenOutline | None:
        """Return the mean outline of all sides of the heap."""
        return SeenOutline.of_profile(responses.get("profile"))

    def _below(self, end: Particles, outlet: float) -> HeapView:
        """Return the heap of the particles below an outlet, whose height is in m."""
        setup = self.setup
        below = end.select(end.positions[:, 2] < outlet)
        return HeapView(below, setup.plate_radius, setup.rim_height, self.ground, self.views)
