"""A work folder describes its calibration completely, without the calibration file."""

from __future__ import annotations

import sqlite3
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import grainfit
from grainfit.analysis import messages as of_analysis
from grainfit.calibration import messages as of_calibration
from grainfit.calibration.provenance import Provenance
from grainfit.campaign import messages as store_messages
from grainfit.errors import StoreError
from grainfit.solvers.own_model.command import Command
from grainfit.work_folder import messages
from grainfit.work_folder.saved_calibration import SavedCalibration, read_answer

PROBLEM = grainfit.Problem(
    [grainfit.Parameter("particle.density", 2000, 3000, unit="kg/m^3")],
    [grainfit.Target("angle", 25.0, tolerance=0.5, unit="deg")],
    grainfit.RayleighTimeStep(
        np.float32(0.005), {"particle.youngs_modulus": 1e7, "particle.poissons_ratio": 0.25}
    ),
)


def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
    scatter = np.random.default_rng(seed).normal(0, 0.1)
    return {"angle": parameters["particle.density"] / 100 + scatter}


def test_a_work_folder_tells_all_of_its_calibration(tmp_path: Path) -> None:
    provenance = Provenance("beads.toml", "name = 'beads'", {"wall.density": 7700.0})
    result = grainfit.calibrate(
        PROBLEM, simulate, workdir=tmp_path, name="beads", workers=2, provenance=provenance
    )
    reading = SavedCalibration.open(tmp_path)
    assert (reading.name, reading.state, reading.seed) == ("beads", "calibrated", 1)
    assert reading.problem == PROBLEM
    assert [e.proposal.seed for e in reading.evaluations] != []
    assert {e.proposal.seed for e in reading.evaluations} == {run.seed for run in result.history}
    assert reading.records.keys() == {run for r in result.history for run in r.runs.values()}
    assert reading.result == result
    assert (reading.source, reading.source_text) == ("beads.toml", "name = 'beads'")
    assert reading.fixed == {"wall.density": 7700.0}
    assert reading.units == {"particle.density": "kg/m^3", "wall.density": "kg/m^3"}
    assert reading.workers == 2


def test_the_runs_of_a_calibration_are_a_data_frame(tmp_path: Path) -> None:
    def with_error(parameters: dict[str, float], seed: int) -> dict[str, tuple[float, float]]:
        if parameters["particle.density"] > 2700:
            raise ValueError("too dense")
        return {"angle": (simulate(parameters, seed)["angle"], 0.05)}

    grainfit.calibrate(PROBLEM, with_error, workdir=tmp_path)
    saved = SavedCalibration.open(tmp_path)
    runs = saved.runs()
    assert runs.index.name == "identity"
    assert set(runs.index) == saved.records.keys()
    assert runs.attrs["units"] == {
        "seconds": "s",
        "particle.density": "kg/m^3",
        "angle": "deg",
        "angle.standard_error": "deg",
    }
    finished, failed = (runs[runs["status"] == status] for status in ("finished", "failed"))
    assert len(finished) + len(failed) == len(runs)
    assert (finished["angle.standard_error"] == 0.05).all()
    assert failed["angle"].isna().all()
    assert set(failed["kind"]) == {"evaluation"}
    assert all("too dense" in reason for reason in failed["reason"])
    for evaluation in saved.evaluations:
        [identity] = evaluation.runs.values()
        row = runs.loc[identity]
        assert row["seed"] == evaluation.proposal.seed
        assert row["particle.density"] == evaluation.proposal.parameters["particle.density"]
        if "angle" in evaluation.responses:
            assert row["angle"] == evaluation.responses["angle"].value


def test_intervals_hold_what_was_asked_for_beyond_a_bound_that_was_moved(tmp_path: Path) -> None:
    narrow = grainfit.Problem([grainfit.Parameter("particle.density", 2000, 2300)], PROBLEM.targets)
    grainfit.calibrate(
        narrow, simulate, workdir=tmp_path, strategy=grainfit.Sequential(extend_intervals=True)
    )
    (parameter,) = SavedCalibration.open(tmp_path).problem.parameters
    assert parameter.minimum == 2000
    assert parameter.maximum > 2450


def test_folders_without_a_calibration_are_named(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match=store_messages.NO_WORK_FOLDER.pattern):
        SavedCalibration.open(tmp_path / "none")
    grainfit.calibrate(PROBLEM, simulate, workdir=tmp_path)
    with sqlite3.connect(tmp_path / "runs.sqlite") as connection:
        connection.execute("UPDATE calibrations SET definition = '{}'")
    with pytest.raises(StoreError, match=messages.UNREADABLE.pattern):
        SavedCalibration.open(tmp_path)
    with sqlite3.connect(tmp_path / "runs.sqlite") as connection:
        connection.execute("DELETE FROM calibrations")
    with pytest.raises(StoreError, match=messages.NOTHING_CALIBRATED.pattern):
        SavedCalibration.open(tmp_path)


def test_a_result_is_read_back_or_said_to_be_damaged_and_where(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    with pytest.raises(StoreError, match="cannot be read: No such file"):
        grainfit.Result.from_json(path)
    result = grainfit.calibrate(PROBLEM, simulate)
    result.to_json(path)
    assert grainfit.Result.from_json(path) == result
    whole = path.read_text()
    for old, new, why in (
        ('"verdict": "met"', '"verdict": "perhaps"', "responses.angle.verdict"),
        ('"predicted": 2', '"predicted": 1e9992', "not a finite number"),
        ('"wall_seconds": ', '"wall_seconds": NaN, "was": ', "NaN is not a finite number"),
        (whole, whole[:-20], "delimiter|Expecting|Unterminated"),
        (whole, "[" * 100_000, "recursion"),
    ):
        assert old in whole
        path.write_text(whole.replace(old, new))
        with pytest.raises(StoreError, match=f"is damaged: .*(?:{why}).*no finished run"):
            grainfit.Result.from_json(path)


def test_a_warm_start_counts_in_all_that_is_said(tmp_path: Path) -> None:
    first = grainfit.calibrate(PROBLEM, simulate, workdir=tmp_path)
    other = replace(PROBLEM, targets=[replace(PROBLEM.targets[0], value=25.2)])
    second = grainfit.calibrate(other, simulate, workdir=tmp_path)
    reading = SavedCalibration.open(tmp_path)
    assert len(reading.warm_start) == second.runs.warm_start_runs == first.runs.total
    assert len(reading.evaluations) == second.runs.total < first.runs.total
    assert len(reading.known) == first.runs.total + second.runs.total
    page = grainfit.write_report(tmp_path).read_text(encoding="utf-8")
    assert f"Besides these, a warm start used {first.runs.total} of other calibrations." in page
    assert "run of another calibration" in page
    # The second has hardly another place than its answer, and alone would tell nothing.
    assert of_analysis.DETERMINED_TO.is_in(page, name="particle density of the solid")


def test_another_weight_of_the_time_step_is_another_calibration(tmp_path: Path) -> None:
    first = grainfit.calibrate(PROBLEM, simulate, strategy="staged", workdir=tmp_path)
    fast = replace(PROBLEM, rayleigh_weight=1.0)
    second = grainfit.calibrate(fast, simulate, strategy="staged", workdir=tmp_path)
    assert second.identity != first.identity
    assert second.parameters != first.parameters
    assert SavedCalibration.open(tmp_path).problem == fast


def test_a_work_folder_tells_the_shape_of_a_time_step(tmp_path: Path) -> None:
    ratio = grainfit.Parameter("particle.aspect_ratio", 1.1, 2.0)
    rayleigh = grainfit.RayleighTimeStep(
        0.005,
        {**PROBLEM.rayleigh.fixed, "particle.density": 2500.0},
        "two_spheres",
    )
    problem = grainfit.Problem([ratio], [grainfit.Target("angle", 25.0, tolerance=0.5)], rayleigh)

    grainfit.calibrate(problem, lambda at, seed: {"angle": 20 * at[ratio.name]}, workdir=tmp_path)

    reading = SavedCalibration.open(tmp_path)
    assert reading.problem == problem
    assert reading.result is not None
    assert reading.result.rayleigh_time_step == pytest.approx(
        rayleigh({ratio.name: 1.25}), rel=0.02
    )


def test_the_result_of_an_earlier_start_is_not_that_of_the_last(tmp_path: Path) -> None:
    result = grainfit.calibrate(PROBLEM, simulate, workdir=tmp_path)
    replace(result, status="interrupted").to_json(tmp_path / "result.json")
    reading = SavedCalibration.open(tmp_path)
    assert reading.result is None
    assert "'interrupted' of a calibration that has ended as 'calibrated'" in reading.result_fault


def test_failures_that_stopped_a_calibration_are_told_with_their_logs(tmp_path: Path) -> None:
    model = tmp_path / "my model"
    model.mkdir()
    (model / "drum.py").write_text("particle_density = 0\nraise SystemExit('the drum has no lid')")
    solver = Command(model, [sys.executable, "drum.py"], response_names=("angle",))
    work = tmp_path / "my work"
    with pytest.raises(grainfit.RunFailedError):
        grainfit.calibrate(PROBLEM, {"drum": solver}, workdir=work)
    reading = SavedCalibration.open(work)
    assert (reading.state, len(reading.evaluations)) == ("failed", 3)
    assert of_calibration.ALL_FAILED.is_in(reading.failure, runs=3)
    assert all("the drum has no lid" in run.log_tail for run in reading.records.values())
    for source, file in (("", "FILE"), ("my sand.toml", "'my sand.toml'")):
        with pytest.raises(grainfit.InputError) as refused:
            read_answer(replace(reading, source=source))
        assert messages.NO_ANSWER_FAILED.is_in(str(refused.value), file=file)
    with pytest.raises(grainfit.InputError) as refused:
        read_answer(replace(reading, state="running"))
    assert messages.NO_ANSWER_WHILE_RUNNING.is_in(str(refused.value), quoted=f"'{work}'")
