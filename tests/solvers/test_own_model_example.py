"""The example of a user's own model measures what it says, by closed forms."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model.command import Command

MODEL = Path(__file__).parents[2] / "examples" / "own_model" / "model"
DIAMETER, DENSITY, DROP, POISSON = 0.010, 2500.0, 0.200, 0.22


@pytest.fixture
def solver():
    return Command(
        MODEL,
        ["lmp", "-in", "in.drop", "-nocite"],
        evaluate="evaluate.py:measure",
        response_names=("rebound_height", "contact_time"),
        parameters={
            "bead_diameter": DIAMETER,
            "drop_height": DROP,
            "particle.density": DENSITY,
            "particle.poissons_ratio": POISSON,
        },
    )


def throw(solver, folder, seed=3, restitution=0.9, youngs_modulus=1e7):
    folder.mkdir()
    values = {
        "particle_wall.restitution": restitution,
        "particle.youngs_modulus": youngs_modulus,
    }
    responses = solver.run(values, seed, Workspace(folder, timeout=60.0))
    return {name: response.value for name, response in responses.items()}


def test_rebound_height_and_contact_time_follow_the_closed_forms(solver, tmp_path):
    solver.check()
    bounce = throw(solver, tmp_path / "run", restitution=0.95, youngs_modulus=1e7)

    # The height of fall scatters by 2 % at most; the rest is the time step.
    assert bounce["rebound_height"] == pytest.approx(0.95**2 * DROP, rel=0.03)
    # Hertz: duration of an elastic impact of a sphere on a plane of the same material
    # (K. L. Johnson, Contact Mechanics, 1985, equation 11.24).
    mass = DENSITY * math.pi / 6 * DIAMETER**3
    modulus = 1e7 / (2 * (1 - POISSON**2))
    speed = math.sqrt(2 * 9.81 * DROP)
    hertz = 2.87 * (mass**2 / (DIAMETER / 2 * modulus**2 * speed)) ** 0.2
    assert bounce["contact_time"] == pytest.approx(hertz, rel=0.03)


def test_seed_is_another_throw_of_the_same_bead(solver, tmp_path):
    heights = [
        throw(solver, tmp_path / str(number), seed)["rebound_height"]
        for number, seed in enumerate((1, 1, 900_000_000))
    ]

    assert heights[0] == heights[1] != heights[2]
    assert heights[2] == pytest.approx(heights[0], rel=0.05)
