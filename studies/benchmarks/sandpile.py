"""The sandpile of Ai et al. (2011): rolling models A (constant torque), B (viscous), C (EPSD).

3,000 discs flow out of a hopper through a channel onto a floor. Here they are spheres whose
centres stay in a plane. Geometry and properties are those of the paper as the examples of Lethe
have them (``examples/dem/2d-sandpile-formation``), which also have its curves, digitised, and those
of Lethe itself.

References
----------
Ai, Chen, Rotter & Ooi (2011), Powder Technology 206:269-282.
"""

from __future__ import annotations

import math
import resource
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.rolling_programs import ConstantTorqueInPlane, InPlane, ViscousTorque
from grainfit.bulk_tests.heap import Heap
from grainfit.contact_models.contact import TYPICAL_LOAD, particle_mass
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import Frames, KineticEnergy, Series
from grainfit.scenes.scene import Box, Scene, Stage, Wall, natural_speed, time_step
from grainfit.scenes.shapes import Block, Plane, Prism
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.registry import DEM_PROGRAMS

#: Diameters, m, and how many there are of each.
DIAMETERS, COUNTS = (0.0069, 0.0089), (2500, 500)
GRAVITY, SLIDING, ROLLING = 9.81, 0.8, 0.3
#: Half width of the channel, its length, height of the fall below it; slope of the hopper, m.
CHANNEL, LENGTH, FALL = 0.035, 0.220, 0.350
HOPPER, HEIGHT, FLOOR = 0.505, 0.570, 1.0
#: Times of filling and of the flow and rest that follow, s.
FILL, FLOW, EVERY = 0.5, 9.0, 0.25
#: Heights of the piles of the paper, and of Lethe, m: 5 s after the opening, and 4 s later.
PUBLISHED: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "Ai et al.": {"A": (0.242, 0.231), "B": (0.187, 0.187), "C": (0.272, 0.272)},
    "Lethe": {"A": (0.2441, 0.2309), "B": (0.1704, 0.1704), "C": (0.2302, 0.2302)},
}
NAMES: Mapping[str, str] = {
    "A": "rolling model A, constant torque",
    "B": "rolling model B, viscous",
    "C": "rolling model C, EPSD",
}
#: A height within this share of the published one agrees. Time for which a pile is watched, s.
AGREES, WATCHED = 0.05, 4.0
MATERIAL: Mapping[str, float] = {
    **{
        f"{body}.{key}": value
        for body in ("particle", "wall")
        for key, value in (("youngs_modulus", 4e6), ("poissons_ratio", 0.49), ("density", 1056.0))
    },
    **{
        f"{pair}.{key}": value
        for pair in ("particle_particle", "particle_wall")
        for key, value in (
            ("sliding_friction", SLIDING),
            ("rolling_friction", ROLLING),
            ("rolling_damping", 0.0),
            ("restitution", 0.7),
        )
    },
}


class Pile(NamedTuple):
    """A pile: the solver, and the model by the letter of the paper."""

    solver: str
    model: str


_PROGRAMS: Mapping[Pile, type[DeckSolver]] = {
    Pile("lammps", "C"): DEM_PROGRAMS["lammps"],
    Pile("liggghts", "A"): ConstantTorqueInPlane,
    Pile("lammps", "B"): ViscousTorque,
    Pile("liggghts", "C"): InPlane,
}


def all_piles(solvers: Sequence[str]) -> list[Pile]:
    """Return the piles that these solvers can make: no program has all three models."""
    return [pile for pile in _PROGRAMS if pile.solver in solvers]


def simulate(run: Pile) -> dict[str, Any]:
    """Simulate; return the height of the pile over time, m, its angle, and processor time, s."""
    program = _PROGRAMS[run](Heap(diameter=f"{DIAMETERS[0]} m"), {})
    if isinstance(program, ViscousTorque):
        # The published torque is mu_r R* F_n times the rolling velocity; here F_n is a typical one.
        weight = particle_mass(MATERIAL, DIAMETERS[0] / 2) * GRAVITY
        program.damping = ROLLING * TYPICAL_LOAD * weight
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        out = program.simulate(pile_scene(), Workspace(Path(folder)))
        out.require_complete(["fill", "flow"], "sandpile")
        places = [
            np.column_stack([frame.particles.positions, frame.particles.radii])
            for frame in out.frames("piling")
        ]
        energy = out.series("flow")["energy"]
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    piles = [measured(one) for one in places]
    weight = sum(
        count * particle_mass(MATERIAL, diameter / 2) * GRAVITY
        for diameter, count in zip(DIAMETERS, COUNTS, strict=True)
    )
    return {
        "heights": [round(height, 5) for height, _ in piles],
        "angle": round(piles[-1][1], 3),
        # Kinetic energy over the weight of the pile times a diameter, at the end.
        "restless": float(np.mean(energy[-20:])) / (weight * DIAMETERS[0]),
        "seconds": round(seconds, 2),
    }


def measured(spheres: np.ndarray[Any, Any]) -> tuple[float, float]:
    """Return the height of a pile on its floor, m, and the mean slope of its flanks, degrees.

    Parameters
    ----------
    spheres : ndarray of shape (n, 4)
        Centres, with heights above the end of the hopper, and radii.
    """
    x, tops = spheres[:, 0], spheres[:, 2] + spheres[:, 3] + LENGTH + FALL
    fallen = tops < FALL
    if not fallen.any():
        return 0.0, math.nan
    x, tops = x[fallen], tops[fallen]
    edges = np.arange(-FLOOR, FLOOR + 0.01, 0.02)
    which = np.digitize(x, edges)
    middles, heights = [], []
    for number in np.unique(which):
        middles.append(abs(edges[number - 1] + 0.01))
        heights.append(tops[which == number].max())
    away, profile = np.array(middles), np.array(heights)
    flank = (profile > 0.1 * profile.max()) & (profile < 0.9 * profile.max())
    if flank.sum() < 4:
        return float(profile.max()), math.nan
    slope = np.polyfit(away[flank], profile[flank], 1)[0]
    return float(profile.max()), math.degrees(math.atan(-slope))


def pile_scene() -> Scene:
    """Return the experiment: a hopper over a floor, whose door is taken away."""
    sizes = ParticleSizes(DIAMETERS, mass_fractions(DIAMETERS, COUNTS))
    column = _filling()
    deep, top = 3 * DIAMETERS[1], HEIGHT + 2 * DIAMETERS[1]
    floor = -LENGTH - FALL
    walls: dict[str, Wall] = {"floor": Wall(Plane("z", floor))}
    for name, sign in (("left", -1), ("right", 1)):
        near, far = sorted((sign * CHANNEL, sign * 1.1 * FLOOR))
        walls[f"{name}_channel"] = Wall(Block((near, -deep, -LENGTH), (far, deep, 0.0)))
        near, far = sorted((sign * CHANNEL, sign * 0.6 * FLOOR))
        shift = sign * (HOPPER - CHANNEL)
        walls[f"{name}_slope"] = Wall(Prism((near, -deep, 0.0), (far, deep, HEIGHT), shift))
    door = Block((-CHANNEL, -deep, -2 * DIAMETERS[1]), (CHANNEL, deep, 0.0))
    return Scene(
        title="Sandpile of Ai et al. 2011",
        material=MATERIAL,
        sizes=sizes,
        particles=column,
        box=Box((-1.2 * FLOOR, -2 * deep, floor - 0.01), (1.2 * FLOOR, 2 * deep, top)),
        walls={**walls, "door": Wall(door)},
        stages=(
            Stage("fill", Elapsed(FILL), is_closed=True),
            Stage(
                "flow",
                Elapsed(FLOW),
                take_away=("door",),
                series=Series({"energy": KineticEnergy()}, EVERY / 10),
                frames=Frames("piling", EVERY),
            ),
        ),
        gravity=GRAVITY,
        time_step=time_step(sizes, MATERIAL, 0.19),
        quiet_speed=0.01 * natural_speed(sizes, GRAVITY),
        check_interval=0.1,
    )


def mass_fractions(diameters: Sequence[float], counts: Sequence[int]) -> tuple[float, ...]:
    """Return the share of the mass in each diameter, of which there are so many spheres."""
    masses = [count * diameter**3 for diameter, count in zip(diameters, counts, strict=True)]
    return tuple(mass / sum(masses) for mass in masses)


def _filling() -> Column:
    """Return spheres in a plane, mixed, loosely above the door."""
    rng = np.random.default_rng(1)
    places = np.array([*_places(1.1 * DIAMETERS[1], sum(COUNTS))])
    places[:, [0, 2]] += rng.uniform(-1, 1, (len(places), 2)) * 0.04 * DIAMETERS[1]
    kinds = np.repeat(np.arange(len(COUNTS)), COUNTS)
    rng.shuffle(kinds)
    return Column(places, kinds, float(places[:, 2].max()) + DIAMETERS[1])


def _places(spacing: float, count: int) -> Iterator[tuple[float, float, float]]:
    """Yield places of a square lattice between the slopes, from below."""
    wider = (HOPPER - CHANNEL) / HEIGHT
    clear = 0.6 * DIAMETERS[1] * math.hypot(1, wider)
    row = found = 0
    while True:
        z = (row + 0.6) * spacing
        half = CHANNEL + wider * z - clear
        for number in range(-int(half / spacing), int(half / spacing) + 1):
            yield number * spacing, 0.0, z
            found += 1
            if found == count:
                return
        row += 1


def formed(record: Mapping[str, Any]) -> float:
    """Return the height of a pile that has formed, m: what flows down is not above it then."""
    return float(record["heights"][-1 - round(WATCHED / EVERY)])


def sinking(record: Mapping[str, Any]) -> float:
    """Return how much a pile that has formed sinks in a second, m/s."""
    return (formed(record) - float(record["heights"][-1])) / WATCHED


def published_sinking(source: str, model: str) -> str:
    """Return how much a published pile sinks in a second, in words."""
    first, later = PUBLISHED[source][model]
    return f"{1000 * (first - later) / WATCHED:.1f}"
