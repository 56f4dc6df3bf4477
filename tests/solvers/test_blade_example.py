"""The example of a scene of the user: a pile that is pushed by a blade, small, in real solvers."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import pytest

from grainfit.bulk_tests.own_scene import OwnScene
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS

BLADE = Path(__file__).parents[2] / "examples" / "blade"
#: Soft and fast: two thousand steps instead of twenty thousand.
SOFT = {"particle.youngs_modulus": 2e5}
FAST = 0.3


def push(solver: str, folder: Path, friction: float) -> float:
    """Return the force on the blade, N/m."""
    if solver != "lammps" and shutil.which(solver) is None:
        pytest.skip(f"{solver} is not installed")
    file = load_calibration(BLADE / "calibration.toml").file
    test = OwnScene(
        file.sizes,
        scene=f"{BLADE}/blade.py:scene",
        measure=f"{BLADE}/blade.py:measure",
        options={"blade_speed": FAST},
    )
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


def test_the_file_is_ready_to_run() -> None:
    plan = describe_plan(load_calibration(BLADE / "calibration.toml"))

    assert plan.problems == ()
