"""Verdicts by probability, and what is said of them."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration.judged_answer import Demands, JudgedAnswer, judge_answer
from grainfit.calibration.verification import FreshRuns
from grainfit.evaluation import Evaluation, Proposal
from grainfit.metamodels.curve_reduction import CurveBasis, Reduction
from grainfit.metamodels.outliers import Outliers
from grainfit.result import MetamodelQuality, RunCounts
from grainfit.strategies.answer import Answer
from grainfit.verdict import messages
from grainfit.verdict.evidence import Expected, Scatter
from grainfit.verdict.out_of_reach import OutOfReach
from grainfit.verdict.reasons import (
    FreshSeedsMissing,
    NoisyResponse,
    OnTheEdge,
    OutliersDecide,
    OutlyingRuns,
    TooFewRuns,
    TooMuchScatter,
    UselessScatter,
)

ANGLE = gf.Target("angle", 30.0, tolerance=0.5, unit="deg")
PROBLEM = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [ANGLE])
FRESH = FreshRuns(
    {"angle": {1: 29.9, 2: 30.0, 3: 30.2}}, (), expected={"angle": Expected(30.0, 0.3)}
)
DEMANDS = Demands(0.95, 3, {})
OUTLIERS = Outliers((3,), (-6.0,), tuple((x / 20,) for x in range(20)), (4711,))
RESULT = gf.Result(
    "undecided", {}, {}, RunCounts(), None, None, None, 1.0, 0.9, 0.3, "", "", "sequential", 1, "0"
)
FAILED = Evaluation(
    Proposal({"friction": 0.5}, 1, "verification"),
    {},
    runs={"heap": "a"},
    failed_runs={"heap": "no heap"},
)


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


def judged(
    probability: float = 0.99,
    fresh: FreshRuns = FRESH,
    problem: gf.Problem = PROBLEM,
    **changes: Any,
) -> JudgedAnswer:
    return judge_answer(problem, answer(probability, **changes), fresh, DEMANDS)


@pytest.mark.parametrize(
    ("probability", "status", "verdict"),
    [
        (0.99, "calibrated", "met"),
        (0.95, "calibrated", "met"),
        (0.94, "undecided", "in doubt"),
        (0.06, "undecided", "in doubt"),
        (0.05, "out_of_tolerance", "missed"),
        (0.0, "out_of_tolerance", "missed"),
    ],
)
def test_a_verdict_follows_the_probability(probability: float, status: str, verdict: str) -> None:
    found = judged(probability, predicted={"angle": 30.6 if probability < 0.5 else 30.0})
    assert found.status == status
    assert found.judgement.responses == {"angle": verdict}


def test_an_answer_within_every_tolerance_is_not_missed_because_little_is_known() -> None:
    found = judged(0.04, standard_errors={"angle": 9.0}, runs_needed=500)
    assert found.status == "undecided"
    assert found.judgement.responses == {"angle": "in doubt"}
    assert isinstance(found.reasons[0], TooMuchScatter)


def test_fresh_seeds_that_contradict_the_others_leave_it_undecided() -> None:
    found = judged(fresh=replace(FRESH, values={"angle": {1: 32.4, 2: 32.5, 3: 32.7}}))
    assert found.status == "undecided"
    assert found.judgement.responses == {"angle": "in doubt"}
    [reason] = found.reasons
    assert (reason.kind, reason.target, reason.runs) == ("contradicted", "angle", 3)
    assert messages.CONTRADICTED.is_in(str(reason), runs="3 fresh seeds", mean=32.53)


def test_an_answer_on_the_edge_of_a_tolerance_is_called_so() -> None:
    known = {"standard_errors": {"angle": 0.1}, "runs_needed": 10**6}
    found = judged(0.6, predicted={"angle": 30.48}, **known)
    assert found.status == "undecided"
    assert isinstance(found.reasons[0], OnTheEdge)
    assert messages.ON_THE_EDGE.is_in(str(found.reasons[0]), where="on")
    assert "angle 0.96 tolerances off" in str(found.reasons[0])
    beyond = judged(0.1, predicted={"angle": 30.6}, **known)
    assert "beyond the edge" in str(beyond.reasons[0])
    # Where it may as well be half a tolerance away, more runs would change that.
    unsure = judged(0.1, predicted={"angle": 30.54}, standard_errors={"angle": 0.5})
    assert isinstance(unsure.reasons[0], TooMuchScatter)


def test_a_target_out_of_reach_is_unreachable_whatever_the_probability() -> None:
    miss = OutOfReach("angle", 30.0, 27.0, 0.1)
    assert judged(0.0, out_of_reach=(miss,)).status == "unreachable"


@pytest.mark.parametrize(
    ("with_all", "status"), [(0.99, "calibrated"), (0.3, "undecided"), (0.01, "out_of_tolerance")]
)
def test_outlying_runs_count_and_are_named(with_all: float, status: str) -> None:
    predicted = {"angle": 31.0 if status == "out_of_tolerance" else 30.0}
    found = judged(with_all, without=0.98, outliers={"angle": OUTLIERS}, predicted=predicted)
    assert found.status == status
    assert str(found.reasons[-1]).startswith(
        "angle: 1 outlying run of 20 (seed 4711), up to 6° below the prediction by the others."
    )
    decide = [one for one in found.reasons if isinstance(one, OutliersDecide)]
    assert decide == ([OutliersDecide(0.3, 0.98)] if status == "undecided" else [])


def test_outlying_runs_that_were_run_again_say_what_came() -> None:
    again = OutlyingRuns("angle", "deg", 20, (4711, 4712), -6.0, repeated=2, came_again=0)
    assert messages.RUN_AGAIN.is_in(str(again), repeated=2, came_again="none")


def test_noise_is_named_with_the_runs_it_would_take() -> None:
    [reason] = judged(0.8).reasons
    assert isinstance(reason, TooMuchScatter)
    assert reason.responses == (NoisyResponse("angle", 0.8, 0.5),)
    assert "a probability of 80 %, and 95 % is demanded" in str(reason)
    assert "scatters by 0.8 in angle (tolerance 0.5)" in str(reason)


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
    ended = [FAILED if fail else replace(FAILED, failed_runs={}) for fail in fails]
    fresh = replace(FRESH, evaluations=ended) if verified else replace(FRESH, search=ended)
    [reason] = judged(0.8, fresh).reasons
    assert words in str(reason)
    if any(fails):
        assert f"failed {'there' if verified else 'in the search'}" in str(reason)


@pytest.mark.parametrize(
    ("values", "failed", "message"),
    [
        ({1: 29.9, 2: 30.0}, 0, messages.FRESH_SEEDS_NOT_MADE(made=2, wanted=3)),
        ({}, 2, messages.FRESH_SEEDS_FAILED(made=0, wanted=3, failed=2, ended="2 runs")),
    ],
)
def test_without_enough_fresh_seeds_nothing_is_calibrated(
    values: dict[int, float], failed: int, message: str
) -> None:
    found = judged(fresh=FreshRuns({"angle": values}, (FAILED,) * failed))
    assert found.status == "undecided"
    assert found.reasons == (FreshSeedsMissing(len(values), 3, failed, failed),)
    assert str(found.reasons[0]) == message


def test_a_calibrated_material_needs_no_reason() -> None:
    assert judged().reasons == ()


def test_a_response_whose_scatter_makes_it_useless_is_named_with_the_runs_it_takes() -> None:
    # Three per cent of 30 degrees, where half a degree is asked for: (0.9 / 0.15)² = 36.
    problem = replace(PROBLEM, targets=[replace(ANGLE, tolerance=0.15)])
    quality = {"angle": MetamodelQuality(0.9, 0.95, 0.9)}
    _, useless = judged(0.5, problem=problem, quality=quality).reasons
    assert useless == UselessScatter("angle", "deg", 0.9, 0.15, 30.0)
    assert str(useless) == messages.USELESS_SCATTER(
        target="angle", scatter="3 %", tolerance="0.5 %", runs=36
    )
    [_] = judged(0.5, quality=quality).reasons


def test_scatter_is_said_only_where_runs_tell_it_from_a_trend() -> None:
    # Five runs of two parameters: what a metamodel cannot explain need not be scatter.
    known = {
        "without_trend": ("angle",),
        "predicted": {"angle": 40.0},
        "quality": {"angle": MetamodelQuality(0.1, 0.95, 9.0, noise_range=(1.0, 9.0))},
    }
    assert judged(0.01, **known).reasons == ()
    # Runs with equal parameters know their scatter: 1.6 in place of 9.
    repeated = replace(FRESH, scatter={"angle": Scatter(1.6, 2)})
    changes, useless = judged(0.01, repeated, **known).reasons
    assert messages.SCATTER_CHANGES.is_in(str(changes), here="1.6")
    assert useless == UselessScatter("angle", "deg", 1.6, 0.5, 30.0)


def test_where_no_trend_is_known_no_number_of_runs_is() -> None:
    [reason] = judged(0.5, without_trend=("angle",)).reasons
    assert reason == TooFewRuns(("angle",), 0.5, 0.95)
    assert messages.TOO_FEW_RUNS.is_in(str(reason), targets="angle")


def test_with_several_seeds_per_evaluation_words_count_runs() -> None:
    scatter, useless = judge_answer(
        PROBLEM, answer(0.5), FRESH, Demands(0.95, 3, {"heap": 4})
    ).reasons
    needed = messages.RUNS_NEEDED.matching(runs="48 more runs")
    assert re.search(f"{needed}: one mean of 4 runs scatters by 0.8", str(scatter))
    # A single run scatters by 1.6: 3.2 times the tolerance.
    assert messages.USELESS_SCATTER.is_in(str(useless), runs=11)


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
    expected = {name: Expected(value, 0.2) for name, value in known.predicted.items()}
    runs = FreshRuns(fresh, (), expected=expected)
    [reason] = judge_answer(reduction.problem, known, runs, DEMANDS).reasons
    assert (reason.kind, reason.curve, reason.runs) == ("curve contradicted", "stress", 3)
    assert str(reason.miss) == messages.CURVE_MISS(
        deviation="8.2",
        coordinate="strain",
        worst="0.04 (5.2 instead of 4), 0.03 (3.9 instead of 3) and 0.02 (2.6 instead of 2)",
    )


def test_noise_of_a_curve_is_named_by_the_curve_and_where_it_is_largest() -> None:
    reduction = reduced_curve()
    fresh = FreshRuns({name: {} for name in (*reduction.bases[0].names, "angle")}, ())
    known = answer_on_a_curve(reduction, 0.8)
    words = " ".join(
        map(str, judge_answer(reduction.problem, known, fresh, Demands(0.95, 2, {})).reasons)
    )
    assert messages.NOISY_CURVE.is_in(
        words, ratio="one run scatters by 1", curve="stress", place="strain = 0.04"
    )
    assert "A larger uncertainty" in words
    assert "component" not in words


def test_a_result_keeps_its_reasons_as_data_and_its_file_has_them_in_words(tmp_path: Path) -> None:
    reasons = judged(0.3, without=0.99, outliers={"angle": OUTLIERS}).reasons
    result = replace(RESULT, reasons=reasons, other_notices=("look",))
    path = tmp_path / "result.json"
    result.to_json(path)
    data = json.loads(path.read_text())
    assert data["notices"] == [*map(str, reasons), "look"]
    assert gf.Result.from_json(path) == result
    data["reasons"][0]["kind"] = "of a later version"
    path.write_text(json.dumps(data))
    later = gf.Result.from_json(path)
    assert later.reasons == reasons[1:]
    assert later.other_notices == (str(reasons[0]), "look")
    # Version 0.2.0 had all in words.
    del data["reasons"]
    path.write_text(json.dumps(data))
    assert gf.Result.from_json(path).notices == result.notices
    path.write_text(json.dumps(data | {"reasons": [{"kind": "outliers decide", "without": "1"}]}))
    with pytest.raises(gf.StoreError, match=r"reasons\.0\.with_all: is missing"):
        gf.Result.from_json(path)
