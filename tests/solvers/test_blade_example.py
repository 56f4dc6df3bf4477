"""The example of a scene of the user: a pile that is pushed by a blade, small, in real solvers."""

from __future__ import annotations

import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grainfit.bulk_tests.own_scene import OwnScene
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS

BLADE = Path(__file__).parents[2] / "examples" / "blade"
#: Soft and fast: two thousand steps instead of twenty thousand.
SOFT = {"particle.youngs_modulus": 2e5}
FAST = 0.3


def blade(sizes: ParticleSizes) -> OwnScene:
    return OwnScene(
        sizes,
        scene=f"{BLADE}/blade.py:scene",
        measure=f"{BLADE}/blade.py:measure",
        options={"blade_speed": FAST},
    )


def push(
    solver: str,
    folder: Path,
    friction: float,
    factor: float = 1.0,
    shape: ParticleShape | None = None,
) -> float:
    """Return the force on the blade, N/m."""
    if solver != "lammps" and shutil.which(solver) is None:
        pytest.skip(f"{solver} is not installed")
    file = load_calibration(BLADE / "calibration.toml").file
    assert file.sizes is not None
    test = blade(replace(file.sizes.coarse_grained(factor), shape=shape))
    material = {**file.fixed, **SOFT, "particle_particle.sliding_friction": 0.5}
    folder.mkdir()
    program = DEM_PROGRAMS[solver](test, material)
    values = {"particle_wall.sliding_friction": friction}
    return program.run(values, 1, Workspace(folder, timeout=120.0))["push_force"].value


@pytest.mark.parametrize("solver", ["lammps", "liggghts"])
def test_the_blade_feels_the_friction_of_the_pile_on_the_floor(solver: str, tmp_path: Path) -> None:
    # 310 beads of 10 mm in a slice of 50 mm.
    weight = 310 * 2500 * math.pi / 6 * 0.01**3 * 9.81 / 0.05

    force = push(solver, tmp_path / "run", 0.3)

    # The pile slides up the blade, which carries a part of its weight.
    assert 0.75 * 0.3 * weight < force < 1.05 * 0.3 * weight


@pytest.mark.parametrize("solver", ["lammps", "liggghts"])
def test_clumps_of_a_periodic_scene_reach_through_its_sides(solver: str, tmp_path: Path) -> None:
    """Their centres are within the box, and spheres of some are not."""
    pairs = ParticleShape("two_spheres", aspect_ratio=1.5)
    scene = blade(ParticleSizes((0.01,), shape=pairs)).scene(GLASS_BEADS, 1)
    assert scene.clumps is not None
    spheres = scene.particles.outlines(scene.clumps)[0]
    depth = scene.box.high[1]
    assert ((spheres[:, 1] < 0) | (spheres[:, 1] > depth)).sum() > 5

    weight = 310 * 2500 * math.pi / 6 * 0.01**3 * 9.81 / 0.05
    force = push(solver, tmp_path / "run", 0.3, shape=pairs)
    assert 0.6 * 0.3 * weight < force < 1.1 * 0.3 * weight


def test_enlarged_particles_are_pushed_by_the_same_blade(tmp_path: Path) -> None:
    real = ParticleSizes((0.01,))
    scenes = [blade(real.coarse_grained(factor)).scene(GLASS_BEADS, 1) for factor in (1, 2)]

    # Only the top follows the column of particles, and the free space below the floor is larger.
    boxes = [np.array([scene.box.low, scene.box.high]) for scene in scenes]
    assert boxes[0][:, 1] == pytest.approx(boxes[1][:, 1])
    for name in ("blade", "gate"):
        one, two = (scene.walls[name].shape for scene in scenes)
        assert one.low[1:] == pytest.approx(two.low[1:])
    assert scenes[0].walls["gate"].shape.low == scenes[1].walls["gate"].shape.low
    masses = [len(s.particles.positions) * max(s.sizes.diameters) ** 3 for s in scenes]
    assert masses[0] == pytest.approx(masses[1], rel=0.02)

    weight = 310 * 2500 * math.pi / 6 * 0.01**3 * 9.81 / 0.05
    assert 0.6 * 0.3 * weight < push("lammps", tmp_path / "run", 0.3, 2.0) < 1.05 * 0.3 * weight


def test_the_file_is_ready_to_run() -> None:
    plan = describe_plan(load_calibration(BLADE / "calibration.toml"))

    assert plan.problems == ()
