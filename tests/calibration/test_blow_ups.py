"""Responses that are no physical answer: their runs count as failed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

import grainfit as gf
from grainfit.evaluation import Evaluation, Proposal
from grainfit.metamodels.blow_ups import without_blow_ups

PARAMETERS = [gf.Parameter("x", 0.0, 1.0), gf.Parameter("y", 0.0, 1.0)]
PROBLEM = gf.Problem(
    PARAMETERS,
    [
        gf.Target("angle", 30.0, uncertainty=0.5),
        gf.Target("density", 1550.0, uncertainty=10.0),
    ],
)


def evaluation(problem: gf.Problem, responses: Mapping[str, float], seed: int) -> Evaluation:
    values = {parameter.name: 0.5 for parameter in problem.parameters}
    return Evaluation.of(Proposal(values, seed, "design"), responses)


@pytest.mark.parametrize("blown", [1e5, -1e7, 1e120, 1e308])
def test_blow_ups_in_a_part_of_the_intervals_do_not_hide_the_answer(blown: float) -> None:
    def heap(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        random = np.random.default_rng(seed)
        angle = 20 + 20 * parameters["x"] + 5 * parameters["y"] + 0.3 * random.normal()
        density = 1500 + 100 * parameters["y"] + 5 * random.normal()
        return {"angle": angle if parameters["x"] < 0.7 else blown, "density": density}

    result = gf.calibrate(PROBLEM, gf.solvers.PythonCallable(heap))

    assert result.status == "calibrated"
    assert result.parameters["x"] == pytest.approx(0.375, abs=0.1)
    assert any("no physical answer" in words for words in result.notices)


def test_blow_up_takes_all_responses_of_its_test_with_it() -> None:
    scopes = [
        gf.TestScope("heap", ["heap.angle", "heap.density"], ["x"]),
        gf.TestScope("drum", ["drum.angle"], ["y"]),
    ]
    targets = [gf.Target(n, 30.0) for n in ("heap.angle", "heap.density", "drum.angle")]
    problem = gf.Problem(PARAMETERS, targets, tests=scopes)
    usual = {"heap.angle": 20.0, "heap.density": 25.0, "drum.angle": 40.0}
    runs = [evaluation(problem, usual, seed) for seed in range(4)]
    blown = evaluation(problem, {**usual, "heap.angle": 1e9}, 9)
    *others, found = without_blow_ups(problem, [*runs, blown])

    assert others == runs
    assert set(found.responses) == {"drum.angle"}
    assert found.failed_in("heap")
    assert not found.failed_in("drum")


def test_responses_of_several_orders_of_magnitude_are_no_blow_ups() -> None:
    problem = gf.Problem(PARAMETERS, [gf.Target("modulus", 1e6)])
    runs = [
        evaluation(problem, {"modulus": value}, seed)
        for seed, value in enumerate([1e5, 1e6, 1e7, 3e7, 1e8, 3e8])
    ]

    assert without_blow_ups(problem, runs) == runs


def test_small_tolerance_about_zero_makes_no_blow_up() -> None:
    problem = gf.Problem(PARAMETERS, [gf.Target("dilatancy", 0.0, tolerance=1e-6)])
    runs = [
        evaluation(problem, {"dilatancy": value}, seed)
        for seed, value in enumerate([-0.5, -0.2, 0.1, 0.4])
    ]

    assert without_blow_ups(problem, runs) == runs


def test_most_runs_may_blow_up_beyond_all_numbers() -> None:
    good, blown = ({"angle": angle, "density": 1550.0} for angle in (20.0, 1e300))
    runs = [evaluation(PROBLEM, good if n == 0 else blown, n) for n in range(8)]

    found = without_blow_ups(PROBLEM, runs)

    assert [one.responses != {} for one in found] == [True] + 7 * [False]
