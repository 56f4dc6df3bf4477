"""Random packings of spheres that fell into a periodic box: solid fraction and coordination number.

References
----------
Counting degrees of freedom, a rigid packing that is only just held has 6 contacts a sphere without
friction, and 4 with unlimited friction (Makse, Johnson & Schwartz 2000, Phys. Rev. Lett. 84:4160).
Scott & Kilgour (1969), J. Phys. D 2:863-866: random close packing, 0.6366.
Steinhardt, Nelson & Ronchetti (1983), Phys. Rev. B 28:784: order of bonds Q6. It is 0.57 in a
face-centred cubic lattice, 0.48 in a hexagonal one, and 1 / sqrt(bonds) where there is no order.
"""

from __future__ import annotations

import math
import resource
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import legval
from scipy import stats
from scipy.spatial import cKDTree

from grainfit.bulk_tests.heap import Heap
from grainfit.evaluation import Response
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import Particles
from grainfit.scenes.conditions import AtRest
from grainfit.scenes.packing import PeriodicRectangle, random_column
from grainfit.scenes.scene import Box, Scene, Stage, Wall, natural_time, time_step
from grainfit.scenes.shapes import Plane
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.simulated_scenes import GRAVITY, material

DIAMETER, WIDTH, COUNT = 0.010, 8, 800
#: Layers that are left out at the floor and at the surface, diameters.
MARGIN = 2.5
CLOSE, ISOSTATIC = 0.6366, {0.0: 6.0, 10.0: 4.0}
#: Order of bonds above which a bed is no random one.
ORDERED = 0.2
#: YADE takes longest.
SEEDS: Mapping[str, int] = {"lammps": 3, "liggghts": 3, "yade": 1}
#: Young's moduli, Pa: what is compared is extrapolated from both to spheres that do not overlap.
MODULI = (1e6, 1e7)


class Packing(NamedTuple):
    """A packing on a solver."""

    solver: str
    friction: float
    modulus: float
    seed: int


Records = Mapping[Packing, Mapping[str, Any]]


def all_packings(solvers: Sequence[str]) -> list[Packing]:
    """Return all packings."""
    return [
        Packing(solver, friction, modulus, seed)
        for solver in solvers
        for seed in range(1, SEEDS[solver] + 1)
        for modulus in MODULI
        for friction in ISOSTATIC
    ]


def simulate(run: Packing) -> dict[str, Any]:
    """Simulate; return solid fraction, coordination number, overlap, and processor time, s."""
    sizes = ParticleSizes((DIAMETER,))
    values = {**material(0.5, run.friction), "particle.youngs_modulus": run.modulus}
    side = WIDTH * DIAMETER
    column = random_column(sizes, COUNT, PeriodicRectangle(side, side), run.seed)
    unit = natural_time(sizes, GRAVITY)
    rest = AtRest(400 * unit, at_least=20 * unit + 1.6 * math.sqrt(column.height / GRAVITY))
    scene = Scene(
        title="Packing",
        material=values,
        sizes=sizes,
        particles=column,
        box=Box((0, 0, -2 * DIAMETER), (side, side, column.height + DIAMETER), periodic="xy"),
        walls={"floor": Wall(Plane("z", 0.0))},
        stages=(Stage("fill", rest, snapshot="bed"),),
        gravity=GRAVITY,
        time_step=time_step(sizes, values, 0.2),
        quiet_speed=0.002 * math.sqrt(GRAVITY * DIAMETER),
        check_interval=1.5 * unit,
    )
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        program = DEM_PROGRAMS[run.solver](Heap(diameter="10 mm"), {})
        out = program.simulate(scene, Workspace(Path(folder)))
        found = measured(out.snapshot("bed")) | {"end": out.stages[-1].end}
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return found | {"seconds": round(seconds, 2)}


def measured(particles: Particles) -> dict[str, float]:
    """Return solid fraction, contacts of a sphere that is held, mean overlap in diameters, Q6."""
    places, side = particles.positions / DIAMETER, float(WIDTH)
    places[:, :2] %= side
    heights = places[:, 2]
    low, high = MARGIN, float(np.sort(heights)[-int(side**2 / 2)]) - MARGIN
    solid = float((_cap(heights, high) - _cap(heights, low)).sum() / (side**2 * (high - low)))
    raised = places + np.array([0.0, 0.0, 100.0])
    pairs = cKDTree(raised, boxsize=[side, side, 1000.0]).query_pairs(1.0, output_type="ndarray")
    between = places[pairs[:, 0]] - places[pairs[:, 1]]
    between[:, :2] -= side * np.round(between[:, :2] / side)
    overlaps = 1 - np.linalg.norm(between, axis=1)
    contacts = np.bincount(pairs.ravel(), minlength=len(places))
    # A sphere with fewer contacts is not held.
    counted = (heights > low) & (heights < high) & (contacts >= 3)
    return {
        "solid_fraction": solid,
        "coordination": float(contacts[counted].mean()),
        "overlap": float(overlaps.mean()),
        "order": order_of(between[counted[pairs].all(axis=1)]),
    }


def order_of(bonds: np.ndarray[Any, Any]) -> float:
    """Return the order Q6 of bonds, shape (n, 3)."""
    directions = bonds / np.linalg.norm(bonds, axis=1)[:, None]
    # By the addition theorem of spherical harmonics.
    of_pairs = legval(directions @ directions.T, [0, 0, 0, 0, 0, 0, 1])
    return math.sqrt(float(of_pairs.mean()))


def _cap(heights: np.ndarray[Any, Any], level: float) -> np.ndarray[Any, Any]:
    """Return the volume of spheres of diameter 1 below a level."""
    depth = np.clip(level - heights + 0.5, 0, 1)
    return math.pi * depth**2 * (1.5 - depth) / 3


def ordered(records: Records) -> list[Packing]:
    """Return the beds that are not random."""
    return [run for run, record in records.items() if record["order"] > ORDERED]


def without_overlap(records: Records, solver: str, friction: float) -> tuple[Response, Response]:
    """Return solid fraction and coordination number, extrapolated to no overlap.

    Above jamming the solid fraction grows with the overlap, and the number of contacts with its
    root (O'Hern, Silbert, Liu & Nagel 2003, Phys. Rev. E 68:011306). Beds that have ordered
    themselves are left out.
    """
    left_out = ordered(records)
    own = [
        record
        for run, record in records.items()
        if (run.solver, run.friction) == (solver, friction) and run not in left_out
    ]
    overlaps = np.array([record["overlap"] for record in own])
    return (
        _start(overlaps, [record["solid_fraction"] for record in own]),
        _start(np.sqrt(overlaps), [record["coordination"] for record in own]),
    )


def _start(x: np.ndarray[Any, Any], y: Sequence[float]) -> Response:
    """Return where a straight line begins, with its standard error: none through two points."""
    found = stats.linregress(x, y)
    return Response(float(found.intercept), float(found.intercept_stderr))
