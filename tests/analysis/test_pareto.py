"""Pareto fronts against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from given_metamodels import Given

from grainfit.analysis.pareto import pareto_front
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Parameter, Problem, Target

MODULUS = Parameter("particle.youngs_modulus", 1e6, 1e8, "log")
FRICTION = Parameter("particle_particle.sliding_friction", 0.0, 1.0)
RAYLEIGH = RayleighTimeStep(
    0.005,
    {
        "particle.youngs_modulus": 1e6,
        "particle.density": 2500.0,
        "particle.poissons_ratio": 0.25,
    },
)
PROBLEM = Problem([MODULUS, FRICTION], [Target("angle", 38.0, tolerance=2.0)], RAYLEIGH)


def angle(x: np.ndarray) -> np.ndarray:
    return 30.0 + 10.0 * x[:, 0] + 5.0 * x[:, 1]


def test_the_front_is_the_known_trade_off() -> None:
    """With friction at its maximum, the target is met from 0.3 of the modulus' decades on.

    Below, the deviation grows by 5 tolerances per interval; the time step by 10 per interval.
    """
    front = pareto_front(Metamodels(PROBLEM, [Given(angle, 0.04)]))
    assert front is not None
    largest = RAYLEIGH.limits(PROBLEM.intervals)[1]
    place = np.log10(largest / front.time_steps)
    assert (np.diff(front.time_steps) > 0).all()
    assert (np.diff(front.misfits) > 0).all()
    assert front.time_steps[-1] == pytest.approx(largest, rel=1e-6)
    assert place[0] == pytest.approx(0.3, abs=0.05)
    wanted = (5.0 * np.maximum(0.3 - place, 0.0)) ** 2 + 0.01
    np.testing.assert_allclose(front.misfits, wanted, rtol=2e-3, atol=2e-4)
    assert len(place) >= 5
    for share, parameters in zip(place, front.parameters, strict=True):
        assert parameters[MODULUS.name] == pytest.approx(1e6 * 100**share, rel=1e-6)
        if share < 0.29:
            assert parameters[FRICTION.name] == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(
        front.responses[:, 0], np.minimum(35.0 + 10.0 * place, 38.0), atol=0.1
    )
    assert front.probability_all_met[0] == pytest.approx(1.0, abs=1e-3)
    assert front.probability_all_met[-1] < 1e-3


def test_where_the_time_step_costs_nothing_the_front_is_one_point() -> None:
    problem = replace(PROBLEM, targets=[Target("angle", 32.0, tolerance=1.0)])
    front = pareto_front(Metamodels(problem, [Given(lambda x: 30.0 + 5.0 * x[:, 1])]))
    assert front is not None
    assert front.time_steps == pytest.approx([RAYLEIGH.limits(problem.intervals)[1]], rel=1e-6)
    assert front.parameters[0] == pytest.approx({MODULUS.name: 1e6, FRICTION.name: 0.4}, rel=0.01)


def test_without_a_time_step_to_trade_there_is_no_front() -> None:
    model = Given(lambda x: 30.0 + x[:, 0])
    assert pareto_front(Metamodels(replace(PROBLEM, rayleigh=None), [model])) is None
    assert pareto_front(Metamodels(replace(PROBLEM, parameters=[FRICTION]), [model])) is None


def test_the_longest_time_step_may_be_between_the_bounds_of_an_aspect_ratio() -> None:
    fixed = {**RAYLEIGH.fixed, "particle.youngs_modulus": 1e6}
    rayleigh = RayleighTimeStep(0.005, fixed, "grain")
    ratio = Parameter("particle.aspect_ratio", 1.0, 2.0)
    problem = Problem([ratio, FRICTION], [Target("angle", 42.0, tolerance=0.5)], rayleigh)

    front = pareto_front(Metamodels(problem, [Given(angle, 0.04)]))

    assert front is not None
    # Below, spheres of a grain nearly coincide; above, its ends are thin.
    assert front.parameters[-1][ratio.name] == pytest.approx(1.34, abs=0.03)
    assert front.time_steps[-1] == pytest.approx(rayleigh.limits(problem.intervals)[1], rel=1e-3)
    assert front.parameters[0][ratio.name] == pytest.approx(1.7, abs=0.15)
