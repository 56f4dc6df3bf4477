"""Time steps of tests made in Python: safe for the material, unless they are given."""

from __future__ import annotations

import pytest

from grainfit import Parameter, Problem, Target
from grainfit.bulk_tests.packing import Packing
from grainfit.bulk_tests.time_steps import usual_time_step_fraction
from grainfit.calibration.scopes import restricted, restricted_to_used
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.parameters_for import ParametersFor
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES

BOUNCE = "particle_particle.restitution"
USUAL = 0.12


def packing_of(restitution: float | None, models: tuple[str, ...] = (), **options: float) -> Solver:
    material = {**ROUGH_SPHERES}
    material.pop(BOUNCE)
    if restitution is not None:
        material[BOUNCE] = restitution
    test = Packing(diameter="10 mm", **options)
    solver: DeckSolver = DEM_PROGRAMS["lammps"](test, material, contact_models=models)
    return solver


def step_of(solver: Solver) -> float:
    assert solver.bulk_test is not None
    share: float = solver.bulk_test.setup.time_step_fraction
    return share


def problem(low: float, high: float) -> Problem:
    return Problem([Parameter(BOUNCE, low, high)], [Target("bulk_density", 1300.0)])


@pytest.mark.parametrize("restitution", [0.1, 0.2, 0.3])
def test_default_is_short_enough_for_the_material(restitution: float) -> None:
    solver = packing_of(restitution)
    ends = {name: (value, value) for name, value in {**ROUGH_SPHERES, BOUNCE: restitution}.items()}
    assert step_of(solver) == min(USUAL, usual_time_step_fraction(Packing(diameter="10 mm"), ends))
    assert solver.model()["test"]["time_step_fraction"] == step_of(solver)


def test_low_restitutions_have_shorter_steps_and_usual_ones_the_usual_one() -> None:
    assert step_of(packing_of(0.1)) < step_of(packing_of(0.2)) < USUAL
    assert step_of(packing_of(0.6)) == step_of(packing_of(None)) == USUAL


def test_a_step_that_is_given_stays() -> None:
    given = packing_of(0.1, time_step_fraction=USUAL)
    assert step_of(given) == step_of(given.within({BOUNCE: (0.1, 0.5)})) == USUAL


def test_the_lowest_restitution_of_an_interval_decides() -> None:
    free = packing_of(None)
    lowest = step_of(packing_of(0.2))
    for solver in (free, ParametersFor(free), ParametersFor(free, {BOUNCE: 0.2})):
        intervals = {} if solver.depends_on(()) else {BOUNCE: (0.2, 0.9), "humidity": (0.0, 1.0)}
        assert step_of(solver.within(intervals)) == lowest
    assert step_of(restricted(problem(0.2, 0.9), {"packing": free})["packing"]) == lowest
    assert step_of(restricted_to_used(problem(0.2, 0.9), free)[1]) == lowest
    assert step_of(free.within({BOUNCE: (0.7, 0.9)})) == USUAL


def test_linear_springs_need_no_step_of_the_user() -> None:
    assert step_of(packing_of(0.6, ("linear",))) < USUAL
    assert packing_of(0.6, ("linear",)).interval_faults({}) == []


def share_of(family: str, ratios: tuple[float, float], restitution: float) -> float:
    test = Packing(ParticleSizes((0.01,), shape=ParticleShape(family)))
    material = {**ROUGH_SPHERES, BOUNCE: restitution, "particle_wall.restitution": restitution}
    ends = {name: (value, value) for name, value in material.items()}
    return usual_time_step_fraction(test, {**ends, "particle.aspect_ratio": ratios})


def test_clumps_whose_spheres_touch_several_at_once_have_a_shorter_step() -> None:
    # Measured: with 0.12 beds of these grains are 3.5 % too dense, with 0.06 they are not.
    assert 0.03 <= share_of("grain", (1.2, 1.2), 0.3) <= 0.06
    assert share_of("two_spheres", (1.5, 1.5), 0.3) == share_of("lens", (1.5, 1.5), 0.3) == USUAL
    assert share_of("grain", (1.5, 1.5), 0.8) == USUAL


def test_the_aspect_ratio_that_needs_the_shortest_step_decides() -> None:
    nearest = share_of("grain", (1.1, 1.1), 0.5)
    assert share_of("grain", (1.1, 1.8), 0.5) == nearest < share_of("grain", (1.8, 1.8), 0.5)
    assert share_of("grain", (1.0, 1.8), 0.5) < nearest
    assert share_of("grain", (1.0, 1.0), 0.5) == USUAL
