"""The silo of Dosta et al. (2024), at a reduced stiffness and with a part of its filling.

Geometry, numbers and properties are those of the decks for MercuryDPM that their authors publish
(``Drivers/Papers/OSBenchmark``): spheres of 4 mm in a tube 200 mm wide, over a cone of 45 degrees
down to an orifice of 60 or 40 mm. The curves of particles left in the silo are from the paper's
data, Zenodo 8252892.

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

from grainfit.bulk_tests.heap import Heap
from grainfit.contact_models.contact import particle_mass
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import MassAbove, Series
from grainfit.scenes.scene import Box, Scene, Stage, Wall, natural_speed, natural_time, time_step
from grainfit.scenes.shapes import Cone, Cylinder, Disc
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from studies.benchmarks.published import rows_of

DIAMETER, RADIUS, GRAVITY = 0.004, 0.100, 9.81
SIZES = ParticleSizes((DIAMETER,))
#: Young's modulus, Pa, and number of spheres of the paper.
PUBLISHED_MODULUS, PUBLISHED_COUNT = 1e9, 100_000
#: Mean of the paper's programs: particles a second out of 60 mm, within; ratio to 40 mm, within.
RATE, RATE_WITHIN, RATIO, RATIO_WITHIN = 23.2e3, 0.05, 3.10, 0.06
#: Material M1, and its contacts with steel.
MATERIAL: Mapping[str, float] = {
    "particle.poissons_ratio": 0.2,
    "particle.density": 2500.0,
    "wall.poissons_ratio": 0.2,
    "wall.density": 7200.0,
    "particle_particle.sliding_friction": 0.3,
    "particle_particle.restitution": 0.5,
    "particle_wall.sliding_friction": 0.2,
    "particle_wall.restitution": 0.4,
    **{
        f"{pair}.{name}": 0.0
        for pair in ("particle_particle", "particle_wall")
        for name in ("rolling_friction", "rolling_damping")
    },
}
#: Steel over particles.
STIFFER = 210.0
#: Time after the opening from which on the flow is steady, s; parts of it for its error.
STEADY, _PARTS = 0.1, 6


class Silo(NamedTuple):
    """A silo that flows: orifice in mm, Young's modulus in Pa, spheres, time of the flow in s."""

    solver: str
    orifice: int
    modulus: float
    spheres: int
    time: float
    seed: int


#: Softest first; the paper's own deck for a soft drum has 2 MPa.
MODULI = (2.5e6, 1e7, 4e7)
MODULUS = 1e7
#: Spheres and time of the flow by orifice: a steady flow, and no more.
PART: Mapping[int, tuple[int, float]] = {40: (15_000, 0.5), 60: (28_000, 0.45)}


def all_silos(solvers: Sequence[str]) -> list[Silo]:
    """Return all silos; YADE is left out, which takes ten times as long."""
    found = [
        Silo(solver, orifice, MODULUS, *PART[orifice], 1)
        for solver in solvers
        if solver != "yade"
        for orifice in PART
    ]
    if "lammps" in solvers:
        found += [Silo("lammps", 40, modulus, *PART[40], 1) for modulus in MODULI]
    return list(dict.fromkeys(found))


def full_silos(solvers: Sequence[str]) -> list[Silo]:
    """Return the silos as they were published: a day on a processor for each."""
    return [
        Silo(solver, orifice, PUBLISHED_MODULUS, PUBLISHED_COUNT, 5.0, 1)
        for solver in solvers
        for orifice in PART
    ]


def simulate(run: Silo) -> dict[str, Any]:
    """Simulate; return how many spheres are left over time, and processor time, s."""
    scene = silo_scene(run)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        program = DEM_PROGRAMS[run.solver](Heap(diameter=f"{DIAMETER} m"), {})
        out = program.simulate(scene, Workspace(Path(folder)))
        out.require_complete(["fill", "flow"], "silo")
        flow = out.series("flow")
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    mass = particle_mass(scene.material, DIAMETER / 2)
    opened = out.ends[0].time
    return {
        "times": [round(float(time - opened), 6) for time in flow["time"]],
        "left": [round(float(left)) for left in flow["left"] / mass],
        "seconds": round(seconds, 2),
    }


def material_of(modulus: float) -> dict[str, float]:
    """Return material M1 and steel, with another Young's modulus, Pa."""
    return {
        **MATERIAL,
        "particle.youngs_modulus": modulus,
        "wall.youngs_modulus": STIFFER * modulus,
    }


def silo_scene(run: Silo) -> Scene:
    """Return the silo: it is filled, comes to rest, and flows."""
    material = material_of(run.modulus)
    orifice = run.orifice / 2000
    slope = RADIUS - orifice
    column = filling(run.spheres, orifice, run.seed)
    top = max(column.height, slope) + 2 * DIAMETER
    unit = natural_time(SIZES, GRAVITY)
    below = -0.02 - DIAMETER
    wide = RADIUS + DIAMETER
    return Scene(
        title="Silo of Dosta et al. 2024",
        material=material,
        sizes=SIZES,
        particles=column,
        box=Box((-wide, -wide, below), (wide, wide, top)),
        walls={
            "tube": Wall(Cylinder(RADIUS, slope, top)),
            "cone": Wall(Cone(orifice, RADIUS, 0.0, slope)),
            "door": Wall(Disc(orifice + DIAMETER, 0.0)),
        },
        stages=(
            Stage("fill", AtRest(150 * unit, at_least=8 * unit), is_closed=True),
            Stage(
                "flow",
                Elapsed(run.time),
                take_away=("door",),
                series=Series({"left": MassAbove(0.0)}, every=0.005),
                snapshot="flowing",
            ),
        ),
        gravity=GRAVITY,
        time_step=time_step(SIZES, material, 0.19),
        quiet_speed=0.02 * natural_speed(SIZES, GRAVITY),
        check_interval=1.5 * unit,
    )


def filling(count: int, orifice: float, seed: int) -> Column:
    """Return spheres that fill the silo from below, loosely: on a shaken lattice."""
    spacing, shaken = 1.1 * DIAMETER, 0.045 * DIAMETER
    across = np.arange(-RADIUS, RADIUS, spacing)
    layers: list[NDArray[np.float64]] = []
    height, found = 0.0, 0
    while found < count:
        z = (0.6 + 1.1 * len(layers)) * DIAMETER
        # Distance of a centre from the cone, perpendicular to it, is at least 0.55 d.
        radius = min(RADIUS - 0.56 * DIAMETER, orifice + z - 0.56 * math.sqrt(2) * DIAMETER)
        x, y = (one.ravel() for one in np.meshgrid(across, across))
        inside = np.hypot(x, y) + math.sqrt(2) * shaken < radius
        layers.append(np.column_stack([x[inside], y[inside], np.full(inside.sum(), z)]))
        found, height = found + int(inside.sum()), z
    places = np.concatenate(layers)[:count]
    places += np.random.default_rng(seed).uniform(-shaken, shaken, places.shape)
    return Column(places, np.zeros(count, dtype=np.int64), height + DIAMETER)


@cache
def published(program: str, orifice: int) -> NDArray[np.float64]:
    """Return times, s, and spheres left in a published silo, shape (n, 2)."""
    own = rows_of("dosta/silo.csv", program=program, orifice_mm=str(orifice))
    return np.array([[float(row["time_s"]), float(row["left"])] for row in own])


class Flow(NamedTuple):
    """A steady flow: spheres a second, standard error, spheres left at its beginning and end."""

    rate: float
    error: float
    most: float
    fewest: float


def flow(record: Mapping[str, Any]) -> Flow:
    """Return the steady flow of a record; its error is from the scatter of its parts."""
    times, left = np.array(record["times"]), np.array(record["left"], dtype=float)
    steady = times >= STEADY
    times, left = times[steady], left[steady]
    slopes = [
        -np.polyfit(times[part], left[part], 1)[0]
        for part in np.array_split(np.arange(len(times)), _PARTS)
    ]
    error = float(np.std(slopes, ddof=1)) / math.sqrt(_PARTS)
    return Flow(float(-np.polyfit(times, left, 1)[0]), error, float(left[0]), float(left[-1]))


def published_rate(program: str, orifice: int, most: float, fewest: float) -> float:
    """Return the published spheres a second while so many are left; nan beyond the curve."""
    times, left = published(program, orifice).T
    if most > left[0] or fewest < left[-1]:
        return math.nan
    when = np.interp([-most, -fewest], -left, times)
    return (most - fewest) / float(when[1] - when[0])


def part_of(
    records: Mapping[Silo, Mapping[str, Any]], solver: str, orifice: int
) -> Mapping[str, Any] | None:
    """Return the record of the part of a silo with which published flows are compared."""
    return records.get(Silo(solver, orifice, MODULUS, *PART[orifice], 1))


def ratio_error(small: Mapping[str, Any], large: Mapping[str, Any]) -> float:
    """Return the standard error of the ratio of two flows."""
    flows = (flow(small), flow(large))
    shares = math.hypot(*(one.error / one.rate for one in flows))
    return flows[1].rate / flows[0].rate * shares


def published_words(orifice: int, most: float, fewest: float) -> str:
    """Return the published flows with as many spheres left in words; where there are none, all."""
    found = {"MUSEN": "musen", "LIGGGHTS": "liggghts"} if orifice == 60 else {"MUSEN": "musen"}
    words = []
    for name, program in found.items():
        rate = published_rate(program, orifice, most, fewest)
        after = "" if math.isfinite(rate) else ", with more left"
        if after:
            rate = published_rate(program, orifice, 95_000, 65_000)
        words.append(f"{rate:,.0f} ({name}{after})")
    return ", ".join(words)


def change(
    records: Mapping[Silo, Mapping[str, Any]], first: float, second: float
) -> tuple[float, float]:
    """Return the share by which a Young's modulus changes the flow, and its standard error."""
    small, large = (records[_of_stiffness(modulus)] for modulus in (first, second))
    return flow(large).rate / flow(small).rate - 1, ratio_error(small, large)


def _of_stiffness(modulus: float) -> Silo:
    return Silo("lammps", 40, modulus, *PART[40], 1)
