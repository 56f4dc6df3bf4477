"""The discharge test: a flat-bottomed container is filled, and flows out of an orifice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

from grainfit.bulk_tests.abilities import CurveRange
from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.discharge.setup import AT_REST, MEASURED, ROUND, SLOT, DischargeSetup
from grainfit.bulk_tests.discharge.view import DischargeView
from grainfit.bulk_tests.recorded_trials import RecordedTrials
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.shared.flow_target import flow_depth, unusual_flow
from grainfit.bulk_tests.shared.options import (
    FILL_HEIGHT,
    LENGTH,
    SLOT_WIDTH,
    flow_settling_option,
    length_option,
)
from grainfit.bulk_tests.shared.orifice import narrow_orifice
from grainfit.bulk_tests.shared.slot_scene import BED, END, FLOW, INSIDE, fill_and_flow
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.errors import Fault, NotMeasurableError
from grainfit.evaluation import Measured, Response
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.measurement.bulk_density import bulk_density, bulk_density_in_box
from grainfit.measurement.flow_rate import FlowRate, discharged_mass
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.options.kinds import Choice
from grainfit.scenes.packing import Column, Footprint
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Scene, Stage

_PICTURE = "discharge.png"
#: Height that particles fall below the orifice before they are gone, in diameters.
_SINK = 4.0
_USUAL_APPARATUS = VariedOptions(
    "width",
    Range(0.8, 1.3, power=-1),
    factors={"slot_width": Range(0.8, 1.6), "fill_height": Range(0.7, 1.4)},
    indifferent=("flow_until",),
)


@dataclass(frozen=True)
class Discharge(BulkTest):
    """Discharge of a flat-bottomed container: mass flow and bulk density.

    Particles rain into a container. Once the bed is at rest its bulk density is measured, and the
    orifice in the middle of its flat floor is opened. The mass in the container is recorded until
    its flow is known, or until nothing moves any more; particles that have left are gone. A
    material that arches over the orifice has a mass flow of zero. With a slot the container is a
    slice of periodic depth without end walls, with a round orifice it is a cylinder.

    Defaults follow the Sauter diameter d of the particles, and are never smaller than the largest
    particles allow; times follow d by Froude's law. The options are the fields below, as in the
    calibration file.

    Examples
    --------
    >>> Discharge(diameter="10 mm").setup.container.slot_width
    0.05
    >>> Discharge(diameter="10 mm", orifice="round").setup.container.orifice_radius
    0.03
    """

    type: ClassVar[str] = "discharge"
    title: ClassVar[str] = "flat-bottomed container"
    vessel: ClassVar[str] = "width"
    parts: ClassVar[Parts] = {
        # A box with a slot, or a tube with a round orifice.
        "container": ("left", "right", "tube"),
        "floor": ("left_shelf", "right_shelf", "floor", "door"),
    }
    revision: ClassVar[int] = 1
    shown: ClassVar[Shown] = Shown("discharge", "mass_flow", snapshot_file(END), _PICTURE)
    checks: ClassVar[Checks] = (
        narrow_orifice(lambda test: test.setup.container.orifice),
        flow_depth,
        unusual_flow,
    )
    worse_ends: ClassVar[Mapping[str, int]] = {ASPECT_RATIO: 1}
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS,)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "mass_flow": ResponseInfo(
            "kg/s",
            "ṁ",
            "mass flow: mass through the orifice per time, of the whole simulated depth of a slot",
            '{ value = "1.16 kg/s", uncertainty = "3 %" }',
            RecordedTrials(0.04),
            lowest=0.0,
            above_zero=False,
            why="Nothing flows back; where the material arches, nothing flows.",
            at_zero="arched: no flow",
        ),
        "bulk_density": ResponseInfo(
            "kg/m^3",
            "ρ_b",
            "bulk density: mass of the bed over its volume, voids included",
            '{ value = "1350 kg/m^3", uncertainty = "1 %" }',
            RecordedTrials(0.004, (0.042, 0.066)),
        ),
    }

    curves: ClassVar[Mapping[str, CurveInfo]] = {
        "discharged_mass": CurveInfo(
            "kg",
            "m",
            "mass over time: mass that has left the container since the orifice was opened, of the "
            "whole simulated depth of a slot",
            "time",
            "s",
            lowest=0.0,
            rises=True,
            why="It is the mass that has left: give what is below the outlet, or the first mass "
            "less that in the container.",
        ),
    }

    orifice: str = option(
        Choice((SLOT, ROUND)),
        "Shape of the orifice: a slot in a slice of periodic depth, or a round hole in a cylinder "
        "(LAMMPS and LIGGGHTS).",
        example=f'"{SLOT}"',
        default=SLOT,
        default_text=f'`"{SLOT}"`',
    )
    slot_width: Amount | None = option(
        LENGTH,
        SLOT_WIDTH,
        example='"50 mm"',
        default=Derived("5 d", lambda s: s.of_slot("slot_width", 5)),
    )
    depth: Amount | None = option(
        LENGTH,
        "Depth of the simulated slice of a slot; it repeats without end. The mass flow is that of "
        "this depth.",
        example='"50 mm"',
        default=Derived("5 d", lambda s: s.of_slot("depth", 5)),
    )
    orifice_diameter: Amount | None = option(
        LENGTH,
        "Diameter of a round orifice.",
        example='"60 mm"',
        default=Derived("6 d", lambda s: s.usual_orifice),
    )
    width: Amount | None = length_option(
        "width", 16, "Inner width of the container; with a round orifice its inner diameter."
    )
    fill_height: Amount | None = length_option("fill_height", 16, FILL_HEIGHT)
    settling_time_limit: Amount | None = flow_settling_option('"8 s"', "four")
    flow_until: str = option(
        Choice((MEASURED, AT_REST)),
        f'End of a run: `"{MEASURED}"`, once 55 % of the mass has flowed out, or `"{AT_REST}"`, '
        "once all is at rest, as a measured curve needs.",
        example=f'"{AT_REST}"',
        default=MEASURED,
        default_text=f'`"{MEASURED}"`; `"{AT_REST}"` with a measured `discharged_mass`',
    )
    curve_options: ClassVar[Mapping[str, str]] = {"flow_until": AT_REST}

    setup = cached_property(DischargeSetup)

    size_powers: ClassVar[Mapping[str, float | None]] = {}
    flow_powers: ClassVar[Mapping[str, float]] = {"mass_flow": 1}

    def definition(self) -> dict[str, Any]:
        """Return everything in the test that affects a run's outcome, as JSON."""
        found = super().definition()
        if self.flow_until == AT_REST:
            # As before there was another end.
            found.pop("flow_until", None)
        return found

    @classmethod
    def from_definition(cls, definition: Mapping[str, Any]) -> Self:
        """Rebuild the test from the definition in the record of a run."""
        return super().from_definition({"flow_until": AT_REST, **definition})

    @property
    def outlet_flow(self) -> float:
        """Flow of the outlet by Beverloo's law, in natural units."""
        return self.setup.outlet_flow

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large.

        An outlet becomes narrower as long as nothing arches over it, and no wider: flow follows it.
        """
        options = scaled(self, scale, depth=1, width=1, fill_height=1)
        return options | self.setup.outlet_at(scale)

    def material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over why enlarged particles would arch over the orifice."""
        return self.setup.container.orifice.coarse_graining_faults(self._sizes_of(material))

    def curve_range(self, name: str) -> CurveRange:  # noqa: ARG002
        """Return the times since the orifice was opened: what has left stays so."""
        return CurveRange(low=0.0)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container that is filled."""
        return self.setup.footprint

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls, the orifice is opened, the bed flows out."""
        setup, largest = self.setup, self.setup.largest
        container, filling = setup.container, setup.filling
        top = max(column.height, container.slope_top) + 1.25 * largest
        side, bottom = setup.half_box + 1.5 * largest, -_SINK * largest
        if container.period is not None:
            box = Box((-side, 0.0, bottom), (side, container.period, top), periodic="y")
        else:
            box = Box((-side, -side, bottom), (side, side, top))
        return self.scene_with(
            material,
            filling,
            title=f"Discharge of a {self.title}",
            particles=column,
            box=box,
            walls=container.walls(top, largest),
            stages=self._stages(),
        )

    def _stages(self) -> tuple[Stage, ...]:
        setup = self.setup
        return fill_and_flow(setup.filling, setup.flow, setup.underside)

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure mass flow and bulk density; leave a picture and a VTK file of the end.

        Raises
        ------
        RunFailedError
            The simulation did not end as a discharge requires: a bed did not come to rest,
            particles broke out or overlap grossly, or a stage is missing.
        NotMeasurableError
            A response has no value, with the reason.
        """
        run.require_complete([stage.name for stage in self._stages()], "container")
        bed = run.snapshot(BED)
        require_separate(bed)
        view = self.view(run)
        write_vtk(run.folder / f"{self.type}.vtk", view.end)
        picture = run.folder / self.shown.picture
        try:
            flow = view.flow()
            others = self._beside_flow(bed, view, flow)
        except NotMeasurableError as error:
            view.picture(picture, str(error))
            raise
        known = (
            f"{self.responses[name].description.partition(':')[0]} {_rounded(response)} "
            f"{self.responses[name].unit}"
            for name, response in others.items()
        )
        view.picture(picture, flow, f"{', '.join(known)} (± standard error)")
        curve = discharged_mass(view.time, view.mass, is_whole=view.is_whole)
        return {"mass_flow": flow.response, **others, "discharged_mass": curve}

    def _beside_flow(
        self,
        bed: Particles,
        view: DischargeView,  # noqa: ARG002
        flow: FlowRate,  # noqa: ARG002
    ) -> dict[str, Response]:
        """Return the responses beside the mass flow."""
        return {"bulk_density": self._bulk_density(bed, *self.setup.density_heights)}

    def _bulk_density(self, bed: Particles, bottom: float, top: float) -> Response:
        container = self.setup.container
        if container.period is not None:
            return bulk_density_in_box(bed, 2 * container.half_width, container.period, bottom, top)
        return bulk_density(bed, container.half_width, bottom, top)

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Estimate the simulated time of a run, s."""
        return self.setup.filling.usual_time + self.setup.time_to_end

    def view(self, run: RunOutput) -> DischargeView:
        """Read the end of a run, to be drawn."""
        series, end = run.series(FLOW, [INSIDE]), run.snapshot(END)
        diameter = self.sizes.sauter_diameter
        return DischargeView(self.setup, end, series["time"], series[INSIDE], diameter)


def _rounded(response: Response) -> str:
    return f"{response.value:.4g} ± {response.standard_error:.1g}"
