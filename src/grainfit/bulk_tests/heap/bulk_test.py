"""The heap test: fill a cylinder, strike off, measure the bulk density, lift, measure the heap."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from scipy.spatial import cKDTree

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.heap.deck import HeapDeck, deck_fingerprint, heap_time_step
from grainfit.bulk_tests.heap.setup import HeapSetup, plan_setup
from grainfit.bulk_tests.shared.packing import PACKING_REVISION
from grainfit.bulk_tests.shared.stages import find_log, require_complete
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.evaluation import Response
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.angle_of_repose import AngleOfRepose, angle_of_repose
from grainfit.measurement.bulk_density import bulk_density
from grainfit.measurement.particles import Particles, read_dump, write_vtk
from grainfit.measurement.picture import draw_heap

#: Raised whenever the procedure or its evaluation changes in a way the deck does not show.
_REVISION = 1
#: Overlap over diameter above which contacts are no longer those of spheres.
_LARGEST_MEAN_OVERLAP = 0.08
#: Particles times time steps per second on one core of a current processor.
_SPEED = {"lammps": 2.2e6, "liggghts": 2.5e6}
#: Two ranks are about 15 % faster than one: a heap is too small to share.
_RANKS_EXPONENT = 0.2
#: The bed is at rest soon after the shortest fill stage; the lift ends before its longest way.
_FILL_SHARE = 1.25
_LIFT_SHARE = 0.9


@dataclass(frozen=True)
class HeapTest(BulkTest):
    """Lifted cylinder: bulk density and angle of repose from one test.

    Particles rain into an upright cylinder on a plate. Once the bed is at rest its bulk density is
    measured, what stands above the strike-off height is taken away, the cylinder is lifted slowly,
    and once the heap is at rest its angle of repose is measured on silhouettes. Every stage ends
    when the particles are at rest, not after a fixed time.

    Lengths are in m; the defaults in brackets are in Sauter diameters d of the particles. Speeds
    and times follow d by Froude's law, so that the test is the same test at every size.

    Parameters
    ----------
    sizes : ParticleSizes
        Particle size distribution.
    particle_count : int, optional
        Particles rained in (as many as fill the cylinder: 1500 of one size).
    cylinder_radius : float, optional
        Inner radius of the cylinder (6 d).
    plate_radius : float, optional
        Radius of the plate, whose edge is free unless it has a rim (16 d).
    rim_height : float
        Height of a rim around the plate.
    strike_off_height : float, optional
        Particles with their centre above are taken away before the lift (10.5 d).
    bulk_density_bottom, bulk_density_top : float, optional
        The bulk density is that of the bed between these heights (1 d and 9 d).
    lift_speed : float, optional
        Speed of the cylinder, m/s (0.05 m/s for d = 10 mm). It decides the angle of repose and must
        be that of the laboratory.
    lift_height : float, optional
        Longest way of the cylinder (10 d); the lift ends earlier once the cylinder is clear of a
        heap at rest.
    plate_sliding_friction : float
        Between particles and plate.
    plate_rolling_friction : float, optional
        Between particles and plate (as between two particles).
    gravity : float
        m/s^2.
    time_step_fraction : float
        Time step over the Rayleigh time step. Above about 0.12, beds of high rolling friction may
        never come to rest.
    settling_time_limit : float, optional
        Longest simulated time, s, in which the filled bed and the heap may come to rest (ten times
        the time of fall).
    views : int
        Silhouettes on which the angle of repose is measured.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.

    Examples
    --------
    >>> HeapTest(ParticleSizes((0.010,))).setup.cylinder_radius
    0.06
    """

    type: ClassVar[str] = "heap"
    response_units: ClassVar[Mapping[str, str]] = {
        "bulk_density": "kg/m^3",
        "angle_of_repose": "deg",
    }

    sizes: ParticleSizes
    particle_count: int | None = None
    cylinder_radius: float | None = None
    plate_radius: float | None = None
    rim_height: float = 0.0
    strike_off_height: float | None = None
    bulk_density_bottom: float | None = None
    bulk_density_top: float | None = None
    lift_speed: float | None = None
    lift_height: float | None = None
    plate_sliding_friction: float = 0.5
    plate_rolling_friction: float | None = None
    gravity: float = 9.81
    time_step_fraction: float = 0.12
    settling_time_limit: float | None = None
    views: int = 12
    #: Geometry and procedure with every default worked out.
    setup: HeapSetup = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        options = {
            option.name: getattr(self, option.name)
            for option in fields(self)
            if option.name not in ("sizes", "setup")
        }
        object.__setattr__(self, "setup", plan_setup(self.sizes, options))

    def definition(self) -> dict[str, Any]:
        """Return all of the test that decides a run's outcome, as JSON."""
        return {
            "type": self.type,
            "revision": _REVISION,
            "deck": deck_fingerprint(),
            "packing": PACKING_REVISION,
            "diameters": list(self.sizes.diameters),
            "mass_fractions": list(self.sizes.mass_fractions),
            "setup": asdict(self.setup),
            "plate_sliding_friction": self.plate_sliding_friction,
            "plate_rolling_friction": self.plate_rolling_friction,
            "time_step_fraction": self.time_step_fraction,
            "views": self.views,
        }

    @property
    def ground(self) -> float:
        """Height from which the flanks of the heap are measured, m, see `angle_of_repose`."""
        return max(self.setup.rim_height, self.sizes.sauter_diameter)

    def time_step(self, material: Mapping[str, float]) -> float:
        """Return the time step of a run with this material, s."""
        return heap_time_step(self.sizes, material, self.time_step_fraction)

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
            self.plate_sliding_friction,
            rolling,
            self.time_step(material),
        )
        return deck.write(folder, solver, seed)

    def measure(self, folder: Path) -> dict[str, Response]:
        """Measure bulk density and angle of repose; leave a picture and a VTK file of the heap.

        Raises
        ------
        RunFailedError
            The simulation did not go as a heap test must: a bed did not come to rest, particles
            broke out or overlap grossly, or a stage is missing.
        NotMeasurableError
            A response has no value, with the reason.
        """
        log = find_log(folder)
        if log is not None:
            require_complete(log, self.setup.particle_count, self.setup.settling_time_limit)
        bed = read_dump(folder / "settled.dump")
        _require_separate(bed)
        heap = read_dump(folder / "heap.dump")
        write_vtk(folder / "heap.vtk", heap)
        angle = self._measure_angle(heap, folder / "heap.png")
        setup = self.setup
        density = bulk_density(
            bed, setup.cylinder_radius, setup.bulk_density_bottom, setup.bulk_density_top
        )
        return {"bulk_density": density, "angle_of_repose": angle.response}

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


@dataclass(frozen=True)
class RunCost:
    """Estimated cost of one run.

    Parameters
    ----------
    time_step : float
        Exact, s.
    steps : int
        Estimated number of time steps.
    wall_seconds : float
        Estimated wall time on an otherwise idle core.
    """

    time_step: float
    steps: int
    wall_seconds: float


def estimate_cost(
    test: HeapTest, solver: str, material: Mapping[str, float], ranks: int = 1
) -> RunCost:
    """Estimate the cost of one run.

    Parameters
    ----------
    test : HeapTest
        What is simulated.
    solver : str
        ``"lammps"`` or ``"liggghts"``.
    material : mapping of str to float
        At least density, Young's modulus and Poisson's ratio of the particles.
    ranks : int
        MPI ranks of the run.
    """
    setup = test.setup
    simulated = _FILL_SHARE * setup.fill_time + _LIFT_SHARE * setup.lift_height / setup.lift_speed
    time_step = test.time_step(material)
    steps = math.ceil(simulated / time_step)
    speed = _SPEED[solver] * ranks**_RANKS_EXPONENT
    return RunCost(time_step, steps, steps * setup.particle_count / speed)
