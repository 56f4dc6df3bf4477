"""The run store keeps what it was given, and says when it cannot."""

import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sql

from grainfit.campaign import messages
from grainfit.campaign import work_folder as workdir
from grainfit.campaign.store.records import RequestRecord, RunRecord, RunStatus
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import (
    close_run_folder,
    open_run_folder,
    read_record,
    recover,
    run_folder,
)
from grainfit.errors import StoreError
from grainfit.evaluation import Curve, Response
from grainfit.run_definition import RunDefinition, identity_of

RUN = RunDefinition({"solver": "drum"}, {"friction": 0.3}, 1)


def test_a_run_is_found_again_after_reopening(tmp_path: Path) -> None:
    record = RunRecord("abc", "heap", "finished", RUN, {"angle": Response(22.0, 0.5)}, seconds=6.0)
    store = RunStore.in_folder(tmp_path)
    store.save(record)
    store.close()
    again = RunStore.in_folder(tmp_path)
    assert again.find("abc") == record
    assert again.find("other") is None


def test_a_curve_of_a_run_is_found_again_after_reopening(tmp_path: Path) -> None:
    found = {"mass": Curve([0.0, 1.0, 2.0], [0.0, 0.5, 0.6], stays=True), "angle": Response(22.0)}
    record = RunRecord("abc", "silo", "finished", RUN, found)
    store = RunStore.in_folder(tmp_path)
    store.save(record)
    store.close()

    assert RunStore.in_folder(tmp_path).find("abc") == record


def test_saving_again_replaces(tmp_path: Path) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("abc", "heap", "running", RUN))
    store.save(RunRecord("abc", "heap", "failed", RUN, reason="exploded"))
    assert [run.reason for run in store.runs()] == ["exploded"]


def test_runs_that_a_start_makes_again_are_forgotten_and_others_are_not(tmp_path: Path) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("a", "heap", "running", RUN))
    for name in ("b", "c"):
        store.save(RunRecord(name, "heap", "failed", RUN))
    store.save(RunRecord("d", "heap", "finished", RUN))
    store.repeat_failed(["b", "d"])
    assert store.identities() == {"a", "b", "c", "d"}
    store.forget_unsettled()
    assert store.identities() == {"c", "d"}


@pytest.mark.parametrize("query", ["INSERT", "SELECT", "COMMIT"])
def test_an_interrupt_in_a_query_leaves_a_store_that_can_be_written(
    tmp_path: Path, query: str
) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("a", "heap", "finished", RUN))
    waiting = [KeyboardInterrupt()]

    def interrupt(_cursor: Any, statement: str, *_: Any) -> None:
        if waiting and statement.startswith(query):
            raise waiting.pop()

    def interrupt_commit(connection: Any) -> None:
        if waiting and query == "COMMIT":
            connection.connection.invalidate()
            raise waiting.pop()

    sql.event.listen(store._engine, "do_execute", interrupt)
    sql.event.listen(store._engine, "commit", interrupt_commit)
    with pytest.raises(KeyboardInterrupt):
        store.runs() if query == "SELECT" else store.save(RunRecord("b", "heap", "running", RUN))

    store.save(RunRecord("c", "heap", "finished", RUN))
    assert {run.identity for run in store.runs()} == {"a", "c"}
    store.close()
    assert not (tmp_path / "runs.sqlite-wal").exists()


def test_a_calibration_started_again_lists_its_requests_once(tmp_path: Path) -> None:
    store = RunStore.in_folder(tmp_path)
    for _ in range(2):
        store.begin_calibration("c", "beads", {})
        store.add_request("c", RequestRecord(1, "design", {"x": 0.5}, 7, {"heap": "a"}))
    assert [request.seed for request in store.requests("c")] == [7]


def test_a_store_of_another_version_is_refused(tmp_path: Path) -> None:
    RunStore.in_folder(tmp_path).close()
    with sqlite3.connect(tmp_path / "runs.sqlite") as connection:
        connection.execute("UPDATE about SET schema_version = 99")
    with pytest.raises(StoreError, match=messages.STORE_TOO_NEW.pattern):
        RunStore.in_folder(tmp_path)


def test_a_damaged_store_is_an_error_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "runs.sqlite").write_text("this is not a database, " * 100)
    with pytest.raises(StoreError, match=r"runs\.sqlite"):
        RunStore.in_folder(tmp_path)


def test_identity_depends_on_content_not_on_order() -> None:
    assert identity_of({"a": 1, "b": {"c": 2.5}}) == identity_of({"b": {"c": 2.5}, "a": 1})
    assert identity_of({"a": 1}) != identity_of({"a": 2})
    assert identity_of({"a": 0.1 + 0.2}) != identity_of({"a": 0.3})


@pytest.mark.parametrize(
    ("table", "column", "value"),
    [
        ("runs", "responses", '{"angle": {"value"'),
        ("runs", "responses", "[1, 2]"),
        ("runs", "responses", '{"angle": {"value": "high", "standard_error": 0}}'),
        ("runs", "responses", '{"mass": {"coordinates": [0, 0], "values": [1, 2]}}'),
        ("runs", "responses", '{"mass": {"coordinates": [0, 1], "values": 3, "stays": false}}'),
        ("runs", "definition", "null"),
        ("runs", "status", "sleeping"),
        ("runs", "seconds", "long"),
        ("requests", "parameters", "{"),
        ("requests", "runs", '"heap"'),
        ("calibrations", "definition", "{"),
    ],
)
def test_a_damaged_cell_is_an_error_that_says_what_to_do(
    tmp_path: Path, table: str, column: str, value: str
) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("abc", "heap", "finished", RUN, {"angle": Response(22.0)}))
    store.begin_calibration("c", "beads", {})
    store.add_request("c", RequestRecord(1, "design", {"x": 0.5}, 7, {"heap": "abc"}))
    with sqlite3.connect(tmp_path / "runs.sqlite") as connection:
        connection.execute(f"UPDATE {table} SET {column} = ?", [value])
    read = {
        "runs": lambda: store.find("abc"),
        "requests": lambda: store.requests("c"),
        "calibrations": store.latest_calibration,
    }
    with pytest.raises(StoreError, match=r"runs\.sqlite is damaged: .* Move runs\.sqlite away"):
        read[table]()


def test_a_damaged_store_moved_away_is_made_again_from_the_run_folders(tmp_path: Path) -> None:
    record = RunRecord("abc", "heap", "finished", RUN, {"angle": Response(22.0)})
    close_run_folder(open_run_folder(tmp_path, "abc"), run_folder(tmp_path, "abc"), record)
    (tmp_path / "runs.sqlite").write_text("this is not a database, " * 100)
    with pytest.raises(StoreError, match=r"Move runs\.sqlite away"):
        RunStore.in_folder(tmp_path)
    (tmp_path / "runs.sqlite").rename(tmp_path / "damaged")
    store = RunStore.in_folder(tmp_path)
    recover(tmp_path, store)
    assert store.find("abc") == record


def test_a_store_emptied_beside_its_log_is_not_taken_for_a_new_one(tmp_path: Path) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("abc", "python", "finished", RUN, {"angle": Response(22.0)}))
    killed = tmp_path / "killed"
    killed.mkdir()
    shutil.copy(tmp_path / "runs.sqlite-wal", killed)
    (killed / "runs.sqlite").touch()
    with pytest.raises(StoreError, match=r"it is empty\. Move runs\.sqlite away"):
        RunStore.in_folder(killed)
    assert (killed / "runs.sqlite-wal").stat().st_size > 0


@pytest.mark.parametrize("status", ["failed", "running"])
def test_a_run_that_a_worker_finished_after_its_process_had_died_is_found(
    tmp_path: Path, status: RunStatus
) -> None:
    record = RunRecord("abc", "heap", "finished", RUN, {"angle": Response(22.0)})
    close_run_folder(open_run_folder(tmp_path, "abc"), run_folder(tmp_path, "abc"), record)
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("abc", "heap", status, RUN, reason="the worker was lost", kind="machine"))
    recover(tmp_path, store)
    assert store.find("abc") == record


@pytest.mark.parametrize("second", [{}, {"angle": Response(22.5)}])
def test_the_folder_of_a_finished_run_is_not_given_up_for_that_of_the_same_run(
    tmp_path: Path, second: dict[str, Response]
) -> None:
    final = run_folder(tmp_path, "abc")
    first = RunRecord("abc", "heap", "finished", RUN, {"angle": Response(22.0)})
    close_run_folder(open_run_folder(tmp_path, "abc"), final, first)
    status: RunStatus = "finished" if second else "failed"
    close_run_folder(
        open_run_folder(tmp_path, "abc"), final, RunRecord("abc", "heap", status, RUN, second)
    )
    assert read_record(final) == first
    # A model that has learnt to yield another response replaces what is there.
    more = RunRecord("abc", "heap", "finished", RUN, {**first.responses, "density": Response(1.0)})
    close_run_folder(open_run_folder(tmp_path, "abc"), final, more)
    assert read_record(final) == more
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["abc"]


def test_a_kill_while_a_run_folder_is_thinned_out_does_not_cost_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def die(_folder: Path) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(workdir, "prune_run_folder", die)
    record = RunRecord("abc", "heap", "finished", RUN, {"angle": Response(22.0)})
    final = run_folder(tmp_path, "abc")
    with pytest.raises(KeyboardInterrupt):
        close_run_folder(open_run_folder(tmp_path, "abc"), final, record, "results")
    assert read_record(final) == record


def test_a_folder_in_place_of_the_store_is_an_error_that_says_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "runs.sqlite").mkdir()
    for opened in (RunStore.in_folder, RunStore.read_only):
        with pytest.raises(StoreError, match=messages.STORE_IS_FOLDER.pattern):
            opened(tmp_path)


@pytest.mark.parametrize("name", ["what?", "100%", "a%20b", "x?mode=memory", "#1", "two words"])
def test_work_folders_of_any_name(tmp_path: Path, name: str) -> None:
    folder = tmp_path / name
    folder.mkdir()
    store = RunStore.in_folder(folder)
    store.save(RunRecord("abc", "heap", "failed", RUN))
    assert (folder / "runs.sqlite").is_file()
    for _ in ("with a process at work", "with none"):
        reader = RunStore.read_only(folder)
        assert reader.identities() == {"abc"}
        reader.close()
        store.close()
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_store_opened_to_read_cannot_be_written(tmp_path: Path) -> None:
    RunStore.in_folder(tmp_path).close()
    with pytest.raises(StoreError, match="readonly"):
        RunStore.read_only(tmp_path).save(RunRecord("abc", "heap", "failed", RUN))


def test_a_store_of_another_version_is_not_read_either(tmp_path: Path) -> None:
    RunStore.in_folder(tmp_path).close()
    with sqlite3.connect(tmp_path / "runs.sqlite") as connection:
        connection.execute("UPDATE about SET schema_version = 99")
    with pytest.raises(
        StoreError, match=re.escape(f"{tmp_path}/runs.sqlite has schema version 99")
    ):
        RunStore.read_only(tmp_path)


@pytest.mark.parametrize("name", ["runs.sqlite-wal", "runs.sqlite-shm"])
def test_unusable_file_beside_a_store_is_named_as_the_cause(tmp_path: Path, name: str) -> None:
    RunStore.in_folder(tmp_path).close()
    (tmp_path / name).mkdir()
    with pytest.raises(StoreError, match=messages.NOT_WRITABLE.pattern) as caught:
        RunStore.in_folder(tmp_path)
    assert f"{name}' cannot be written: Is a directory" in str(caught.value)
    assert "full" not in str(caught.value)


@pytest.fixture
def public() -> Iterator[Path]:
    """Return a folder that every user may enter."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        yield Path(folder)


@contextmanager
def without_root() -> Iterator[None]:
    """Act as a user whom permissions concern."""
    if os.geteuid():
        yield
        return
    os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(0)


@pytest.mark.parametrize("name", ["runs.sqlite-wal", "runs.sqlite-shm", "runs.sqlite"])
def test_missing_permission_is_named_as_the_cause(tmp_path: Path, public: Path, name: str) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("a", "heap", "finished", RUN))
    killed = Path(shutil.copytree(tmp_path, public / "killed"))
    store.close()
    for path in (killed, *killed.iterdir()):
        path.chmod(0o777)
    (killed / name).chmod(0o444)
    with (
        without_root(),
        pytest.raises(StoreError, match=f"{name}' cannot be written: Permission denied") as caught,
    ):
        RunStore.in_folder(killed).save(RunRecord("b", "heap", "finished", RUN))
    assert "full" not in str(caught.value)


def test_log_removed_while_the_store_is_in_use_is_told(tmp_path: Path) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("a", "heap", "finished", RUN))
    (tmp_path / "runs.sqlite-wal").unlink()
    with pytest.raises(StoreError, match=messages.STORE_REMOVED.pattern):
        store.save(RunRecord("b", "heap", "finished", RUN))
    store.close()


_INTERRUPTED = """
import sqlalchemy as sql
from grainfit.campaign.store.store import RunStore

def interrupt(*_):
    raise KeyboardInterrupt

store = RunStore("sqlite:///runs.sqlite")
sql.event.listen(store._engine, "reset", interrupt)
try:
    store.runs()
except KeyboardInterrupt:
    print("interrupted")
"""


def test_a_ctrl_c_while_a_connection_is_given_back_prints_no_traceback(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _INTERRUPTED],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert (done.stdout, done.stderr) == ("interrupted\n", "")
