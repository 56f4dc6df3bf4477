"""A store that an older grainfit wrote is brought up to date, and nothing in it is lost.

``store_version_1`` was written by a calibration of that version which was interrupted after seven
runs.
"""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

import grainfit
from grainfit.campaign import messages
from grainfit.campaign.store import schema
from grainfit.campaign.store.store import RunStore
from grainfit.errors import StoreError
from grainfit.result import Result
from grainfit.solvers.own_model.command import Command
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.status import read_status

VERSION_1 = Path(__file__).parent / "store_version_1"
PROBLEM = grainfit.Problem(
    [grainfit.Parameter("friction", 0.1, 0.9)], [grainfit.Target("angle", 27.0, tolerance=0.6)]
)
RUNS = 7


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A work folder whose store has version 1."""
    folder = tmp_path / "old"
    folder.mkdir()
    dump = (VERSION_1 / "runs.sql").read_text(encoding="utf-8")
    connection = sqlite3.connect(folder / "runs.sqlite")
    connection.executescript(dump)
    connection.close()
    return folder


def calibrate(folder: Path) -> Result:
    program = ["./simulate.sh", "{{ friction }}", "{{ seed }}"]
    return grainfit.calibrate(
        PROBLEM, Command(VERSION_1 / "model", program), workdir=folder, name="beads"
    )


def test_a_calibration_of_an_older_version_goes_on_where_it_was(old: Path) -> None:
    with sqlite3.connect(old / "runs.sqlite") as connection:
        asked = list(connection.execute("SELECT parameters, seed FROM requests ORDER BY position"))
    result = calibrate(old)
    assert [(json.dumps(run.parameters), run.seed) for run in result.history[:RUNS]] == asked
    assert (result.runs.reused, result.runs.warm_start_runs) == (RUNS, 0)
    assert result.status == "calibrated"
    assert read_status(old).kept == len(result.history)


def test_an_older_store_has_its_runs_and_the_order_of_its_calibrations(old: Path) -> None:
    with sqlite3.connect(old / "runs.sqlite") as connection:
        # The one that was started before is the one with the larger row number.
        connection.execute(
            "INSERT INTO calibrations SELECT 'other', 'earlier', definition, status, started - 60 "
            "FROM calibrations"
        )
        runs = set(connection.execute("SELECT identity, status FROM runs"))
    store = RunStore.in_folder(old)
    latest = store.latest_calibration()
    assert set(store.states().items()) == runs
    assert all(run.responses["angle"].value > 10 for run in store.runs("finished"))
    assert latest is not None
    assert latest.name == "beads"
    store.close()


def test_an_interrupted_calibration_of_an_older_version_can_be_read(old: Path) -> None:
    RunStore.in_folder(old).close()
    reading = SavedCalibration.open(old)
    assert (reading.name, reading.state, len(reading.evaluations)) == ("beads", "interrupted", RUNS)
    assert reading.problem.intervals == PROBLEM.intervals
    assert reading.source == ""


def test_status_of_an_older_store_says_what_to_do_and_leaves_it_as_it_is(old: Path) -> None:
    before = (old / "runs.sqlite").read_bytes()
    with pytest.raises(StoreError, match=messages.STORE_TOO_OLD.pattern):
        read_status(old)
    done = subprocess.run(
        [sys.executable, "-m", "grainfit", "status", old],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert (old / "runs.sqlite").read_bytes() == before


@pytest.mark.parametrize("statement", range(6))
def test_a_kill_in_the_middle_of_bringing_a_store_up_to_date_does_no_harm(
    old: Path, statement: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    statements = schema._MIGRATIONS[1]
    assert len(statements) == 6
    process = os.fork()
    if process == 0:
        # A statement that does not come back, in whose place the process is gone.
        broken = (*statements[:statement], "SELECT die()", *statements[statement:])
        schema._MIGRATIONS = {1: broken}  # type: ignore[misc]
        schema.sql.event.listen(schema.sql.Engine, "connect", _can_die)
        RunStore.in_folder(old)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 9
    with sqlite3.connect(old / "runs.sqlite") as connection:
        assert connection.execute("SELECT schema_version FROM about").fetchall() == [(1,)]
    store = RunStore.in_folder(old)
    assert len(store.runs("finished")) == RUNS
    store.close()


def _can_die(connection: sqlite3.Connection, _record: object) -> None:
    connection.create_function("die", 0, lambda: os._exit(9))
