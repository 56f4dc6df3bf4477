"""The draw-down test: a bed flows through a slot onto a floor; five responses from one run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.draw_down import messages
from grainfit.bulk_tests.draw_down.setup import CLEARANCE, DrawDownSetup
from grainfit.bulk_tests.draw_down.surfaces import Surfaces
from grainfit.bulk_tests.draw_down.view import DrawDownView, draw_draw_down
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.shared.flow_target import flow_depth, unusual_flow
from grainfit.bulk_tests.shared.options import (
    FILL_HEIGHT,
    LENGTH,
    SLOT_WIDTH,
    flow_settling_option,
    length_option,
)
from grainfit.bulk_tests.shared.orifice import narrow_orifice
from grainfit.bulk_tests.shared.part_friction import friction_of_part, friction_option
from grainfit.bulk_tests.shared.slot_scene import BED, END, FLOW, INSIDE, fill_and_flow
from grainfit.bulk_tests.shared.validity import (
    require_apex_below,
    require_emptied,
    require_foot_on_floor,
    require_separate,
)
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.varied_options import OF_FLANKS, Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.checks import Found, check
from grainfit.errors import Fault, NotMeasurableError, RunFailedError
from grainfit.evaluation import Response
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.materials.walls import plain_name
from grainfit.measurement.bulk_density import bulk_density_in_box
from grainfit.measurement.flow_rate import flow_rate
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.scenes.packing import Column, Footprint
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import WALL, Box, Scene, Stage, Wall
from grainfit.scenes.shapes import Block

_PICTURE, _VTK = "draw_down.png", "draw_down.vtk"
#: Surface of the lower floor, when it is another one than that of the walls.
_FLOOR = "floor"
#: Remark of a first calibration file on the friction of the floor.
_STARTER = "by default that of the walls, off which most heaps roll"
#: Rolling friction of walls on which heaps spread beyond the floor, and that of a rough floor.
_SMOOTH, _ROUGH = 0.05, 0.5


#: At a rolling friction of 0.005, beds roll off the shelf one by one for more than 7 s.
_LEAST = 0.02


@check("smooth-walls", "warning")
def smooth_walls(checked: CheckedTest[Any]) -> Iterator[Found]:
    """Walls so smooth that particles roll on them for longer than the test waits."""
    for key, value in checked.lowest.items():
        if plain_name(key) == "particle_wall.rolling_friction" and value < _LEAST:
            yield key, messages.SMOOTH_WALLS(key=key, value=value, least=_LEAST)


_USUAL_APPARATUS = VariedOptions(
    "width",
    Range(0.75, 1.2, power=-1),
    factors={"slot_width": Range(0.9, 1.6), "fill_height": Range(0.7, 1.3)},
    values={
        "floor_sliding_friction": Range(0.1, 1.0),
        "floor_rolling_friction": Range(0.05, 1.0, power=0),
    },
    wider={"floor_half_width": 2.0},
    indifferent=("shelf_thickness", "floor_half_width"),
    particles=("cohesive", "clumps"),
    surface_energy=OF_FLANKS,
)


@dataclass(frozen=True)
class DrawDown(BulkTest):
    """Draw-down (two boxes): bulk density, flow, and two angles from one test.

    Particles rain into an upper box. Once the bed is at rest its bulk density is measured, and the
    door of a slot in its floor, the shelf, is taken away. Material flows onto a lower floor until
    the slot runs dry. Two wedges stay on the shelf, and a pile lies on the lower floor. The test is
    a slice: its depth is periodic, without end walls.

    Defaults follow the Sauter diameter d of the particles, and are never smaller than the largest
    particles allow; times follow d by Froude's law. The options are the fields below, as in the
    calibration file.

    Examples
    --------
    >>> DrawDown(diameter="10 mm").setup.box.slot_width
    0.05
    >>> DrawDown(diameter="10 mm", slot_width="6 cm").setup.box.slot_width
    0.06
    """

    type: ClassVar[str] = "draw_down"
    title: ClassVar[str] = "two boxes and a slot"
    vessel: ClassVar[str] = "width"
    parts: ClassVar[Parts] = {
        "box": ("left", "right"),
        "shelf": ("left_shelf", "right_shelf", "door"),
        "floor": ("floor",),
    }
    revision: ClassVar[int] = 1
    shown: ClassVar[Shown] = Shown("draw-down", "angle_of_repose", snapshot_file(END), _PICTURE)
    checks: ClassVar[Checks] = (
        narrow_orifice(lambda test: test.setup.box.orifice),
        smooth_walls,
        flow_depth,
        unusual_flow,
    )
    worse_ends: ClassVar[Mapping[str, int]] = {ASPECT_RATIO: 1}
    size_powers: ClassVar[Mapping[str, float | None]] = {"mass_flow": None}
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS,)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "bulk_density": ResponseInfo(
            "kg/m^3",
            "ρ_b",
            "bulk density: mass of the bed over its volume, voids included",
            '{ value = "1325 kg/m^3", uncertainty = "1 %" }',
            RecordedTrials(0.005, (0.032, 0.056)),
        ),
        "mass_flow": ResponseInfo(
            "kg/s",
            "ṁ",
            "mass flow: mass through the orifice per time, of the whole simulated depth",
            '{ value = "1.75 kg/s", uncertainty = "3 %" }',
            RecordedTrials(0.05),
        ),
        "discharged_share": ResponseInfo(
            "",
            "x_d",
            "discharged share: mass that has left the upper box over the mass filled in",
            '{ value = 0.75, uncertainty = "2 %" }',
            RecordedTrials(0.015, (0.024, 0.026)),
            highest=1.0,
            why="It is a share of the mass filled in.",
        ),
        "shear_angle": ResponseInfo(
            "deg",
            "α_s",
            "shear angle: inclination of the wedges left beside the slot",
            '{ value = "27 deg", uncertainty = "1 deg" }',
            RecordedTrials(0.062),
            highest=90.0,
            why="A flank is not steeper than a wall.",
        ),
        "angle_of_repose": ResponseInfo(
            "deg",
            "α",
            "angle of repose: inclination of the heap's flanks",
            '{ value = "24 deg", uncertainty = "1 deg" }',
            RecordedTrials(0.043, (-0.2, -0.38)),
            highest=90.0,
            why="A flank is not steeper than a wall.",
        ),
    }

    width: Amount | None = length_option("width", 24, "Inner width of the upper box.")
    depth: Amount | None = length_option(
        "depth",
        8,
        "Depth of the simulated slice; it repeats without end. The mass flow is that of this "
        "depth.",
    )
    fill_height: Amount | None = length_option("fill_height", 10, FILL_HEIGHT)
    slot_width: Amount | None = length_option("slot_width", 5, SLOT_WIDTH)
    shelf_thickness: Amount | None = option(
        LENGTH,
        "Thickness of the shelf, the floor of the upper box.",
        example='"5 mm"',
        default=Derived("0.5 d", lambda s: s.d / 2),
    )
    floor_distance: Amount | None = option(
        LENGTH,
        "Distance from the underside of the shelf to the lower floor. The apex of the heap must "
        "stay 2 d below the shelf.",
        example='"140 mm"',
        default=Derived("14 d", lambda s: s.usual_distance),
    )
    floor_half_width: Amount | None = option(
        LENGTH,
        "Half the width of the lower floor, whose edges are free. The heap must not reach them.",
        example='"300 mm"',
        default=Derived("30 d", lambda s: s.usual_half_width),
    )
    floor_sliding_friction: Amount | None = friction_option(
        "Sliding", "floor", "lower floor.", "0.5", starter=_STARTER
    )
    floor_rolling_friction: Amount | None = friction_option(
        "Rolling",
        "floor",
        "lower floor. On a smooth floor particles roll away beyond its edges, and the run fails.",
        "0.3",
        starter=_STARTER,
    )
    settling_time_limit: Amount | None = flow_settling_option('"7 s"', "three")

    setup = cached_property(DrawDownSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        return scaled(
            self,
            scale,
            width=1,
            depth=1,
            fill_height=1,
            slot_width=1,
            floor_distance=1,
            floor_half_width=1,
        )

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over why enlarged particles would arch over the orifice."""
        return self.setup.box.orifice.coarse_graining_faults(self._sizes_of(material))

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container that is filled."""
        return self.setup.footprint

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls, the door is taken away, the bed flows."""
        setup, largest = self.setup, self.setup.largest
        box, filling = setup.box, setup.filling
        top = column.height + 1.25 * largest
        side = setup.floor_half_width + 3 * largest
        bottom = setup.floor - 3 * largest
        half = setup.floor_half_width
        rough = friction_of_part(material, self.floor_sliding_friction, self.floor_rolling_friction)
        floor = Block((-half, 0.0, bottom - largest), (half, box.depth, setup.floor))
        return self.scene_with(
            material,
            filling,
            title="Draw-down test with a slot",
            particles=column,
            box=Box((-side, 0.0, bottom), (side, box.depth, top), periodic="y"),
            walls={**box.walls(top, largest), "floor": Wall(floor, _FLOOR if rough else WALL)},
            stages=self._stages(),
            surfaces={_FLOOR: rough} if rough else {},
        )

    @classmethod
    def options_for(cls, material: Mapping[str, float]) -> dict[str, Amount]:
        """Return a rough floor for particles that would roll off a smooth one."""
        if material["particle_wall.rolling_friction"] >= _SMOOTH:
            return {}
        return {"floor_rolling_friction": _ROUGH}

    def _stages(self) -> tuple[Stage, ...]:
        setup = self.setup
        return fill_and_flow(setup.filling, setup.flow, setup.underside)

    def measure(self, run: RunOutput) -> dict[str, Response]:
        """Measure the responses; leave a picture and a VTK file of the end.

        Raises
        ------
        RunFailedError
            The simulation did not end as a draw-down requires: a bed did not come to rest,
            particles broke out or overlap grossly, a stage is missing, the heap chokes the slot or
            reaches the edges of its floor, or the material arches over the slot.
        NotMeasurableError
            A response has no value, with the reason.
        """
        run.require_complete([stage.name for stage in self._stages()], "box")
        bed, end = run.snapshot(BED), run.snapshot(END)
        require_separate(bed)
        series = run.series(FLOW, [INSIDE])
        surfaces = Surfaces.of(end, self.setup)
        write_vtk(run.folder / _VTK, end)
        try:
            self._require_valid(surfaces, bed)
            responses = self._responses(bed, surfaces, series)
        except (RunFailedError, NotMeasurableError) as error:
            draw_draw_down(run.folder / _PICTURE, surfaces, str(error))
            raise
        draw_draw_down(run.folder / _PICTURE, surfaces, responses)
        return responses

    def _require_valid(self, surfaces: Surfaces, bed: Particles) -> None:
        setup, diameter = self.setup, surfaces.diameter
        clearance = CLEARANCE * diameter
        require_apex_below(surfaces.apex, setup.floor_distance, clearance, diameter)
        above = surfaces.upper.positions
        middle = np.abs(above[:, 0]) < setup.box.slot_width / 4
        require_emptied(surfaces.upper.select(middle & (above[:, 2] > 0)), "slot")
        discharged = float(bed.masses.sum() - surfaces.upper.masses.sum())
        lost = discharged - float(surfaces.on_floor.masses.sum())
        require_foot_on_floor(surfaces.heap, lost / discharged if discharged else 0.0, diameter)

    def _responses(
        self, bed: Particles, surfaces: Surfaces, series: Mapping[str, NDArray[np.float64]]
    ) -> dict[str, Response]:
        setup = self.setup
        box = setup.box
        density = bulk_density_in_box(bed, box.width, box.depth, *setup.density_heights)
        return {
            "bulk_density": density,
            "mass_flow": flow_rate(series["time"], series[INSIDE]).response,
            "discharged_share": surfaces.discharged_share(float(bed.masses.sum())),
            "shear_angle": surfaces.shear_angle().response,
            "angle_of_repose": surfaces.angle_of_repose().response,
        }

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Estimate the simulated time of a run, s."""
        return self.setup.filling.usual_time + self.setup.flow_time

    def view(self, run: RunOutput) -> DrawDownView:
        """Read the end of a run, to be drawn."""
        surfaces = Surfaces.of(run.snapshot(END), self.setup)
        return DrawDownView(surfaces)
