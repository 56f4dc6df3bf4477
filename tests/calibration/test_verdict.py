"""Verdicts by probability, and what is said of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration.verdict import judge, reasons
from grainfit.calibration.verification import FreshRuns
from grainfit.evaluation import Evaluation, Proposal
from grainfit.metamodels.curve_reduction import CurveBasis, Reduction
from grainfit.metamodels.outliers import Outliers
from grainfit.result import MetamodelQuality, OutOfReach
from grainfit.strategies.answer import Answer

ANGLE = gf.Target("angle", 30.0, tolerance=0.5, unit="deg")
PROBLEM = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [ANGLE])
FRESH = FreshRuns({"angle": {1: 29.9, 2: 30.0, 3: 30.2}}, ())


def answer(probability: float, without: float | None = None, **changes: object) -> Answer:
    known = Answer(
        {"friction": 0.5},
        {"angle": 30.0},
        {"angle": 0.2},
        probability,
        probabilities={"angle": probability},
        probability_without_outliers=probability if without is None else without,
        quality={"angle": MetamodelQuality(0.9, 0.95, 0.8)},
        runs_needed=12,
    )
    return replace(known, **changes)


def status(known: Answer, fresh: FreshRuns = FRESH) -> str:
    return judge(PROBLEM, known, fresh, 0.95, 3).status


@pytest.mark.parametrize(
    ("probability", "wanted"),
    [
        (0.99, "calibrated"),
        (0.95, "calibrated"),
        (0.94, "undecided"),
        (0.06, "undecided"),
        (0.05, "out_of_tolerance"),
        (0.0, "out_of_tolerance"),
    ],
)
def test_a_verdict_follows_the_probability(probability: float, wanted: str) -> None:
    assert status(answer(probability)) == wanted


def test_without_enough_fresh_seeds_nothing_is_calibrated() -> None:
    two = FreshRuns({"angle": {1: 29.9, 2: 30.0}}, ())
    assert status(answer(0.99), two) == "undecided"
    assert "only 2 of 3" in " ".join(reasons(PROBLEM, judge(PROBLEM, answer(0.99), two, 0.95, 3)))


def test_fresh_seeds_that_contradict_all_runs_leave_it_undecided() -> None:
    off = FreshRuns({"angle": {1: 32.4, 2: 32.5, 3: 32.7}}, ())
    assert status(answer(0.99), off) == "undecided"


def test_a_target_out_of_reach_is_unreachable_whatever_the_probability() -> None:
    miss = OutOfReach("angle", 30.0, 27.0, 0.1)
    assert status(answer(0.0, out_of_reach=(miss,))) == "unreachable"


@pytest.mark.parametrize(("with_all", "without"), [(0.99, 0.3), (0.3, 0.99), (0.01, 0.97)])
def test_outlying_runs_that_decide_leave_it_undecided(with_all: float, without: float) -> None:
    jams = {"angle": Outliers((3,), np.array([-6.0]), 20, (4711,))}
    known = answer(with_all, without, outliers=jams)
    outcome = judge(PROBLEM, known, FRESH, 0.95, 3)
    assert outcome.status == "undecided"
    words = " ".join(reasons(PROBLEM, outcome))
    assert "1 run of 20 lies far from the others (seed 4711), up to 6° below" in words
    assert 'statistic = "median"' in words


def test_noise_is_named_with_the_runs_it_would_take() -> None:
    outcome = judge(PROBLEM, answer(0.8), FRESH, 0.95, 3)
    [words] = reasons(PROBLEM, outcome)
    assert "80 %" in words or "80%" in words
    assert "about 12 more runs" in words
    assert "scatters by 0.8 in angle (tolerance 0.5)" in words


@pytest.mark.parametrize(
    ("fails", "words"),
    [
        ([True, False, False, True], "about 24 more runs at the answer, as 2 of 4 runs failed"),
        ([True, True], "About 12 more runs at the answer would have to succeed, but 2 of 2 runs"),
        ([False], "It would take about 12 more runs at the answer: one run scatters"),
    ],
)
@pytest.mark.parametrize("verified", [True, False])
def test_estimate_of_runs_counts_the_failing_ones(
    fails: list[bool], words: str, verified: bool
) -> None:
    proposal = Proposal({"friction": 0.5}, 1, "verification")
    ended = [
        Evaluation(
            proposal, {}, runs={"heap": "a"}, failed_runs={"heap": "no heap"} if fail else {}
        )
        for fail in fails
    ]
    fresh = replace(FRESH, evaluations=ended) if verified else replace(FRESH, search=ended)
    [found] = reasons(PROBLEM, judge(PROBLEM, answer(0.8), fresh, 0.95, 3))
    assert words in found
    if any(fails):
        assert f"failed {'there' if verified else 'in the search'}" in found


def test_too_few_fresh_seeds_are_said_to_have_failed() -> None:
    failed = Evaluation(
        Proposal({"friction": 0.5}, 1, "verification"),
        {},
        runs={"heap": "a"},
        failed_runs={"heap": "no heap"},
    )
    none = FreshRuns({"angle": {}}, ())
    [allowed] = reasons(PROBLEM, judge(PROBLEM, answer(0.99), none, 0.95, 3))
    assert "allow more runs" in allowed
    fresh = replace(none, evaluations=(failed, failed))
    [found] = reasons(PROBLEM, judge(PROBLEM, answer(0.99), fresh, 0.95, 3))
    assert "0 of 3 runs with fresh seeds at the answer succeeded: 2 of 2 runs there failed" in found


def test_a_calibrated_material_needs_no_reason() -> None:
    assert list(reasons(PROBLEM, judge(PROBLEM, answer(0.99), FRESH, 0.95, 3))) == []


def test_a_response_whose_scatter_makes_it_useless_is_named_with_the_runs_it_takes() -> None:
    # Three per cent of 30 degrees, where half a degree is asked for: (0.9 / 0.15)² = 36.
    close = replace(ANGLE, tolerance=0.15)
    problem = replace(PROBLEM, targets=[close])
    known = answer(0.5, quality={"angle": MetamodelQuality(0.9, 0.95, 0.9)})
    words = " ".join(reasons(problem, judge(problem, known, FRESH, 0.95, 3)))
    assert (
        "angle scatters by 3 % from run to run and tells nothing at its tolerance of 0.5 %: the "
        "mean of about 36 runs"
    ) in words
    assert "tells nothing" not in " ".join(reasons(PROBLEM, judge(PROBLEM, known, FRESH, 0.95, 3)))


def test_with_several_seeds_per_evaluation_words_count_runs() -> None:
    known = answer(0.5, quality={"angle": MetamodelQuality(0.9, 0.95, 0.8)})
    outcome = judge(PROBLEM, known, FRESH, 0.95, 3, {"heap": 4})
    words = " ".join(reasons(PROBLEM, outcome))
    assert "about 48 more runs at the answer: one mean of 4 runs scatters by 0.8" in words
    # A single run scatters by 1.6: 3.2 times the tolerance.
    assert "tells nothing" in words
    assert "the mean of about 11 runs" in words


STRAINS = np.linspace(0.01, 0.04, 4)


def reduced_curve() -> Reduction:
    """Stress over strain, which rises by a free slope: one component."""
    measured = gf.CurveTarget(
        "stress", STRAINS.tolist(), (100 * STRAINS).tolist(), 0.1, unit="Pa", coordinate="strain"
    )
    problem = gf.Problem([gf.Parameter("slope", 50, 150)], [ANGLE], curves=[measured])
    runs = np.array([slope * STRAINS for slope in np.linspace(50, 150, 9)])
    return Reduction(problem, (CurveBasis.of(measured, runs, 1),))


def answer_on_a_curve(reduction: Reduction, probability: float) -> Answer:
    """Return an answer that meets angle and curve, of which runs scatter."""
    [basis] = reduction.bases
    met = basis.scores(100 * STRAINS) | {"angle": gf.Response(30.0)}
    return answer(
        probability,
        predicted={name: response.value for name, response in met.items()},
        standard_errors=dict.fromkeys(met, 0.2),
        probabilities=dict.fromkeys(basis.names, probability) | {"angle": 0.99},
        quality={
            name: MetamodelQuality(0.9, 0.95, 0.8 if name == "angle" else 2.0) for name in met
        },
        reduction=reduction,
    )


def test_fresh_curves_that_contradict_all_runs_are_named_by_curve_and_points() -> None:
    reduction = reduced_curve()
    [basis] = reduction.bases
    fresh = {name: {} for name in basis.names} | FRESH.values
    for seed in (1, 2, 3):
        for name, score in basis.scores(130 * STRAINS).items():
            fresh[name][seed] = score.value
    known = answer_on_a_curve(reduction, 0.99)
    outcome = judge(reduction.problem, known, FreshRuns(fresh, ()), 0.95, 3)
    [words] = reasons(reduction.problem, outcome)
    assert words == (
        "stress is in doubt: from the curve that all runs together lead to expect, the mean of "
        "the 3 fresh seeds at the answer deviates by 8.2 standard uncertainties of the measured "
        "points (root mean square), most at strain = 0.04 (5.2 instead of 4), 0.03 (3.9 instead "
        "of 3) and 0.02 (2.6 instead of 2). The metamodels miss something there: more runs would "
        "tell."
    )


def test_noise_of_a_curve_is_named_by_the_curve_and_where_it_is_largest() -> None:
    reduction = reduced_curve()
    fresh = FreshRuns({name: {} for name in (*reduction.bases[0].names, "angle")}, ())
    outcome = judge(reduction.problem, answer_on_a_curve(reduction, 0.8), fresh, 0.95, 2)
    words = " ".join(reasons(reduction.problem, outcome))
    assert (
        "one run scatters by 1 σ of the measured points in stress (root mean "
        "square, most at strain = 0.04). A larger uncertainty of the measured points, a larger "
        "sample in the test, or a response that scatters less would help more."
    ) in words
    assert "component" not in words
