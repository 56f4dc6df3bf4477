"""The packing test: pour particles into a container, measure the bulk density."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from grainfit.bulk_tests.base import BulkTest, ResponseInfo
from grainfit.bulk_tests.packing.picture import draw_packing
from grainfit.bulk_tests.packing.setup import PackingSetup, plan_setup
from grainfit.bulk_tests.sensitivities import DENSITY, MODULUS, ROLLING, SLIDING, Sensitivities
from grainfit.bulk_tests.shared.filling import fill_stage
from grainfit.bulk_tests.shared.options import FILL_HEIGHT, LENGTH, TIME
from grainfit.bulk_tests.shared.pot_view import PotView, highest_point
from grainfit.bulk_tests.shared.validity import require_separate
from grainfit.bulk_tests.view import Shown
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.bulk_density import bulk_density
from grainfit.measurement.particles import write_vtk
from grainfit.options.fields import Amount, option
from grainfit.scenes.packing import Column, Footprint, Round
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Scene, Stage, Wall
from grainfit.scenes.shapes import Cylinder, Disc

_BED, _PICTURE = "bed", "packing.png"
#: The bed is at rest soon after the shortest fill stage.
_FILL_SHARE = 1.25


@dataclass(frozen=True)
class Packing(BulkTest):
    """Poured container: bulk density alone, in a few seconds of computing.

    Particles rain into an upright cylinder and come to rest; the bulk density is that of the bed
    between two heights. Defaults follow the Sauter diameter d of the particles, and are never
    smaller than the largest particles allow. The options are the fields below, as in the
    calibration file.

    Parameters
    ----------
    sizes : ParticleSizes, optional
        Particle size distribution.
    diameter : float, str or list, optional
        Instead of sizes: ``"10 mm"``, or a list of ``{"value": ..., "mass_fraction": ...}``.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.

    Examples
    --------
    >>> Packing(diameter="10 mm").setup.cylinder_radius
    0.06
    """

    type: ClassVar[str] = "packing"
    title: ClassVar[str] = "poured container"
    parts: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "container": ("container",),
        "floor": ("floor",),
    }
    shown: ClassVar[Shown | None] = Shown("bed", "bulk_density", snapshot_file(_BED), _PICTURE)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "bulk_density": ResponseInfo(
            "kg/m^3",
            "ρ_b",
            "bulk density: mass of the bed over its volume, voids included",
            '{ value = "1500 kg/m^3", uncertainty = "1 %" }',
            Sensitivities(
                {DENSITY: 1.07, MODULUS: -0.066, SLIDING: -0.059, ROLLING: -0.023},
                {SLIDING: -0.068, ROLLING: -0.006},
                scatter=0.006,
            ),
        ),
    }

    cylinder_radius: Amount | None = option(
        LENGTH, "Inner radius of the container.", example='"60 mm"', words="6 d"
    )
    fill_height: Amount | None = option(LENGTH, FILL_HEIGHT, example='"120 mm"', words="12 d")
    bulk_density_bottom: Amount | None = option(
        LENGTH, "The bulk density is measured from this height on.", example='"10 mm"', words="1 d"
    )
    bulk_density_top: Amount | None = option(
        LENGTH, "The bulk density is measured up to this height.", example='"90 mm"', words="9 d"
    )
    settling_time_limit: Amount | None = option(
        TIME,
        "Longest simulated time in which the bed may come to rest.",
        example='"2 s"',
        words="ten times the time of fall",
    )
    #: Geometry and procedure, with every default resolved.
    setup: PackingSetup = field(init=False, repr=False, compare=False)

    def prepare(self) -> None:
        """Resolve geometry and procedure."""
        object.__setattr__(self, "setup", plan_setup(self.sizes, self.given_options()))

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container that is filled."""
        return Round(self.setup.cylinder_radius)

    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment: a column falls and comes to rest."""
        setup, largest = self.setup, max(self.sizes.diameters)
        radius, filling = setup.cylinder_radius, setup.filling
        top = column.height + 1.25 * largest
        side = radius + 1.5 * largest
        return Scene(
            title="Packing test: a poured container",
            material=material,
            sizes=self.sizes,
            particles=column,
            box=Box((-side, -side, -3 * largest), (side, side, top + 2 * largest)),
            walls={
                "container": Wall(Cylinder(radius, 0.0, top)),
                "floor": Wall(Disc(side - largest / 2, 0.0)),
            },
            stages=self._stages(),
            gravity=float(self.gravity),
            time_step=self.time_step(material),
            quiet_speed=filling.quiet_speed,
            check_interval=filling.check_interval,
        )

    def _stages(self) -> tuple[Stage, ...]:
        setup = self.setup
        return (fill_stage(setup.filling.fill_time, setup.settling_time_limit, _BED),)

    def measure(self, run: RunOutput) -> dict[str, Response]:
        """Measure the bulk density; leave a picture and a VTK file of the bed.

        Raises
        ------
        RunFailedError
            The bed did not come to rest, particles broke out or overlap grossly.
        NotMeasurableError
            The bed does not reach the height up to which it is measured.
        """
        run.require_complete([stage.name for stage in self._stages()], "container")
        view = self.view(run)
        require_separate(view.particles)
        write_vtk(run.folder / "packing.vtk", view.particles)
        setup = self.setup
        try:
            density = bulk_density(
                view.particles,
                setup.cylinder_radius,
                setup.bulk_density_bottom,
                setup.bulk_density_top,
            )
        except NotMeasurableError as error:
            draw_packing(run.folder / _PICTURE, view, setup, str(error))
            raise
        draw_packing(run.folder / _PICTURE, view, setup, density)
        return {"bulk_density": density}

    @property
    def number_of_particles(self) -> int:
        """Number of particles rained in."""
        return self.setup.filling.particle_count

    def simulated_time(self, material: Mapping[str, float]) -> float:  # noqa: ARG002
        """Estimate the simulated time of a run, s."""
        return _FILL_SHARE * self.setup.filling.fill_time

    def view(self, run: RunOutput) -> PotView:
        """Read the bed of a run, to be drawn."""
        bed = run.snapshot(_BED)
        if not len(bed):
            raise NotMeasurableError("no particles are left in the container")
        words = f"mass over volume {self.setup.measured_heights}"
        return PotView(bed, self.setup.cylinder_radius, highest_point(bed), words)
