"""The heap test: fill a cylinder, strike off, measure the bulk density, lift, measure the heap."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from scipy.spatial import cKDTree

from grainfit.bulk_tests.base import (
    GRAVITY,
    TIME_STEP_FRACTION,
    BulkTest,
    Conditions,
    ResponseInfo,
)
from grainfit.bulk_tests.heap.deck import HeapDeck, heap_time_step
from grainfit.bulk_tests.heap.setup import HeapSetup, plan_setup
from grainfit.bulk_tests.heap.view import HeapView
from grainfit.bulk_tests.run_cost import RunCost
from grainfit.bulk_tests.shared.packing import PACKING_REVISION
from grainfit.bulk_tests.shared.stages import find_log, require_complete
from grainfit.bulk_tests.view import Shown
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.evaluation import Response
from grainfit.measurement.angle_of_repose import AngleOfRepose, angle_of_repose, on_plate
from grainfit.measurement.bulk_density import bulk_density
from grainfit.measurement.particles import Particles, read_dump, write_vtk
from grainfit.measurement.picture import draw_heap
from grainfit.options.fields import Amount, option
from grainfit.options.kinds import Quantity, Whole

#: Part of the identity of runs: change it whenever the rendered decks change. Up to
#: version 0.1.0 it was a hash of the templates; this is theirs.
DECK_REVISION = "e11f78288590e984"
#: Files of a run: the particles at the end, and their silhouettes.
_HEAP, _PICTURE = "heap.dump", "heap.png"
#: Stages of the decks, in order.
_STAGES = ("fill", "lift", "heap")
#: Overlap over diameter above which contacts are no longer those of spheres.
_LARGEST_MEAN_OVERLAP = 0.08
#: Particles times time steps per second on one core of a current processor.
_SPEED = {"lammps": 2.2e6, "liggghts": 2.5e6}
#: Two ranks are about 15 % faster than one: a heap is too small to share.
_RANKS_EXPONENT = 0.2
#: The bed is at rest soon after the shortest fill stage; the lift ends before its longest travel.
_FILL_SHARE = 1.25
_LIFT_SHARE = 0.9


_LENGTH = Quantity("m", above_zero=True, highest=1e3)
_LENGTH_OR_ZERO = Quantity("m", lowest=0.0, highest=1e3)
_FRICTION = Quantity("", lowest=0.0, highest=10.0)


@dataclass(frozen=True)
class Heap(BulkTest):
    """Lifted cylinder: bulk density and angle of repose from one test.

    Particles rain into an upright cylinder on a plate. Once the bed is at rest its bulk density is
    measured, particles above the strike-off height are removed, the cylinder is lifted slowly,
    and once the heap is at rest its angle of repose is measured on silhouettes. Every stage ends
    when the particles are at rest, not after a fixed time.

    Defaults follow the Sauter diameter d of the particles; speeds and times follow it by Froude's
    law, so that the test is the same test at every size. The options are the fields below, as in
    the calibration file.

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
    >>> Heap(diameter="10 mm").setup.cylinder_radius
    0.06
    >>> Heap(diameter="10 mm", lift_speed="5 cm/s").setup.lift_speed
    0.05
    """

    type: ClassVar[str] = "heap"
    title: ClassVar[str] = "lifted cylinder"
    solvers: ClassVar[tuple[str, ...]] = ("lammps", "liggghts")
    shown: ClassVar[Shown | None] = Shown("heap", "angle_of_repose", _HEAP, _PICTURE)
    responses: ClassVar[Mapping[str, ResponseInfo]] = {
        "bulk_density": ResponseInfo(
            "kg/m^3",
            "ρ_b",
            "bulk density: mass of the bed over its volume, voids included",
            '{ value = "1500 kg/m^3", uncertainty = "1 %" }',
        ),
        "angle_of_repose": ResponseInfo(
            "deg",
            "α",
            "angle of repose: inclination of the heap's flanks",
            '{ value = "22 deg", uncertainty = "0.5 deg" }',
        ),
    }

    particle_count: int | None = option(
        Whole(1),
        "Number of particles rained in.",
        example="1500",
        words="as many as fill the cylinder",
    )
    cylinder_radius: Amount | None = option(
        _LENGTH, "Inner radius of the cylinder.", example='"60 mm"', words="6 d"
    )
    plate_radius: Amount | None = option(
        _LENGTH,
        "Radius of the plate, whose edge is free unless it has a rim.",
        example='"160 mm"',
        words="16 d",
    )
    rim_height: Amount = option(
        _LENGTH_OR_ZERO,
        "Height of a rim around the plate.",
        example='"10 mm"',
        default=0.0,
        words="0, a free edge",
    )
    strike_off_height: Amount | None = option(
        _LENGTH,
        "Particles with their centre above are removed before the lift.",
        example='"105 mm"',
        words="10.5 d",
    )
    bulk_density_bottom: Amount | None = option(
        _LENGTH, "The bulk density is measured from this height on.", example='"10 mm"', words="1 d"
    )
    bulk_density_top: Amount | None = option(
        _LENGTH, "The bulk density is measured up to this height.", example='"90 mm"', words="9 d"
    )
    lift_speed: Amount | None = option(
        Quantity("m/s", above_zero=True),
        "Speed of the cylinder. It affects the angle of repose: use the speed of the laboratory.",
        example='"0.05 m/s"',
        words="0.05 m/s for d = 10 mm",
    )
    lift_height: Amount | None = option(
        _LENGTH,
        "Longest travel of the cylinder; the lift ends earlier once the cylinder is clear of a "
        "heap at rest.",
        example='"100 mm"',
        words="10 d",
    )
    plate_sliding_friction: Amount = option(
        _FRICTION, "Sliding friction between particles and plate.", example="0.5", default=0.5
    )
    plate_rolling_friction: Amount | None = option(
        _FRICTION,
        "Rolling friction between particles and plate.",
        example="0.67",
        words="as between two particles",
    )
    gravity: Amount = option(
        Quantity("m/s^2", above_zero=True), "Gravity.", example="9.81", default=GRAVITY
    )
    time_step_fraction: Amount = option(
        Quantity("", highest=1.0, above_zero=True),
        "Time step over the Rayleigh time step. With larger ones, beds of high rolling friction "
        "may never come to rest.",
        example="0.12",
        default=TIME_STEP_FRACTION,
    )
    settling_time_limit: Amount | None = option(
        Quantity("s", above_zero=True),
        "Longest simulated time in which the bed and the heap may come to rest.",
        example='"2 s"',
        words="ten times the time of fall",
    )
    views: int = option(
        Whole(1, 360),
        "Number of silhouettes on which the angle of repose is measured.",
        example="12",
        default=12,
    )
    #: Geometry and procedure, with every default resolved.
    setup: HeapSetup = field(init=False, repr=False, compare=False)

    def prepare(self) -> None:
        """Resolve geometry and procedure."""
        options = {key.name: getattr(self, key.name) for key in self.option_keys()}
        object.__setattr__(self, "setup", plan_setup(self.sizes, options))

    def definition(self) -> dict[str, Any]:
        """Return everything in the test that affects a run's outcome, as JSON."""
        return {
            "type": self.type,
            "revision": self.revision,
            "deck": DECK_REVISION,
            "packing": PACKING_REVISION,
            "diameters": list(self.sizes.diameters),
            "mass_fractions": list(self.sizes.mass_fractions),
            "setup": asdict(self.setup),
            "plate_sliding_friction": self.plate_sliding_friction,
            "plate_rolling_friction": self.plate_rolling_friction,
            "time_step_fraction": self.time_step_fraction,
            "views": self.views,
        }

    @classmethod
    def from_definition(cls, definition: Mapping[str, Any]) -> Self:
        """Rebuild the test from the definition in the record of a run."""
        # Geometry and procedure are recorded with every default resolved.
        return super().from_definition({**definition["setup"], **definition})

    @property
    def conditions(self) -> Conditions:
        """Conditions under which the test uses the material."""
        return Conditions(self.sizes, self.setup.gravity, float(self.time_step_fraction))

    @property
    def ground(self) -> float:
        """Height from which the flanks of the heap are measured, m, see `angle_of_repose`."""
        return max(self.setup.rim_height, self.sizes.sauter_diameter)

    def time_step(self, material: Mapping[str, float]) -> float:
        """Return the time step of a run with this material, s."""
        return heap_time_step(self.sizes, material, float(self.time_step_fraction))

    def write_deck(
        self, folder: Path, solver: str, material: Mapping[str, float], seed: int
    ) -> Path:
        """Write everything that a solver reads into the folder; return the deck to start with."""
        rolling = self.plate_rolling_friction
        if rolling is None:
            rolling = material["particle_particle.rolling_friction"]
        deck = HeapDeck(
            self.setup,
            self.sizes,
            material,
            float(self.plate_sliding_friction),
            float(rolling),
            self.time_step(material),
        )
        return deck.write(folder, solver, seed)

    def measure(self, folder: Path) -> dict[str, Response]:
        """Measure bulk density and angle of repose; leave a picture and a VTK file of the heap.

        Raises
        ------
        RunFailedError
            The simulation did not end as a heap test requires: a bed did not come to rest,
            particles broke out or overlap grossly, or a stage is missing.
        NotMeasurableError
            A response has no value, with the reason.
        """
        log = find_log(folder)
        if log is not None:
            limit = self.setup.settling_time_limit
            require_complete(log, _STAGES, self.setup.particle_count, limit, "cylinder")
        bed = read_dump(folder / "settled.dump")
        _require_separate(bed)
        heap = read_dump(folder / _HEAP)
        write_vtk(folder / "heap.vtk", heap)
        angle = self._measure_angle(heap, folder / _PICTURE)
        setup = self.setup
        density = bulk_density(
            bed, setup.cylinder_radius, setup.bulk_density_bottom, setup.bulk_density_top
        )
        return {"bulk_density": density, "angle_of_repose": angle.response}

    def estimate_cost(self, solver: str, material: Mapping[str, float], ranks: int = 1) -> RunCost:
        """Estimate the cost of one run."""
        setup = self.setup
        simulated = _FILL_SHARE * setup.fill_time
        simulated += _LIFT_SHARE * setup.lift_height / setup.lift_speed
        time_step = self.time_step(material)
        steps = math.ceil(simulated / time_step)
        speed = _SPEED[solver] * ranks**_RANKS_EXPONENT
        seconds = steps * setup.particle_count / speed
        fraction = self.conditions.time_step_fraction
        return RunCost(time_step, steps, seconds, setup.particle_count, fraction)

    def view(self, folder: Path) -> HeapView:
        """Read the heap of a run, to be drawn."""
        plate = self.setup.plate_radius
        heap = on_plate(read_dump(folder / _HEAP), plate)
        if not len(heap):
            raise NotMeasurableError("no particles are left on the plate")
        return HeapView(heap, plate, self.setup.rim_height, self.ground, self.views)

    def _measure_angle(self, heap: Particles, picture: Path) -> AngleOfRepose:
        plate = self.setup.plate_radius
        try:
            angle = angle_of_repose(heap, self.ground, plate, self.views)
        except NotMeasurableError as error:
            draw_heap(picture, heap, plate, self.ground, str(error))
            raise
        draw_heap(picture, heap, plate, self.ground, angle)
        return angle


def _require_separate(bed: Particles) -> None:
    if not len(bed):
        raise NotMeasurableError("no particles are left in the cylinder")
    pairs = cKDTree(bed.positions).query_pairs(2 * bed.radii.max(), output_type="ndarray")
    distance = np.linalg.norm(bed.positions[pairs[:, 0]] - bed.positions[pairs[:, 1]], axis=1)
    overlap = 1 - distance / bed.radii[pairs].sum(axis=1)
    touching = overlap[overlap > 0]
    mean = float(touching.mean()) if len(touching) else 0.0
    if mean > _LARGEST_MEAN_OVERLAP:
        raise RunFailedError(
            f"the particles overlap grossly, by {100 * mean:.0f} % of their diameter on average: "
            "Young's modulus is too small for this load"
        )
