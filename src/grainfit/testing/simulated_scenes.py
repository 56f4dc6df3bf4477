"""Small scenes with closed forms, and the fixture that simulates them in a program under test."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.contact_models.contact import particle_mass
from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import Series
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Box, Scene, Stage, Wall, time_step
from grainfit.scenes.shapes import Plane
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver
from grainfit.testing.materials import GLASS_BEADS

GRAVITY = 9.81
RADIUS = 0.005
SIZES = ParticleSizes((2 * RADIUS,))
TIMEOUT = 120.0
#: A box that nothing in these tests leaves unless it is meant to, m.
BOX = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.2))
FLOOR = {"floor": Wall(Plane("z", 0.0))}
Run = Callable[[Scene], RunOutput]


def material(restitution: float = 1.0, sliding_friction: float = 0.0) -> dict[str, float]:
    """Return glass beads without rolling friction, with these values for all contacts."""
    contacts = {
        f"{pair}.{name}": value
        for pair in ("particle_particle", "particle_wall")
        for name, value in (
            ("restitution", restitution),
            ("sliding_friction", sliding_friction),
            ("rolling_friction", 0.0),
        )
    }
    return {**GLASS_BEADS, **contacts}


ELASTIC = material()
#: Deforms so little that the direction of a contact stays what it was at its beginning.
STIFF = {**ELASTIC, "particle.youngs_modulus": 1e8}
#: Comes to rest quickly.
DAMPED = material(restitution=0.3)
MASS = particle_mass(ELASTIC, RADIUS)
WEIGHT = MASS * GRAVITY


def spheres(
    positions: Sequence[Sequence[float]], velocities: Sequence[Sequence[float]] | None = None
) -> Column:
    """Return equal particles at these positions."""
    places = np.array(positions, dtype=float)
    motions = None if velocities is None else np.array(velocities, dtype=float)
    kinds = np.zeros(len(places), dtype=np.int64)
    return Column(places, kinds, float(places[:, 2].max()) + RADIUS, motions)


def scene_of(
    particles: Column,
    walls: Mapping[str, Wall],
    stages: Sequence[Stage],
    values: Mapping[str, float] = ELASTIC,
    **options: Any,
) -> Scene:
    """Return a small scene; options are fields of `Scene`."""
    given: dict[str, Any] = {
        "title": "Scene of a test",
        "sizes": SIZES,
        "box": BOX,
        "gravity": GRAVITY,
        "quiet_speed": 1e-5,
        "check_interval": 0.005,
        **options,
    }
    given.setdefault("time_step", time_step(given["sizes"], values, 0.02))
    return Scene(material=values, particles=particles, walls=walls, stages=tuple(stages), **given)


def frames(seconds: float, count: int = 1, series: Series | None = None) -> list[Stage]:
    """Return stages of equal length with a snapshot each: ``frame1``, ``frame2``, ..."""
    return [
        Stage(f"part{n}", Elapsed(seconds / count), snapshot=f"frame{n}", series=series)
        for n in range(1, count + 1)
    ]


def settle(series: Series | None = None) -> Stage:
    """Return a stage that ends at rest, with the snapshot ``rest``."""
    return Stage("settle", AtRest(2.0, at_least=0.02), snapshot="rest", series=series)


def resting_overlap(values: Mapping[str, float], load: float = WEIGHT, curve: float = 1.0) -> float:
    """Return the Hertz overlap of a particle on a wall under a load, m."""
    return hertz_overlap(load, particle_moduli(values, "wall"), curve * RADIUS)


def final_velocities(run: RunOutput, scene: Scene) -> NDArray[np.float64]:
    """Return the mean velocities between the last two snapshots, m/s, shape (n, 3)."""
    last, before = scene.stages[-1], scene.stages[-2]
    times = {stage.name: stage.time for stage in run.stages}
    moved = run.snapshot(last.snapshot).positions - run.snapshot(before.snapshot).positions
    return moved / (times[last.name] - times[before.name])


def means(run: RunOutput, stage: str) -> dict[str, float]:
    """Return the means of the columns of a series."""
    return {name: float(column.mean()) for name, column in run.series(stage).items()}


class SimulatedScenes:
    """Simulate scenes in a program that subclasses define.

    Attributes
    ----------
    wall_radius : float
        R* of a particle on a plane wall, over its radius.
    slide_kick : float
        Change of speed when a particle begins to slide, beyond that of friction, m/s.
    is_slow : bool
        Thousands of particles take minutes.
    """

    wall_radius: ClassVar[float] = 1.0
    slide_kick: ClassVar[float] = 0.0
    is_slow: ClassVar[bool] = False

    @pytest.fixture
    def solver(self) -> DeckSolver:
        """Return the program under test."""
        raise NotImplementedError

    @pytest.fixture
    def run(self, solver: DeckSolver, tmp_path: Path) -> Run:
        """Return a function that simulates a scene in a folder of its own."""

        def run(scene: Scene) -> RunOutput:
            lacking = scene.concepts() & set(solver.missing)
            if lacking:
                pytest.skip(f"{solver.name} has no {', '.join(sorted(lacking))}")
            folder = tmp_path / str(len(list(tmp_path.iterdir())))
            folder.mkdir()
            return solver.simulate(scene, Workspace(folder, TIMEOUT))

        return run

    def rests_at(self, values: Mapping[str, float]) -> float:
        """Return the height of the centre of a particle at rest on a wall at height 0, m."""
        return RADIUS - resting_overlap(values, curve=self.wall_radius)

    def rests_on_annulus(self, values: Mapping[str, float], distance: float) -> float:  # noqa: ARG002
        """Return the height of the centre of a particle at rest on a ring at height 0, m.

        Its distance from the axis, m, matters to a program that gives the ring a curvature.
        """
        return self.rests_at(values)

    def tube_floor(self, radius: float) -> tuple[float, float]:
        """Return how far below its axis the floor of a lying tube is, and its radius there, m."""
        return radius, radius
