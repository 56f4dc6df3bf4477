"""Work folders of version 0.1.0 open, are brought up to date, and repeat no run.

``work_folder_0_1_0`` has the store and the result of a calibration that version 0.1.0 finished,
and the records of one heap on each DEM program.
"""

from __future__ import annotations

import json
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import pytest

import grainfit
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.registry import recreate_test
from grainfit.campaign.reuse import models_of, runs_of
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.schema import SCHEMA_VERSION
from grainfit.campaign.store.store import RunStore
from grainfit.materials.sizes import ParticleSizes
from grainfit.run_definition import identity_of
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.own_model.command import Command
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.status import read_status

OLD = Path(__file__).parent / "work_folder_0_1_0"
MODEL = Path(__file__).parent / "store_version_1" / "model"
PROBLEM = grainfit.Problem(
    [grainfit.Parameter("friction", 0.1, 0.9)], [grainfit.Target("angle", 27.0, uncertainty=0.6)]
)
RUNS = 17
PROGRAM = ["./simulate.sh", "{{ friction }}", "{{ seed }}"]


@pytest.fixture
def old(tmp_path: Path) -> Path:
    folder = tmp_path / "beads.grainfit"
    folder.mkdir()
    connection = sqlite3.connect(folder / "runs.sqlite")
    connection.executescript((OLD / "runs.sql").read_text(encoding="utf-8"))
    connection.close()
    shutil.copy(OLD / "result.json", folder)
    return folder


def test_status_and_report_open_it_as_it_is(old: Path) -> None:
    before = (old / "runs.sqlite").read_bytes()
    saved, status = SavedCalibration.open(old), read_status(old)

    assert (saved.state, len(saved.evaluations), status.kept) == ("calibrated", RUNS, RUNS)
    assert saved.result is not None
    assert saved.result.parameters == {"friction": 0.5836456620427863}
    assert saved.result.responses["angle"].verified_standard_error == 0.04889753461548962
    assert saved.result.probability_all_met is not None
    assert saved.problem == PROBLEM
    assert grainfit.write_report(old).is_file()
    assert (old / "runs.sqlite").read_bytes() == before


def test_what_0_1_0_said_of_a_response_is_still_said(old: Path) -> None:
    text = (old / "result.json").read_text(encoding="utf-8")
    assert '"within_tolerance": true' in text
    found = grainfit.Result.from_json(old / "result.json").responses["angle"]
    assert (found.verdict, found.probability, found.verified_values) == ("met", None, ())
    # Its prediction was made without the verification runs: their mean counts, as it did then.
    assert found.expected == (27.25064614225742, 0.13576132063941582)
    assert found.deviation_percent == 0.9283190453978509

    for mean, verdict in (("27.3", "in doubt"), ("28.1", "missed"), ("null", "in doubt")):
        changed = text.replace('"within_tolerance": true', '"within_tolerance": false')
        (old / "result.json").write_text(changed.replace("27.25064614225742", mean))
        again = grainfit.Result.from_json(old / "result.json").responses["angle"]
        assert again.verdict == verdict


def test_a_damaged_flag_of_0_1_0_is_named(old: Path) -> None:
    text = (old / "result.json").read_text(encoding="utf-8")
    for damage in ('"within_tolerance": "yes"', '"within": true'):
        (old / "result.json").write_text(text.replace('"within_tolerance": true', damage))
        with pytest.raises(grainfit.GrainfitError, match=r"responses\.angle\.verdict"):
            grainfit.Result.from_json(old / "result.json")


def test_the_same_calibration_makes_no_run_and_chooses_its_answer_with_the_fresh_seeds(
    old: Path,
) -> None:
    solver = Command(MODEL, PROGRAM)
    result = grainfit.calibrate(PROBLEM, solver, workdir=old, name="beads")

    # Today fewer fresh seeds are enough: what it asks for is the beginning of what was made.
    assert (result.runs.total, result.runs.reused) == (len(result.history), len(result.history))
    assert (result.runs.verification, result.runs.warm_start_runs) == (3, 0)
    before = json.loads((OLD / "result.json").read_text(encoding="utf-8"))
    assert result.identity == before["identity"]
    made = [(run["seed"], run["parameters"]) for run in before["history"]]
    asked = [(run.seed, dict(run.parameters)) for run in result.history]
    assert asked == made[: len(asked)]
    assert result.status == "calibrated"
    # An earlier start was verifying this answer, and what is verified is frozen.
    assert result.parameters == before["parameters"]

    again = grainfit.calibrate(PROBLEM, solver, workdir=old, name="beads")
    assert (again.status, again.parameters) == (result.status, result.parameters)
    assert again.responses == result.responses


def test_the_store_knows_the_models_of_its_runs_afterwards(old: Path) -> None:
    store = RunStore.in_folder(old)
    try:
        [model] = models_of({"drum": Command(MODEL, PROGRAM)})
        assert len(store.runs_of([model])) == RUNS
        assert store.runs_of(["0" * 32]) == []
    finally:
        store.close()
    with sqlite3.connect(old / "runs.sqlite") as connection:
        assert connection.execute("SELECT schema_version FROM about").fetchone()[0] == (
            SCHEMA_VERSION
        )
        assert {len(row[0]) for row in connection.execute("SELECT model_hash FROM runs")} == {32}


def test_another_calibration_learns_from_it_without_changing_it(old: Path, tmp_path: Path) -> None:
    before = (old / "runs.sqlite").read_bytes()
    other = grainfit.Problem(PROBLEM.parameters, [grainfit.Target("angle", 30.0, uncertainty=0.6)])
    result = grainfit.calibrate(
        other, Command(MODEL, PROGRAM), workdir=tmp_path / "new", runs_from=[old]
    )

    assert result.runs.warm_start_runs == RUNS
    assert (old / "runs.sqlite").read_bytes() == before


def heap_record(name: str) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((OLD / f"{name}_run.json").read_text(encoding="utf-8"))
    return data


@pytest.mark.parametrize(("name", "program"), [("lammps", Lammps), ("liggghts", Liggghts)])
def test_a_heap_keeps_its_identity_and_is_not_taken_for_one_of_today(
    name: str, program: type[Solver], monkeypatch: pytest.MonkeyPatch
) -> None:
    data = heap_record(name)
    # Another version of the program makes another run; which one is installed does not matter.
    monkeypatch.setattr(program, "version", lambda _self: data["definition"]["version"])
    sizes, lengths = ParticleSizes((0.010,)), {"strike_off_height": 0.06, "bulk_density_top": 0.05}
    test = Heap(sizes, **lengths, **ROUGH_PLATE)
    fixed = {n: v for n, v in GLASS_BEADS.items() if n != "particle.density"}
    solver = program(test, fixed)  # type: ignore[call-arg]

    definition = solver.definition({"particle.density": 2300.0}, 7)

    record = RunRecord.from_json(data)
    assert record.definition.identity == data["identity"] == identity_of(data["definition"])
    again = recreate_test(record.definition)
    assert again is not None
    assert again.definition() == test.definition()
    smooth = program(Heap(sizes, **lengths), fixed)  # type: ignore[call-arg]
    today = {definition.identity, smooth.definition({"particle.density": 2300.0}, 7).identity}
    assert len(today | {data["identity"]}) == 3
    problem = grainfit.Problem(
        [grainfit.Parameter("particle.density", 2000.0, 2500.0)],
        [grainfit.Target("angle_of_repose", 22.0)],
    )
    assert not runs_of(problem, {"heap": solver}, [record])
