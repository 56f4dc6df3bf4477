"""Calibrations with cheaper relatives: they guide the search, and no verdict rests on them."""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration import messages
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Relative
from grainfit.problem import messages as of_problem
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies import messages as of_strategies
from grainfit.strategies.feasibility import FeasibilityModel
from grainfit.strategies.staged.strategy import Staged
from grainfit.work_folder.saved_calibration import SavedCalibration

Model = Callable[[Mapping[str, float], int], dict[str, float]]
COST = 0.25


def angle(sliding: float, rolling: float) -> float:
    return 15 + 18 * math.tanh(1.6 * sliding) * (0.5 + rolling)


def density(sliding: float, rolling: float) -> float:
    return 1500 - 150 * sliding**1.5 - 60 * rolling


def stiff(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
    scatter = np.random.default_rng(seed).standard_normal(2)
    at = parameters["sliding"], parameters["rolling"]
    return {"angle": angle(*at) + 0.4 * scatter[0], "density": density(*at) + 3.0 * scatter[1]}


def soft(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
    found = stiff(parameters, seed + 7)
    return {"angle": 0.95 * found["angle"] + 0.4, "density": 1.12 * found["density"]}


def turned(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
    """Return what the stiff particles give at the opposite corner: wrong on purpose."""
    return stiff({name: 1 - value for name, value in parameters.items()}, seed)


def crash(_parameters: Mapping[str, float], _seed: int) -> dict[str, float]:
    raise gf.RunFailedError("The soft particles fly away.")


def crash_at_the_answer(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
    if parameters["sliding"] > 0.4 and parameters["rolling"] < 0.6:
        raise gf.RunFailedError("The soft particles fly away.")
    return soft(parameters, seed)


def problem_at(sliding: float = 0.5, rolling: float = 0.4) -> gf.Problem:
    return gf.Problem(
        [gf.Parameter("sliding", 0, 1), gf.Parameter("rolling", 0, 1)],
        [
            gf.Target("angle", angle(sliding, rolling), tolerance=0.8),
            gf.Target("density", density(sliding, rolling), tolerance=6.0),
        ],
        relatives=[Relative("heap", COST)],
    )


def calibrated(
    relative: Model, workdir: Path | None = None, seed: int = 1
) -> tuple[gf.Result, list[Evaluation]]:
    found: list[Evaluation] = []

    def note(progress: gf.Progress) -> None:
        found[:] = progress.evaluations

    result = gf.calibrate(
        problem_at(),
        {"heap": PythonCallable(stiff)},
        relatives={"heap": PythonCallable(relative)},
        seed=seed,
        workdir=workdir,
        on_progress=note,
    )
    return result, found


def is_true(result: gf.Result) -> bool:
    at = result.parameters["sliding"], result.parameters["rolling"]
    off = abs(angle(*at) - angle(0.5, 0.4)), abs(density(*at) - density(0.5, 0.4))
    return off[0] <= 0.8 and off[1] <= 6.0


@pytest.mark.parametrize(
    "relative",
    [soft, pytest.param(turned, marks=pytest.mark.thorough), crash, crash_at_the_answer],
)
def test_a_calibration_is_true_with_any_relative(relative: Model) -> None:
    result, evaluations = calibrated(relative)
    assert result.status == "calibrated", result
    assert is_true(result)
    runs = Counter(test for one in evaluations for test in one.runs)
    assert 5 <= runs["heap (relative)"] <= 12
    assert 6 <= runs["heap"] <= 14
    fresh = [one for one in evaluations if one.proposal.stage == "verification"]
    assert len(fresh) >= 3
    assert all(set(one.runs) == {"heap"} for one in fresh)


def test_runs_of_a_relative_count_by_their_cost_in_the_budget() -> None:
    forecasts: list[gf.Progress] = []
    problem = replace(problem_at(), relatives=[Relative("heap", 0.1)])
    result = gf.calibrate(
        problem,
        {"heap": PythonCallable(stiff)},
        relatives={"heap": PythonCallable(soft)},
        max_runs=18,
        on_progress=forecasts.append,
    )
    assert result.status == "calibrated", result
    # They were counted as whole runs, so that none were left for fresh seeds.
    assert result.runs.total > 18
    assert result.runs.verification >= 3
    first = forecasts[0].to_come
    assert first.most is not None
    assert result.runs.design + 3 <= first.about <= first.most


def test_the_verdict_is_that_of_the_runs_of_the_test_alone(tmp_path: Path) -> None:
    result, _ = calibrated(soft, tmp_path / "work")
    saved = SavedCalibration.open(tmp_path / "work")
    assert saved.problem.relatives == ()
    own = [one for one in saved.evaluations if "heap" in one.runs]
    means = Metamodels.fit(saved.problem, own).predict([saved.problem.to_unit(result.parameters)])[
        0
    ][0]
    found = [result.responses[name].expected[0] for name in ("angle", "density")]
    assert means == pytest.approx(found)


@pytest.mark.thorough
def test_an_interrupted_calibration_goes_on_without_a_run_twice(tmp_path: Path) -> None:
    whole, _ = calibrated(soft, tmp_path / "whole")

    def stop(progress: gf.Progress) -> None:
        if len(progress.evaluations) == 7:
            raise KeyboardInterrupt

    def run(on_progress: Callable[[gf.Progress], None] | None = None) -> gf.Result:
        return gf.calibrate(
            problem_at(),
            {"heap": PythonCallable(stiff)},
            relatives={"heap": PythonCallable(soft)},
            workdir=tmp_path / "work",
            on_progress=on_progress,
        )

    stopped = run(stop)
    assert stopped.status == "interrupted"
    result = run()
    assert result.parameters == whole.parameters
    assert result.runs.reused >= 7
    assert run().runs.reused == whole.runs.total


def test_relatives_are_reused_from_a_calibration_of_their_own(tmp_path: Path) -> None:
    own = gf.Problem(problem_at().parameters, problem_at().targets)
    gf.calibrate(own, {"heap": PythonCallable(soft)}, workdir=tmp_path / "soft")
    made = 0

    def counted(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        return stiff(parameters, seed)

    result = gf.calibrate(
        problem_at(),
        {"heap": PythonCallable(counted)},
        relatives={"heap": PythonCallable(soft)},
        runs_from=tmp_path / "soft",
    )
    assert result.status == "calibrated"
    assert result.runs.reused == 0
    assert made <= 12


def test_a_calibration_without_relatives_keeps_its_identity(tmp_path: Path) -> None:
    own = gf.Problem(problem_at().parameters, problem_at().targets)
    gf.calibrate(own, {"heap": PythonCallable(stiff)}, workdir=tmp_path / "a", max_runs=9)
    saved = SavedCalibration.open(tmp_path / "a")
    assert "relatives" not in saved.strategy_options
    assert saved.problem == own


def test_what_cannot_be_a_relative_is_refused() -> None:
    with pytest.raises(InputError, match="above 0, below 1"):
        Relative("heap", 1.5)
    heap = {"heap": PythonCallable(stiff)}
    with pytest.raises(InputError, match=messages.RELATIVE_WITHOUT_SOLVER.pattern):
        gf.calibrate(problem_at(), heap)
    own = gf.Problem(problem_at().parameters, problem_at().targets)
    with pytest.raises(InputError, match=messages.NO_RELATIVE.pattern):
        gf.calibrate(own, heap, relatives={"heap": PythonCallable(soft)})
    with pytest.raises(
        InputError, match=of_strategies.FOREIGN_RELATIVES.matching(strategy="staged")
    ):
        gf.calibrate(
            problem_at(), heap, relatives={"heap": PythonCallable(soft)}, strategy=Staged()
        )


def test_a_search_that_is_asked_and_told_has_relatives() -> None:
    own = problem_at()
    with pytest.raises(InputError, match=of_problem.RELATIVE_OF_NO_TEST.pattern):
        gf.Sequential().start(own, seed=1)
    scope = gf.TestScope("heap", ["angle", "density"], ["sliding", "rolling"])
    search = gf.Sequential().start(replace(own, tests=[scope]), seed=1)
    asked: Counter[str] = Counter()
    while not search.finished:
        proposal = search.ask()
        assert proposal is not None
        assert proposal.tests is not None
        asked.update(proposal.tests)
        outcome: dict[str, float] = {}
        if "heap" in proposal.tests:
            outcome |= stiff(proposal.parameters, proposal.seed)
        if "heap (relative)" in proposal.tests:
            found = soft(proposal.parameters, proposal.seed)
            outcome |= {f"heap (relative).{name}": value for name, value in found.items()}
        search.tell(proposal, outcome)
    assert search.answer().probability_all_met > 0.5
    assert asked["heap (relative)"] >= 5


def test_ten_runs_that_cost_a_tenth_are_one_for_search_and_loop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scope = gf.TestScope("heap", ["angle", "density"], ["sliding", "rolling"])
    own = replace(problem_at(), tests=[scope], relatives=[Relative("heap", 0.1)])
    search = gf.Sequential().start(own, seed=1, max_evaluations=10)
    at = {"sliding": 0.5, "rolling": 0.4}
    asked = [gf.Proposal(at, seed, "design", ("heap (relative)",)) for seed in range(10)]
    monkeypatch.setattr(search, "_asked", asked)
    monkeypatch.setattr(search, "_allowed", 1)
    assert search._budget_is_used


def test_failures_of_a_relative_count_for_its_own_runs_alone() -> None:
    scope = gf.TestScope("heap", ["angle", "density"], ["sliding", "rolling"])
    own = replace(problem_at(), tests=[scope])
    at = {"sliding": 0.5, "rolling": 0.4}
    failed = [
        Evaluation(
            gf.Proposal(at, seed, "optimisation", ("heap (relative)",)),
            {},
            {"heap (relative)": "The soft particles fly away."},
            runs={"heap (relative)": str(seed)},
        )
        for seed in (1, 2)
    ]
    feasibility = FeasibilityModel(own, failed)
    points = np.array([[0.5, 0.4], [0.95, 0.05]])
    assert feasibility.success_of_run("heap", points) == pytest.approx([1.0, 1.0])
    near, far = feasibility.success_of_run("heap (relative)", points)
    assert near < 0.5 < far


def test_no_target_is_out_of_reach_because_a_relative_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A relative that is wrong on purpose left the first basin unseen."""
    benchmarks = Path(__file__).parents[2] / "benchmarks"
    monkeypatch.setattr(sys, "path", [str(benchmarks), *sys.path])
    import relatives

    found = relatives.calibrate(relatives.Calibration("basins", "wrong", "cheap", 1))
    assert found["status"] != "unreachable"
    assert found["off"] <= 1.0


def test_no_proposal_is_for_no_test_when_known_relatives_are_dropped() -> None:
    names = ("a", "b")
    free = [gf.Parameter("sliding", 0.0, 1.0), gf.Parameter("rolling", 0.0, 1.0)]
    scopes = [gf.TestScope(name, [f"{name}.angle"], ["sliding", "rolling"]) for name in names]
    targets = [gf.Target(f"{name}.angle", 25.0, uncertainty=0.3) for name in names]
    random = np.random.default_rng(1)

    def evaluation(proposal: gf.Proposal, values: Mapping[str, float]) -> Evaluation:
        responses = {name: gf.Response(value) for name, value in values.items()}
        asked = [name for name in names if proposal.asks_for(name)]
        failures = {} if values else dict.fromkeys(asked, "no heap")
        return Evaluation(proposal, responses, failures)

    relatives = [Relative(name, None) for name in names]
    known = []
    for number, (sliding, rolling) in enumerate(random.random((40, 2))):
        place = {"sliding": float(sliding), "rolling": float(rolling)}
        proposal = gf.Proposal(place, number, "design", tuple(one.name for one in relatives))
        angles = {f"{one.name}.angle": 21 + 10 * float(sliding) for one in relatives}
        known.append(evaluation(proposal, angles))
    search = gf.Sequential().start(gf.Problem(free, targets, tests=scopes), 1)
    search.learn_from_near(known, names)

    for number in range(20):
        asked = search.ask()
        assert asked is not None
        assert asked.tests != ()
        # Three places are enough with a relative, and not without.
        found = {
            f"{name}.angle": 20 + 10 * asked.parameters["sliding"] + 1.5 * random.normal()
            for name in names
            if number < 3
        }
        search.note(evaluation(asked, found))
