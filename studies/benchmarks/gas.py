"""A gas of smooth spheres without gravity: elastic, and cooling after Haff's law.

References
----------
Haff (1983), J. Fluid Mech. 134:401-430. The collision frequency is Enskog's, with the pair
distribution at contact of Carnahan & Starling (1969).
"""

from __future__ import annotations

import math
import resource
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from grainfit.bulk_tests.heap import Heap
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import KineticEnergy, Series
from grainfit.scenes.scene import Box, Scene, Stage, time_step
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.simulated_scenes import material

DIAMETER, SIDE, SPACING = 0.010, 8, 2.0
#: Standard deviation of a component of the velocity, m/s; Young's modulus, Pa; simulated time, s.
SPEED, MODULUS, SECONDS = 0.5, 1e8, 0.6
#: Time after which particles have left their lattice, s.
MIXED = 0.1
SEEDS = 5


class Gas(NamedTuple):
    """A gas on a solver."""

    solver: str
    restitution: float
    seed: int


def all_gases(solvers: Sequence[str]) -> list[Gas]:
    """Return all gases: the elastic one once."""
    return [
        Gas(solver, restitution, seed)
        for solver in solvers
        for restitution, seeds in ((1.0, 1), (0.9, SEEDS))
        for seed in range(1, seeds + 1)
    ]


def simulate(run: Gas) -> dict[str, Any]:
    """Simulate; return growth of the energy, rate of cooling over Haff's, and processor time, s."""
    values = {**material(run.restitution), "particle.youngs_modulus": MODULUS}
    scene = gas_scene(values, SPACING, SECONDS, run.seed)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        program = DEM_PROGRAMS[run.solver](Heap(diameter="10 mm"), {})
        out = program.simulate(scene, Workspace(Path(folder))).series("gas")
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    times, shares = out["time"], out["energy"] / scene.initial_energy
    # Haff: sqrt(E_0 / E) grows at a constant rate. The lattice delays the first collisions.
    mixed = times >= MIXED
    rate = float(np.polyfit(times[mixed], shares[mixed] ** -0.5, 1)[0])
    return {
        "growth": float(shares.max() - 1),
        "left": float(shares[-1]),
        "rate": rate,
        "seconds": round(seconds, 2),
    }


def gas_scene(values: Mapping[str, float], spacing: float, seconds: float, seed: int) -> Scene:
    """Return spheres on a lattice in a periodic box, with velocities but without a mean one.

    Parameters
    ----------
    values : mapping of str to float
        Material parameters.
    spacing : float
        Distance of neighbours in diameters.
    seconds : float
        Simulated time, s.
    seed : int
        Of the velocities.
    """
    sizes = ParticleSizes((DIAMETER,))
    series = Series({"energy": KineticEnergy()}, seconds / 100)
    side = spacing * DIAMETER * SIDE
    grid = np.array(np.meshgrid(*[np.arange(SIDE)] * 3)).reshape(3, -1).T
    places = (grid + 0.5) * side / SIDE
    velocities = np.random.default_rng(seed).normal(size=places.shape)
    velocities -= velocities.mean(axis=0)
    velocities *= SPEED / np.sqrt((velocities**2).mean())
    return Scene(
        title="Gas",
        material=values,
        sizes=sizes,
        particles=Column(places, np.zeros(len(places), int), side, velocities),
        box=Box((0, 0, 0), (side, side, side), periodic="xyz"),
        walls={},
        stages=(Stage("gas", Elapsed(seconds), series=series),),
        gravity=0.0,
        time_step=time_step(sizes, values, 0.1),
        quiet_speed=1e-9,
        check_interval=seconds,
    )


def cooling(records: Mapping[Gas, Mapping[str, Any]], solver: str) -> tuple[float, float]:
    """Return the mean rate of cooling over Haff's, and half of its 95 % interval over the seeds."""
    rates = [
        record["rate"] / haff_rate(run.restitution)
        for run, record in records.items()
        if run.solver == solver and run.restitution < 1
    ]
    error = float(np.std(rates, ddof=1)) / math.sqrt(len(rates))
    return float(np.mean(rates)), float(stats.t.ppf(0.975, len(rates) - 1)) * error


def growth(records: Mapping[Gas, Mapping[str, Any]], solver: str) -> float:
    """Return the largest share by which the kinetic energy of an elastic gas grows."""
    return max(
        float(record["growth"])
        for run, record in records.items()
        if run.solver == solver and run.restitution == 1
    )


def haff_rate(restitution: float) -> float:
    """Return the rate of cooling of hard smooth spheres, 1/s."""
    solid = math.pi / 6 / SPACING**3
    at_contact = (1 - solid / 2) / (1 - solid) ** 3
    number = 1 / (SPACING * DIAMETER) ** 3
    frequency = 4 * number * DIAMETER**2 * at_contact * math.sqrt(math.pi) * SPEED
    return (1 - restitution**2) * frequency / 6
