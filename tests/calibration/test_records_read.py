"""Rows of a table as evidence: once each, and at their own parameters only."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration import messages
from grainfit.calibration.records_read import RecordsRead
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.solvers.own_model.recorded_table import RecordedTable
from grainfit.solvers.parameters_for import AllBut, ParametersFor
from grainfit.strategies.distinct_runs import distinct_runs
from grainfit.verdict import messages as of_verdict
from grainfit.verdict.reasons import NoRecordThere

FRICTION = gf.Parameter("friction", 0.1, 0.9)
ROLLING = gf.Parameter("rolling", 0.1, 0.9, unit="1/m")
ANGLE = gf.Target("angle", 27.0, tolerance=0.4, unit="deg")


def rows(count: int) -> list[dict[str, float]]:
    random = np.random.default_rng(2)
    points = random.uniform(0.1, 0.9, (count, 2))
    return [
        {"friction": a, "rolling": b, "angle": 15 + 20 * a + 5 * b + random.normal(0, 0.3)}
        for a, b in points.tolist()
    ]


@pytest.fixture(scope="module")
def result() -> gf.Result:
    """Calibration that was "calibrated, more than 99 %" by one row, read three times."""
    table = RecordedTable(rows(40), ["friction", "rolling"], ["angle"], nearest=True)
    return gf.calibrate(gf.Problem([FRICTION, ROLLING], [ANGLE]), table, seed=2)


def test_nearest_rows_of_a_table_confirm_no_answer(result: gf.Result) -> None:
    assert result.status == "undecided"
    assert result.responses["angle"].verified_values == ()
    assert result.runs.verification == 0
    assert result.responses["angle"].verdict == "in doubt"
    assert "robability" not in str(result)


def test_the_result_says_that_runs_have_read_the_same_rows() -> None:
    table = RecordedTable(rows(6), ["friction", "rolling"], ["angle"], nearest=True)
    problem = gf.Problem([FRICTION, ROLLING], [ANGLE])
    result = gf.calibrate(problem, table, seed=2, max_runs=16)
    [said] = [one for one in result.notices if messages.ROWS_READ_AGAIN.is_in(one)]
    assert said.startswith(f"{result.runs.total} ")


def test_rows_that_are_read_once_each_need_no_word() -> None:
    table = RecordedTable(REPEATED, ["friction"], ["angle"])
    records = RecordsRead({"heap": table}, {"heap": 1})
    assert records.read_again([read(seed, "design") for seed in (3, 4, 5)]) == []
    [said] = records.read_again([read(seed, "design") for seed in (3, 4, 5, 6)])
    assert messages.ROWS_READ_AGAIN.is_in(said, runs=4, rows="3 rows", of_test="")


def test_an_answer_without_a_row_names_the_nearest(result: gf.Result) -> None:
    [reason] = [one for one in result.reasons if isinstance(one, NoRecordThere)]
    place = np.array([result.parameters[name] for name in ("friction", "rolling")])
    points = np.array([[row["friction"], row["rolling"]] for row in rows(40)])
    span = np.ptp(points, axis=0)
    nearest = int(np.linalg.norm((points - place) / span, axis=1).argmin())
    assert reason.record == f"row {nearest + 1}"
    friction, rolling = points[nearest]
    assert reason.there == f"friction = {friction:.6g}, rolling = {rolling:.6g} 1/m"
    assert of_verdict.NO_RECORD_THERE.is_in(str(reason), record=reason.record)


REPEATED = [{"friction": 0.5, "angle": 0.0} for _ in range(3)] + [{"friction": 0.7, "angle": 9.0}]


def read(seed: int, stage: Any, friction: float = 0.5) -> Evaluation:
    return Evaluation(Proposal({"friction": friction}, seed, stage), {"angle": Response(0.0)})


@pytest.mark.parametrize("wrapped", [False, True])
def test_a_row_is_a_fresh_seed_once(wrapped: bool) -> None:
    table: gf.Solver = RecordedTable(REPEATED, ["friction"], ["angle"], nearest=True)
    solver = ParametersFor(table, takes=AllBut(frozenset({"lid"}))) if wrapped else table
    records = RecordsRead({"heap": solver}, {"heap": 1})
    search = [read(3, "design")]
    # Seeds 3, 4 and 5 read the first, second and third row, which hold equal values.
    again = [read(seed, "verification") for seed in (6, 4, 7, 5)]
    assert records.repetitions(search, again).stale == {6: ("angle",), 7: ("angle",)}
    elsewhere = read(8, "verification", friction=0.55)
    assert records.repetitions([], [elsewhere]).stale == {8: ("angle",)}


def test_the_mean_of_a_row_with_itself_is_no_fresh_seed() -> None:
    solver = RecordedTable(REPEATED, ["friction"], ["angle"])
    records = RecordsRead({"heap": solver}, {"heap": 2})
    once = [read(1, "verification", friction=0.7)]
    assert records.repetitions([], once).stale == {1: ("angle",)}


def test_runs_that_are_made_are_all_fresh() -> None:
    solver = PythonCallable(lambda friction, seed: {"angle": 0.0}, ["angle"])
    records = RecordsRead({"heap": solver}, {"heap": 1})
    assert records.repetitions([read(1, "design")], [read(1, "verification")]).stale == {}
    assert records.missing_at({"friction": 0.5}, gf.Problem([FRICTION], [ANGLE])) == []


def test_of_several_tests_only_those_with_records_can_be_stale() -> None:
    table = RecordedTable(REPEATED, ["friction"], ["angle"])
    made = PythonCallable(lambda friction, seed: {"angle": 0.0})
    records = RecordsRead({"drum": made, "heap": table}, {"drum": 1, "heap": 1})
    responses = {"drum.angle": Response(0.0), "heap.angle": Response(0.0)}
    runs = [
        Evaluation(Proposal({"friction": 0.7}, seed, "verification"), responses) for seed in (1, 2)
    ]
    assert records.repetitions([], runs).stale == {2: ("heap.angle",)}


def test_metamodels_have_the_nearest_rows_at_their_own_parameters(tmp_path: Path) -> None:
    table = RecordedTable(rows(40), ["friction", "rolling"], ["angle"], nearest=True)
    problem = gf.Problem([FRICTION, ROLLING], [replace(ANGLE, tolerance=0.1)])
    gf.calibrate(problem, table, seed=4, max_runs=12, workdir=tmp_path)

    saved = gf.open(tmp_path)
    recorded = {(row["friction"], row["rolling"]): row["angle"] for row in rows(40)}
    known = [
        (tuple(one.proposal.parameters.values()), one.responses["angle"].value)
        for one in saved.known
    ]
    # Each row once, however many runs have read it.
    assert len(known) == len(set(known)) < len(saved.evaluations)
    assert all(recorded[place] == value for place, value in known)


def test_rows_of_several_tests_are_each_at_their_own_parameters() -> None:
    evaluation = Evaluation(
        Proposal({"friction": 0.5}, 1, "design"),
        {"drum.angle": Response(1.0), "heap.angle": Response(2.0), "pile.angle": Response(3.0)},
        runs={"drum": "a", "heap": "b", "pile": "c"},
        made_at={"heap": {"friction": 0.4}, "pile": {"friction": 0.6}},
    )
    found = {
        tuple(one.responses): one.proposal.parameters["friction"]
        for one in distinct_runs([evaluation])
    }
    assert found == {("heap.angle",): 0.4, ("pile.angle",): 0.6, ("drum.angle",): 0.5}
