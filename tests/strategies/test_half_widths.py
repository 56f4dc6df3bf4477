"""A wanted half-width: the search goes on until all 95 % intervals have it, or cannot have it."""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.analysis.analysis import analyse_parameters
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Parameter, Problem, Target, TestScope
from grainfit.strategies import messages
from grainfit.strategies.base import Search
from grainfit.strategies.feasibility import FeasibilityModel
from grainfit.strategies.sequential.parameter_knowledge import ParameterKnowledge
from grainfit.strategies.sequential.strategy import Sequential
from grainfit.testing.strategy_contract import converse, failed, heap_problem, nearly_quiet

TRUTH = {"x": 0.4, "y": 0.6}
#: Scatter of both responses from seed to seed.
SCATTER = {"sum": 0.3, "difference": 0.8}


def responses(parameters: Mapping[str, float]) -> dict[str, float]:
    """A ridge: the sum is told well, the difference hardly."""
    x, y = parameters["x"], parameters["y"]
    return {"sum": 100.0 + 20.0 * (x + y), "difference": 50.0 + 4.0 * (x - y) + (x - 0.4) ** 2}


def ridge(uncertainty: float = 0.3) -> Problem:
    true = responses(TRUTH)
    return Problem(
        [Parameter("x", 0.0, 1.0), Parameter("y", 0.0, 1.0)],
        [
            Target("sum", true["sum"], tolerance=1.0, uncertainty=0.3),
            Target("difference", true["difference"], tolerance=1.0, uncertainty=uncertainty),
        ],
    )


def simulate(proposal: Proposal, noise: float = 1.0) -> Evaluation:
    random = np.random.default_rng(proposal.seed)
    found = {
        name: Response(value + noise * SCATTER[name] * random.standard_normal())
        for name, value in responses(proposal.parameters).items()
    }
    return Evaluation(proposal, found)


def model(parameters: dict[str, float], seed: int) -> dict[str, float]:
    found = simulate(Proposal(parameters, seed, "design")).responses
    return {name: response.value for name, response in found.items()}


@cache
def calibrated(
    wanted: str | None = None, seed: int = 1, noise: float = 1.0, uncertainty: float = 0.3
) -> tuple[Search, list[Evaluation]]:
    """A finished search for a half-width, which several tests look at."""
    search = Sequential(wanted_half_width=wanted).start(ridge(uncertainty), seed)
    return search, converse(search, lambda proposal: simulate(proposal, noise))


def intervals(
    problem: Problem, evaluations: list[Evaluation], search: Search
) -> dict[str, tuple[float, float]]:
    """The 95 % intervals that the report shows."""
    answer = search.answer().parameters
    found = analyse_parameters(problem, evaluations, answer=answer).intervals
    return {name: (one.low, one.high) for name, one in found.items()}


def half_widths(found: Mapping[str, tuple[float, float]], search: Search) -> dict[str, float]:
    answer = search.answer().parameters
    return {name: (high - low) / 2 / answer[name] for name, (low, high) in found.items()}


# What it reaches -----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [1, 2, pytest.param(3, marks=pytest.mark.thorough)])
def test_a_wanted_half_width_is_reached_and_the_interval_holds_the_truth(seed: int) -> None:
    problem = ridge()
    usual, few = calibrated(None, seed)
    search, runs = calibrated("28 %", seed)
    before = half_widths(intervals(problem, few, usual), usual)
    found = intervals(problem, runs, search)
    after = half_widths(found, search)

    assert max(before.values()) > 0.33
    # The estimate of the search and that of the report are samples of the same distribution.
    assert max(after.values()) < 0.28 * 1.1
    assert len(few) < len(runs) < 45
    for name, (low, high) in found.items():
        assert low < TRUTH[name] < high
    [notice] = search.notices
    assert messages.HALF_WIDTHS_REACHED.is_in(notice, wanted="±28 %")
    assert usual.notices == ()


def test_it_begins_as_the_search_without_the_option() -> None:
    _, few = calibrated()
    _, runs = calibrated("28 %")

    assert runs[: len(few)] == few


def test_where_the_measurements_limit_the_intervals_it_stops_and_says_so() -> None:
    _, few = calibrated(noise=0.2, uncertainty=1.0)
    search, runs = calibrated("20 %", noise=0.2, uncertainty=1.0)

    assert len(runs) <= len(few) + 2
    [notice] = search.notices
    assert messages.HALF_WIDTHS_MISSED.is_in(notice, wanted="±20 %")
    assert messages.MEASUREMENTS_LIMIT() in notice
    assert messages.MORE_MEASUREMENTS_NARROW.is_in(notice)
    assert "for x" in notice
    assert "another test" in notice


def test_where_the_budget_ends_it_the_notice_says_what_more_runs_would_bring() -> None:
    search = Sequential(wanted_half_width="25 %").start(ridge(), 1, 12)
    runs = converse(search, simulate)

    assert len(runs) == 12
    [notice] = search.notices
    assert messages.MORE_RUNS_NARROW.is_in(notice)
    assert "larger budget" in notice


def test_a_half_width_that_is_reached_already_costs_no_run() -> None:
    _, few = calibrated(noise=0.2)
    _, runs = calibrated("100 %", noise=0.2)

    assert runs == few


@pytest.mark.parametrize("seed", [1, 2])
def test_the_half_widths_that_are_stated_are_those_of_the_report(seed: int) -> None:
    search, runs = calibrated("30 %", seed)
    reported = half_widths(intervals(ridge(), runs, search), search)

    stated = {n: float(w) / 100 for w, n in re.findall(r"±(\S+) % for (\w+)", search.notices[0])}
    assert stated == pytest.approx(reported, rel=0.12)


def test_half_widths_reach_bounds_as_the_intervals_do() -> None:
    """Nearly all of a narrow interval agrees, so the 95 % interval is all of it."""
    narrow = Parameter("x", 0.95 * TRUTH["x"], 1.05 * TRUTH["x"])
    problem = replace(ridge(), parameters=[narrow, Parameter("y", 0.0, 1.0)])
    random = np.random.default_rng(1)
    points = [problem.from_unit(point) for point in random.random((14, 2))]
    runs = [simulate(Proposal(point, seed, "design")) for seed, point in enumerate(points)]
    answer = problem.to_unit(TRUTH)
    knowledge = ParameterKnowledge(
        Metamodels.fit(problem, runs), FeasibilityModel(problem, runs), answer, 0.3, (1,)
    )

    found = analyse_parameters(problem, runs, answer=TRUTH).intervals["x"]

    assert (found.low, found.high) == problem.intervals["x"]
    assert knowledge.half_widths["x"] == pytest.approx(0.05)


def test_the_result_of_a_calibration_says_what_was_reached() -> None:
    result = gf.calibrate(ridge(), model, strategy=Sequential(wanted_half_width="30 %"), seed=1)

    assert result.status == "calibrated"
    assert sum("wanted ±30 %" in notice for notice in result.notices) == 1


def test_a_finished_calibration_goes_on_with_all_its_runs(tmp_path: Path) -> None:
    first = gf.calibrate(ridge(), model, workdir=tmp_path, seed=1)
    wanted = Sequential(wanted_half_width="28 %")
    second = gf.calibrate(ridge(), model, workdir=tmp_path, strategy=wanted, seed=1)

    assert second.runs.warm_start_runs == first.runs.total
    assert any(messages.HALF_WIDTHS_REACHED.is_in(notice) for notice in second.notices)
    assert second.status == "calibrated"


@pytest.mark.thorough
def test_an_interrupted_calibration_continues_as_it_would_have(tmp_path: Path) -> None:
    wanted = Sequential(wanted_half_width="28 %")
    whole = gf.calibrate(ridge(), model, strategy=wanted, seed=2, workers=1)
    made = 0

    def interrupted(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        if made == whole.runs.total - 6:
            raise KeyboardInterrupt
        return model(parameters, seed)

    options = {"strategy": wanted, "seed": 2, "workers": 1, "workdir": tmp_path}
    assert gf.calibrate(ridge(), interrupted, **options).status == "interrupted"
    again = gf.calibrate(ridge(), model, **options)

    assert [(r.parameters, r.seed) for r in again.history] == [
        (r.parameters, r.seed) for r in whole.history
    ]
    assert again.notices == whole.notices


def test_a_bound_in_the_way_is_moved_before_the_intervals_are_narrowed() -> None:
    density = Parameter("density", 1407.0, 2205.0)
    problem = replace(heap_problem(), parameters=[density, heap_problem().parameters[1]])
    search = Sequential(extend_intervals=True, wanted_half_width="20 %").start(problem, 1)
    runs = converse(search, nearly_quiet)

    assert search.current_problem.intervals["density"][1] > 2326.0
    assert any(messages.BOUND_MOVED.is_in(notice) for notice in search.notices)
    assert messages.HALF_WIDTHS_REACHED.is_in(search.notices[-1])
    assert all(evaluation.proposal.parameters["density"] > 1400.0 for evaluation in runs)


def test_runs_that_would_fail_are_not_made_to_narrow_an_interval() -> None:
    def without_a_corner(proposal: Proposal) -> Evaluation:
        if proposal.parameters["x"] > 0.55:
            return failed(proposal)
        return simulate(proposal)

    search = Sequential(wanted_half_width="28 %").start(ridge(), 1)
    runs = converse(search, without_a_corner)[search.design_runs :]

    assert len(runs) >= 8
    assert sum(bool(evaluation.failures) for evaluation in runs) <= 0.4 * len(runs)


# Where it goes -------------------------------------------------------------------------------


def test_of_two_tests_it_runs_the_one_whose_metamodel_limits_the_intervals() -> None:
    problem = replace(
        ridge(),
        tests=[
            TestScope("heap", ["sum"], ["x", "y"], seconds=10.0),
            TestScope("shear", ["difference"], ["x", "y"], seconds=10.0),
        ],
    )

    def of_its_tests(proposal: Proposal) -> Evaluation:
        whole = simulate(proposal)
        asked = {"sum": proposal.asks_for("heap"), "difference": proposal.asks_for("shear")}
        return replace(whole, responses={n: r for n, r in whole.responses.items() if asked[n]})

    few = converse(Sequential().start(problem, 1), of_its_tests)
    search = Sequential(wanted_half_width="25 %").start(problem, 1)
    added = converse(search, of_its_tests)[len(few) :]
    in_shear = [e for e in added if e.proposal.asks_for("shear")]

    # The sum is known ten times as well as is needed, whatever its metamodel.
    assert len(added) >= 5
    assert len(in_shear) >= 0.9 * len(added)
    assert messages.HALF_WIDTHS_REACHED.is_in(search.notices[0])


def test_no_more_runs_are_started_than_are_needed_at_most() -> None:
    _, alone = calibrated("28 %")
    search = Sequential(wanted_half_width="28 %").start(ridge(), 1, 80)
    for evaluation in alone[:-3]:
        assert search.ask() == evaluation.proposal
        search.tell(evaluation.proposal, evaluation)
    pending = []
    while (proposal := search.ask()) is not None:
        pending.append(proposal)

    assert 1 <= len(pending) <= 15
    assert len({tuple(proposal.parameters.values()) for proposal in pending}) > len(pending) / 2


def test_several_runs_at_a_time_come_to_the_same_end() -> None:
    _, alone = calibrated("28 %")
    search = Sequential(wanted_half_width="28 %").start(ridge(), 1)
    runs = converse(search, simulate, workers=3)

    assert len(runs) <= len(alone) + 8
    assert len({e.proposal.seed for e in runs}) == len(runs)
    assert messages.HALF_WIDTHS_REACHED.is_in(search.notices[0])


def test_the_runs_that_are_left_are_estimated() -> None:
    search = Sequential(wanted_half_width="28 %").start(ridge(), 1)
    usual = Sequential().start(ridge(), 1)
    assert search.expected_left > usual.expected_left
    left = []
    while not search.finished:
        proposal = search.ask()
        assert proposal is not None
        search.tell(proposal, simulate(proposal))
        left.append(search.expected_left)
    truly = np.arange(len(left))[::-1]
    behind_design = np.array(left[search.design_runs :])
    # Half of them within a factor of three, give or take three runs.
    true = truly[search.design_runs :]
    near = (behind_design <= 3 * true + 3) & (behind_design >= true / 3 - 3)
    assert near.mean() >= 0.5


# Options and identity ------------------------------------------------------------------------


def test_without_the_option_a_calibration_keeps_its_identity() -> None:
    plain = Sequential().start(heap_problem(), 1).definition
    wanted = Sequential(wanted_half_width="25 %").start(heap_problem(), 1).definition

    assert json.dumps(plain, sort_keys=True) == (
        '{"confidence": 0.95, "design_runs": 5, "extend_intervals": false, "prefer": "time_step"}'
    )
    assert wanted == plain | {"wanted_half_width": 0.25}


@pytest.mark.parametrize("value", ["0 %", "-5 %", 3, "300 %", "wide", True, float("nan")])
def test_what_is_no_share_is_refused_with_advice(value: object) -> None:
    with pytest.raises(InputError) as caught:
        Sequential(wanted_half_width=value)  # type: ignore[arg-type]
    [fault] = caught.value.faults
    assert fault.key == "wanted_half_width"
    assert fault.remedy
    if value in ("0 %", "-5 %", 3):
        assert 'such as "25 %"' in fault.remedy


def test_a_share_is_a_percentage_or_a_number() -> None:
    assert Sequential(wanted_half_width="25 %") == Sequential(wanted_half_width=0.25)
