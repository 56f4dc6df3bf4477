"""The mixing drum of Dosta et al. (2024), two materials, at a reduced stiffness.

30,000 spheres of 2 mm (M1) on 8,000 of 4 mm (M2) in a drum of 0.2 m, 60 mm long, that turns at
2 rad/s. Properties are those of [YADE's deck](https://gitlab.com/yade-dev/trunk) for the paper,
``examples/DEM2020Benchmark``; the counts are from the paper's data, Zenodo 8252892.

References
----------
Dosta et al. (2024), Computer Physics Communications 296:109066: eight programs.
"""

from __future__ import annotations

import math
import resource
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from grainfit.bulk_tests.heap import Heap
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import Particles
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import Frames
from grainfit.scenes.scene import (
    Box,
    Rotation,
    Scene,
    Stage,
    Wall,
    natural_speed,
    natural_time,
    time_step,
)
from grainfit.scenes.shapes import Cylinder, Plane
from grainfit.solvers.base import Workspace
from studies.benchmarks.published import rows_of
from studies.benchmarks.sandpile import mass_fractions
from studies.benchmarks.silo import GRAVITY, MATERIAL, PUBLISHED_MODULUS, material_of
from studies.benchmarks.two_materials import SecondMaterial, two_materials

DIAMETERS, COUNTS = (0.002, 0.004), (30_000, 8_000)
RADIUS, LENGTH, SPEED = 0.1, 0.06, 2.0
#: Density of M2, kg/m^3, its Young's modulus over that of M1, and its contacts.
SECOND: Mapping[str, float] = {
    "particle.density": 2000.0,
    "particle_particle.sliding_friction": 0.4,
    "particle_particle.restitution": 0.4,
}
SOFTER = 0.5
BETWEEN: Mapping[str, float] = {
    "particle_particle.sliding_friction": 0.2,
    "particle_particle.restitution": 0.45,
}
#: Counts of the published table, in its order; how many spheres there are; time between two, s.
ZONES = ("upper_small", "upper_large", "lower_small", "lower_large")
ALL = COUNTS * 2
EVERY = 0.1
PROGRAMS: Mapping[str, str] = {"musen": "MUSEN", "liggghts": "LIGGGHTS"}
#: Largest mean difference of a count from the published one, as a share of all such spheres.
AGREES = 0.03


class Drum(NamedTuple):
    """A drum: the solver, Young's modulus of M1 in Pa, and the time that it turns in s."""

    solver: str
    modulus: float
    time: float


#: Young's moduli of M1, Pa: a softer one shows the influence of the stiffness.
SOFT, MODULUS = 0.625e6, 2.5e6
#: Times that the drum turns, s: as published, about a turn, and for the influence of the stiffness.
PUBLISHED_TIME, TIME, PART = 5.0, 3.0, 1.0


def all_drums(solvers: Sequence[str]) -> list[Drum]:
    """Return all drums; YADE is left out, which takes ten times as long."""
    found = [Drum(solver, MODULUS, TIME) for solver in solvers if solver != "yade"]
    return [*found, *([Drum("lammps", SOFT, PART)] if "lammps" in solvers else [])]


def full_drums(solvers: Sequence[str]) -> list[Drum]:
    """Return the drums as they were published: a day on a processor for each."""
    return [
        Drum(solver, PUBLISHED_MODULUS, PUBLISHED_TIME) for solver in solvers if solver != "yade"
    ]


def simulate(run: Drum) -> dict[str, Any]:
    """Simulate; return times, s, counts, centres of mass, m, and processor time, s."""
    scene = drum_scene(run)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        program = two_materials(run.solver, second(run))(Heap(diameter=f"{DIAMETERS[0]} m"), {})
        out = program.simulate(scene, Workspace(Path(folder)))
        out.require_complete(["fill", "turn"], "drum")
        frames = [*out.frames("turning")]
        beds = [out.snapshot("filled"), *(frame.particles for frame in frames)]
        begun = out.ends[0].step
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    times = [0.0, *((frame.step - begun) * scene.time_step for frame in frames)]
    return {
        "times": [round(time, 6) for time in times],
        "counts": [counted(bed) for bed in beds],
        "centres": [[round(value, 6) for value in centres(bed)] for bed in beds],
        "seconds": round(seconds, 2),
    }


def second(run: Drum) -> SecondMaterial:
    """Return the material of the large spheres."""
    softer = {"particle.youngs_modulus": SOFTER * run.modulus}
    return SecondMaterial({**MATERIAL, **SECOND, **softer}, BETWEEN)


def counted(bed: Particles) -> list[int]:
    """Return the numbers of small and large spheres in two quarters of the drum: `ZONES`."""
    y, z = bed.positions[:, 1], bed.positions[:, 2]
    small = _is_small(bed)
    quarters = ((y > 0) & (z > 0), (y < 0) & (z < 0))
    return [int((quarter & kind).sum()) for quarter in quarters for kind in (small, ~small)]


def centres(bed: Particles) -> list[float]:
    """Return y and z of the centres of the small and of the large spheres, m."""
    small = _is_small(bed)
    return [float(bed.positions[kind, axis].mean()) for kind in (small, ~small) for axis in (1, 2)]


def _is_small(bed: Particles) -> NDArray[np.bool_]:
    return bed.radii < sum(DIAMETERS) / 4


def drum_scene(run: Drum) -> Scene:
    """Return the drum: two layers come to rest in it, and it turns about the x axis."""
    sizes = ParticleSizes(DIAMETERS, mass_fractions(DIAMETERS, COUNTS))
    material = material_of(run.modulus)
    side, unit = RADIUS + DIAMETERS[1], natural_time(sizes, GRAVITY)
    margin = 1.5 * DIAMETERS[1]
    walls = {
        "drum": Wall(Cylinder(RADIUS, -margin, LENGTH + margin, "x")),
        "left": Wall(Plane("x", 0.0)),
        "right": Wall(Plane("x", LENGTH, upwards=False)),
    }
    return Scene(
        title="Mixing drum of Dosta et al. 2024",
        material=material,
        sizes=sizes,
        particles=filling(),
        box=Box((-margin, -side, -side), (LENGTH + margin, side, side)),
        walls=walls,
        stages=(
            Stage("fill", AtRest(150 * unit, 8 * unit), snapshot="filled", is_closed=True),
            Stage(
                "turn",
                Elapsed(run.time),
                motions=dict.fromkeys(walls, Rotation("x", SPEED)),
                frames=Frames("turning", EVERY),
                is_closed=True,
            ),
        ),
        gravity=GRAVITY,
        time_step=time_step(sizes, material, 0.19),
        quiet_speed=0.02 * natural_speed(sizes, GRAVITY),
        check_interval=1.5 * unit,
    )


def filling() -> Column:
    """Return the small spheres above the large ones, each on a shaken lattice."""
    random = np.random.default_rng(1)
    large = _layers(DIAMETERS[1], -RADIUS, COUNTS[1])
    small = _layers(DIAMETERS[0], float(large[:, 2].max()) + DIAMETERS[1], COUNTS[0])
    places = np.concatenate([small, large])
    kinds = np.repeat([0, 1], COUNTS)
    shaken = 0.045 * np.array(DIAMETERS)[kinds]
    places += random.uniform(-1, 1, places.shape) * shaken[:, None]
    return Column(places, kinds, 2 * RADIUS)


def _layers(diameter: float, bottom: float, count: int) -> NDArray[np.float64]:
    """Return places of a lattice in the drum above a height."""
    spacing = 1.1 * diameter
    along = np.arange(0.6 * diameter, LENGTH - 0.6 * diameter, spacing)
    rows: list[NDArray[np.float64]] = []
    found, z = 0, bottom + 0.6 * diameter
    while found < count:
        half = math.sqrt(max((RADIUS - 0.6 * diameter) ** 2 - z**2, 0.0))
        across = np.arange(-half, half, spacing)
        x, y = (one.ravel() for one in np.meshgrid(along, across))
        rows.append(np.column_stack([x, y, np.full(len(x), z)]))
        found, z = found + len(x), z + spacing
    return np.concatenate(rows)[:count]


@cache
def published(program: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times, s, and counts of a published drum, shape (n, 4)."""
    own = rows_of("dosta/drum.csv", program=program)
    counts = [[float(row[zone]) for zone in ZONES] for row in own]
    return np.array([float(row["time_s"]) for row in own]), np.array(counts)


def expected(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the counts at some times, s, the mean of the published programs, shape (n, 4)."""
    each = [_between(*published(program), times) for program in PROGRAMS]
    return np.asarray(np.mean(each, axis=0))


def _between(
    times: NDArray[np.float64], counts: NDArray[np.float64], wanted: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return counts between the times at which they are known; those of the ends beyond them."""
    within = np.clip(wanted, times[0], times[-1])
    return np.asarray(PchipInterpolator(times, counts)(within))


def _mean_share(apart: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return mean absolute differences of the counts as shares of all such spheres."""
    return np.asarray(np.abs(apart).mean(axis=0) / np.array(ALL))


def _series(record: Mapping[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times, s, and counts of a record while the drum turns."""
    return np.array(record["times"])[1:], np.array(record["counts"], dtype=float)[1:]


def deviations(record: Mapping[str, Any], delay: float = 0.0) -> NDArray[np.float64]:
    """Return how far each count is from the published ones on average, as a share of all.

    With a delay, s, the published drum is so much later.
    """
    times, counts = _series(record)
    return _mean_share(counts - expected(times - delay))


def published_deviations(until: float) -> NDArray[np.float64]:
    """Return the same of the two published programs from each other, up to a time, s."""
    one, other = map(published, PROGRAMS)
    times = np.arange(EVERY, until, EVERY)
    return _mean_share(_between(*one, times) - _between(*other, times))


def lag(record: Mapping[str, Any]) -> float:
    """Return the delay of a drum behind the published ones that explains most, s."""
    delays = np.linspace(-0.1, 0.1, 41)
    return float(delays[np.argmin([deviations(record, delay).sum() for delay in delays])])


def drums_of(records: Mapping[Drum, Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Return the records that are compared with published ones, by solver."""
    return {run.solver: one for run, one in records.items() if run[1:] == (MODULUS, TIME)}


def change(records: Mapping[Drum, Mapping[str, Any]]) -> NDArray[np.float64]:
    """Return the mean difference of the counts of a softer drum from those of the usual one."""
    times, counts = _series(records[Drum("lammps", SOFT, PART)])
    usual = records[Drum("lammps", MODULUS, TIME)]
    return _mean_share(counts - _between(*_series(usual), times))
