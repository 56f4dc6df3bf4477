"""Probability that a run succeeds, near failed and finished runs."""

from dataclasses import replace

import numpy as np
import pytest

from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.problem import Parameter, Problem, Relative, Target
from grainfit.strategies.feasibility import FeasibilityModel

PROBLEM = Problem(
    [Parameter("x", 10.0, 20.0), Parameter("y", 1.0, 100.0, "log")], [Target("angle", 30.0)]
)
MIDDLE = np.array([[0.5, 0.5]])


def run(x: float, y: float, outcome: str = "success") -> Evaluation:
    """A run at a point of the unit square."""
    proposal = Proposal(PROBLEM.from_unit([x, y]), 1, "design")
    if outcome == "success":
        return Evaluation(proposal, {"angle": Response(30.0)})
    by_machine = outcome == "machine"
    return Evaluation(proposal, {}, {"heap": "it failed"}, failed_by_machine=by_machine)


def probability(evaluations: list[Evaluation], points: np.ndarray = MIDDLE) -> np.ndarray:
    return FeasibilityModel(PROBLEM, evaluations).success_probability(points)


@pytest.mark.parametrize("evaluations", [[], [run(0.5, 0.5), run(0.1, 0.2)]])
def test_without_failures_everything_succeeds(evaluations: list[Evaluation]) -> None:
    points = np.random.default_rng(1).random((5, 2))
    assert probability(evaluations, points).tolist() == [1.0] * 5


def test_one_failure_halves_the_probability_at_its_place() -> None:
    assert probability([run(0.5, 0.5, "failure")]) == pytest.approx(0.5)


def test_each_further_failure_lowers_it_and_each_success_raises_it() -> None:
    once = [run(0.5, 0.5, "failure")]
    assert probability(once * 2) == pytest.approx(1 / 3)
    assert probability(once * 3) == pytest.approx(1 / 4)
    assert probability([*once, run(0.5, 0.5)]) == pytest.approx(2 / 3)


def test_a_failure_tells_of_its_neighbourhood_only() -> None:
    line = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11)])
    found = probability([run(0.0, 0.0, "failure")], line)
    assert (np.diff(found) > 0).all()
    assert found[-1] > 0.99


def test_a_log_scale_is_respected() -> None:
    # 10 is the middle of 1 to 100 there.
    found = FeasibilityModel(PROBLEM, [run(0.5, 0.5, "failure")])
    at = PROBLEM.to_unit({"x": 15.0, "y": 10.0})
    assert found.success_probability(at[None]) == pytest.approx(0.5)


def test_failures_by_the_machine_say_nothing() -> None:
    assert probability([run(0.5, 0.5, "machine")] * 5) == [1.0]
    failure = run(0.4, 0.5, "failure")
    assert probability([failure, run(0.5, 0.5, "machine")]) == probability([failure])


def test_what_is_known_of_a_relative_is_believed_until_runs_of_the_test_say_otherwise() -> None:
    problem = replace(PROBLEM, relatives=[Relative("", None)])
    name = problem.relatives[0].name

    def told(x: float, fails: bool) -> Evaluation:
        proposal = Proposal(PROBLEM.from_unit([x, 0.5]), 1, "design", (name,))
        return Evaluation(proposal, {}, {name: "it fails"} if fails else {})

    known = [told(x, fails=x < 0.5) for x in np.linspace(0.0, 1.0, 21)]
    points = np.array([[0.1, 0.5], [0.9, 0.5]])

    def probabilities(*own: Evaluation) -> np.ndarray:
        return FeasibilityModel(problem, [*known, *own]).success_probability(points)

    fails, succeeds = probabilities()
    # It may be wrong, so that a run there is not impossible.
    assert 0.2 < fails < 0.4
    assert succeeds > 0.95
    found = FeasibilityModel(problem, known)
    assert found.is_likely(points).tolist() == [False, True]
    assert probabilities(run(0.1, 0.5))[0] > 0.6
    assert probabilities(run(0.9, 0.5, "failure"))[1] == pytest.approx(0.5, abs=0.03)
    # Once it is dropped, the runs of the test count alone.
    alone = FeasibilityModel(PROBLEM, known).success_probability(points)
    assert alone.tolist() == [1.0, 1.0]


def test_a_success_that_is_nearer_than_any_failure_makes_an_answer_likely() -> None:
    runs = [run(x, 0.5, "failure") for x in (0.5, 0.51, 0.52, 0.53)] + [run(0.46, 0.5)]
    points = np.array([[0.47, 0.5], [0.49, 0.5]])
    found = FeasibilityModel(PROBLEM, runs)
    assert (found.success_probability(points) < 0.5).all()
    assert found.is_likely(points).tolist() == [True, False]
    # At the very place of both, the share of the successes counts.
    at = FeasibilityModel(PROBLEM, [run(0.5, 0.5), *[run(0.5, 0.5, "failure")] * 3])
    assert not at.is_likely(MIDDLE)[0]
