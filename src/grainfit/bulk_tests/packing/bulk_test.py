"""The packing test: pour particles into a container, measure the bulk density."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from grainfit.bulk_tests.base import BulkTest, Checks, Parts
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared import messages, options
from grainfit.bulk_tests.shared.filling import Filling, count_faults, cylinder_faults, plan_filling
from grainfit.bulk_tests.shared.narrow_cylinder import narrow_cylinder
from grainfit.bulk_tests.shared.pot_view import PotView, highest_point
from grainfit.bulk_tests.shared.responses import BULK_DENSITY
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.size import scaled
from grainfit.bulk_tests.varied_options import Range, VariedOptions
from grainfit.bulk_tests.view import Shown
from grainfit.errors import Fault, NotMeasurableError
from grainfit.evaluation import Measured, Response
from grainfit.measurement.bulk_density import bulk_density
from grainfit.measurement.particles import Particles, write_vtk
from grainfit.options.fields import Amount, Derived, option
from grainfit.scenes.packing import Column, Footprint, Round
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Scene, Wall
from grainfit.scenes.shapes import Cylinder, Disc

#: Snapshot of the poured bed.
BED = "bed"
_PICTURE = "packing.png"
#: Height that every settled bed reaches, over the height that it was planned with at a solid
#: fraction of 0.58. The densest beds, of smooth or soft particles and of mixtures, have 0.65 to
#: 0.67: they reach 0.86 to 0.89 of it.
_REACHED = 0.85


class PackingSetup(Setup):
    """Geometry and procedure of a packing test."""

    @cached_property
    def filling(self) -> Filling:
        """Particles of the container, and when they are at rest."""
        footprint = Round(self.cylinder_radius)
        return plan_filling(self.sizes, footprint, self.fill_height, self.gravity)

    @property
    def usual_top(self) -> float:
        """Height up to which the bulk density is measured by default, m."""
        top = max(9 * self.d, self.bulk_density_bottom + 2 * max(self.real.diameters))
        return min(top, _REACHED * self.fill_height) if self.is_given("fill_height") else top

    @property
    def measured_heights(self) -> str:
        """Heights between which the bulk density is measured, for readers."""
        low, high = 1000 * self.bulk_density_bottom, 1000 * self.bulk_density_top
        return f"between {low:.3g} and {high:.3g} mm"

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the container, then the number of its particles."""
        yield [*cylinder_faults(self.sizes, self.cylinder_radius), *self._height_faults()]
        lengths = {"cylinder_radius": self.cylinder_radius, "fill_height": self.fill_height}
        yield [*count_faults(self.filling.particle_count, lengths)]

    def _height_faults(self) -> Iterator[Fault]:
        bottom, top, height = self.bulk_density_bottom, self.bulk_density_top, self.fill_height
        if top - bottom < self.largest:
            yield messages.BETWEEN_HEIGHTS.fault(
                # A default top is this low only in a bed that is too low.
                "bulk_density_top" if self.is_given("bulk_density_top") else "fill_height",
                bottom=bottom,
                top=top,
            )
        if top > (1 + 1e-9) * _REACHED * height:
            yield messages.ABOVE_SETTLED_BED.fault(
                "bulk_density_top", top=top, height=height, highest=_REACHED * height
            )


_USUAL_APPARATUS = VariedOptions(
    "cylinder_radius",
    Range(0.7, 1.3, power=-1),
    factors={"fill_height": Range(0.6, 1.4)},
    indifferent=("bulk_density_bottom", "bulk_density_top"),
    left=("bulk_density_top",),
    particles=("cohesive", "clumps"),
)


@dataclass(frozen=True)
class Packing(BulkTest):
    """Poured container: bulk density alone, in a few seconds of computing.

    Particles rain into an upright cylinder and come to rest; the bulk density is that of the bed
    between two heights. Defaults are never smaller than the largest particles allow.

    Examples
    --------
    >>> Packing(diameter="10 mm").setup.cylinder_radius
    0.06
    """

    type: ClassVar[str] = "packing"
    checks: ClassVar[Checks] = (narrow_cylinder,)
    title: ClassVar[str] = "poured container"
    vessel: ClassVar[str] = "cylinder_radius"
    parts: ClassVar[Parts] = {"container": ("container",), "floor": ("floor",)}
    shown: ClassVar[Shown] = Shown("bed", "bulk_density", snapshot_file(BED), _PICTURE)
    #: Snapshot of the bed that is shown.
    bed_shown: ClassVar[str] = BED
    size_powers: ClassVar[Mapping[str, float | None]] = {}
    varied: ClassVar[tuple[VariedOptions, ...]] = (_USUAL_APPARATUS,)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {"bulk_density": BULK_DENSITY}

    cylinder_radius: Amount | None = options.cylinder_option("container", 6)
    fill_height: Amount | None = option(
        options.LENGTH,
        options.FILL_HEIGHT,
        example='"120 mm"',
        default=Derived("12 d", lambda s: max(12 * s.d, s.bulk_density_top / _REACHED)),
    )
    bulk_density_bottom: Amount | None = options.density_bottom_option()
    bulk_density_top: Amount | None = options.density_top_option("9 d", lambda s: s.usual_top)
    settling_time_limit: Amount | None = options.settling_option()

    setup = cached_property(PackingSetup)

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large."""
        return scaled(self, scale, cylinder_radius=1, fill_height=1, bulk_density_top=1)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container that is filled."""
        return Round(self.setup.cylinder_radius)

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls and comes to rest."""
        setup, filling, largest = self.setup, self.setup.filling, self.setup.largest
        top, side = column.height + 1.25 * largest, setup.cylinder_radius + 1.5 * largest
        return self.scene_with(
            material,
            filling,
            title="Packing test: a poured container",
            particles=column,
            box=Box((-side, -side, -3 * largest), (side, side, top + 2 * largest)),
            walls={
                "container": Wall(Cylinder(setup.cylinder_radius, 0.0, top)),
                "floor": Wall(Disc(side - largest / 2, 0.0)),
            },
            stages=(filling.stage(setup.settling_time_limit, BED),),
        )

    def measure(self, run: RunOutput) -> dict[str, Measured]:
        """Measure the bulk density; leave a picture and a VTK file of the bed."""
        run.require_complete(["fill"], "container")
        view, setup = self.view(run), self.setup
        write_vtk(run.folder / "packing.vtk", view.particles)
        try:
            density = self.density_of(view.particles)
        except NotMeasurableError as error:
            view.draw(run.folder / _PICTURE, "Bulk density: not measurable", str(error))
            raise
        title = f"Bulk density {density.value:.0f} ± {density.standard_error:.0f} kg/m^3"
        heights = f"± standard error; {setup.measured_heights}; the half behind the axis is shown"
        view.draw(run.folder / _PICTURE, title, heights)
        return {"bulk_density": density}

    def density_of(self, bed: Particles) -> Response:
        """Measure the bulk density of a bed between the heights of the test.

        Raises
        ------
        RunFailedError
            Particles overlap grossly.
        NotMeasurableError
            The bed is lower than the height up to which it is measured.
        """
        require_separate(bed)
        low, high = self.setup.bulk_density_bottom, self.setup.bulk_density_top
        return bulk_density(bed, self.setup.cylinder_radius, low, high)

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Estimate the simulated time of a run, s."""
        return self.setup.filling.usual_time

    def view(self, run: RunOutput) -> PotView:
        """Read the bed of a run, to be drawn."""
        bed = run.snapshot(self.bed_shown)
        if not len(bed):
            raise NotMeasurableError(messages.EMPTY_CONTAINER())
        words = f"mass over volume {self.setup.measured_heights}"
        return PotView(bed, self.setup.cylinder_radius, highest_point(bed), words)
