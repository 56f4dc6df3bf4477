"""A calibration whose runs fail in half of an interval."""

from pathlib import Path
from random import Random

import pytest

import grainfit as gf
from grainfit.calibration.failed_runs import about_failed_runs
from grainfit.calibration.messages import RUNS_FAILED
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.messages import FAILURES
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import TestScope
from grainfit.verdict.messages import RUNS_FAIL_NEARER

LAST = 0.5


def calibrated_at(target: float, folder: Path) -> tuple[gf.Result, list[float]]:
    """Calibrate a slope of 40 whose runs jam from 0.5 on; return the tried values, too."""
    tried = []

    def slope(parameters: dict[str, float], seed: int) -> dict[str, float]:
        tried.append(parameters["a"])
        if parameters["a"] >= LAST:
            raise gf.RunFailedError("jammed")
        return {"y": 40.0 * parameters["a"] + Random(seed).gauss(0.0, 0.3)}

    problem = gf.Problem([gf.Parameter("a", 0.1, 0.9)], [gf.Target("y", target, uncertainty=1.0)])
    return gf.calibrate(problem, slope, workers=1, workdir=folder), tried


def test_a_target_beyond_the_runs_that_succeed_is_out_of_reach_soon(tmp_path: Path) -> None:
    result, tried = calibrated_at(30.0, tmp_path)
    assert result.status == "unreachable"
    [miss] = result.out_of_reach
    assert miss.runs_fail_nearer
    assert miss.nearest == pytest.approx(40.0 * LAST, abs=3.0)
    assert any(RUNS_FAIL_NEARER.is_in(notice) for notice in result.notices)
    assert any(RUNS_FAILED.is_in(notice) and "0.5" in notice for notice in result.notices)
    # A failure at a place is not repeated over and over.
    assert max(tried.count(value) for value in tried) <= 2
    assert len(tried) <= 14


def test_an_answer_close_to_runs_that_fail_is_found(tmp_path: Path) -> None:
    result, _ = calibrated_at(19.5, tmp_path)
    assert result.status == "calibrated"
    assert result.parameters["a"] == pytest.approx(19.5 / 40.0, abs=0.025)


def test_an_interval_ends_where_runs_fail(tmp_path: Path) -> None:
    result, _ = calibrated_at(17.0, tmp_path)
    interval = result.intervals["a"]
    # Runs at 0.6 and 0.8 have failed; the metamodel alone would go on to 0.8.
    assert interval.low < 17.0 / 40.0 < interval.high < 0.65


def run(a: float, b: float, outcome: str | None = None, test: str = "heap") -> Evaluation:
    """A run of a test, and why it failed."""
    proposal = Proposal({"a": a, "b": b}, 1, "design", (test,))
    if outcome is None:
        return Evaluation(proposal, {f"{test}.angle": Response(30.0)}, runs={test: "1"})
    return Evaluation(proposal, {}, {test: outcome}, runs={test: "1"})


PROBLEM = gf.Problem(
    [gf.Parameter("a", 0.0, 1.0), gf.Parameter("b", 0.0, 1.0)],
    [gf.Target("heap.angle", 30.0), gf.Target("drum.angle", 30.0)],
    tests=[
        TestScope("heap", ["heap.angle"], ["a", "b"]),
        TestScope("drum", ["drum.angle"], ["a"]),
    ],
)


def test_failures_are_said_with_the_parameter_that_explains_them() -> None:
    runs = [run(0.2, 0.9), run(0.8, 0.7), run(0.3, 0.2, "no heap"), run(0.9, 0.3, "no heap")]
    drums = [run(0.1 * i, 0.5, test="drum") for i in range(10)]
    assert not list(about_failed_runs(PROBLEM, [*runs, *drums]))
    [said] = about_failed_runs(PROBLEM, [*runs, run(0.5, 0.3011, "it slid"), *drums])
    assert RUNS_FAILED.is_in(said)
    for part in ("3 of 5", "heap", "b of 0.302 or less", "no heap"):
        assert part in said
    assert "it slid" not in said


def test_causes_that_differ_in_numbers_only_count_together() -> None:
    runs = [run(0.2, 0.9), *(run(0.1 * n, 0.2, f"no rest within 4.{n} s") for n in (3, 4, 5))]
    others = [run(0.1 * n, 0.3, "no heap") for n in (1, 2)]
    [said] = about_failed_runs(PROBLEM, [*others, *runs])
    assert said.endswith("no rest within 4.3 s")
    few = [Evaluation(Proposal({"x": 0.1}, 1, "design"), {}, {"simulate": "no heap"})]
    few += [
        Evaluation(Proposal({"x": 0.1 * n}, n, "design"), {}, {"simulate": f"no rest in {n}.5 s"})
        for n in (3, 4, 12)
    ]
    problem = gf.Problem([gf.Parameter("x", 0.0, 1.0)], [gf.Target("angle", 30.0, tolerance=1.0)])
    reasons = "no rest in 3.5 s (3 alike); no heap"
    with pytest.raises(gf.RunFailedError, match=FAILURES.matching(reasons=reasons)):
        Metamodels.fit(problem, few)


def test_failures_that_no_parameter_explains_are_said_where_they_are_many() -> None:
    fine = [run(0.1 * i, 1.0 - 0.1 * i) for i in range(10)]
    bad = [run(0.1 * i + 0.05, 0.05 + 0.1 * i, "jammed") for i in (2, 4, 6)]
    assert not list(about_failed_runs(PROBLEM, [*fine, *bad]))
    [said] = about_failed_runs(PROBLEM, [*fine[:6], *bad])
    assert "3 of 9" in said
    assert " or more" not in said
