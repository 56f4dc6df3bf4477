"""The run store keeps what it was given, and says when it cannot."""

import sqlite3
from pathlib import Path

import pytest

from grainfit.campaign.identity import run_identity
from grainfit.campaign.store import RequestRecord, RunRecord, RunStore
from grainfit.errors import StoreError
from grainfit.solvers.base import Response


def test_a_run_is_found_again_after_reopening(tmp_path: Path) -> None:
    record = RunRecord(
        "abc", "heap", "finished", {"seed": 1}, {"angle": Response(22.0, 0.5)}, seconds=6.0
    )
    store = RunStore.in_folder(tmp_path)
    store.save(record)
    store.close()
    again = RunStore.in_folder(tmp_path)
    assert again.find("abc") == record
    assert again.find("other") is None


def test_saving_again_replaces(tmp_path: Path) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("abc", "heap", "running", {}))
    store.save(RunRecord("abc", "heap", "failed", {}, reason="exploded"))
    assert [run.reason for run in store.runs()] == ["exploded"]


def test_runs_under_way_are_forgotten_and_others_are_not(tmp_path: Path) -> None:
    store = RunStore.in_folder(tmp_path)
    store.save(RunRecord("a", "heap", "running", {}))
    store.save(RunRecord("b", "heap", "finished", {}))
    store.forget_running()
    assert store.identities() == {"b"}


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
    with pytest.raises(StoreError, match="version 99"):
        RunStore.in_folder(tmp_path)


def test_a_damaged_store_is_an_error_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "runs.sqlite").write_text("this is not a database, " * 100)
    with pytest.raises(StoreError, match=r"runs\.sqlite"):
        RunStore.in_folder(tmp_path)


def test_identity_depends_on_content_not_on_order() -> None:
    assert run_identity({"a": 1, "b": {"c": 2.5}}) == run_identity({"b": {"c": 2.5}, "a": 1})
    assert run_identity({"a": 1}) != run_identity({"a": 2})
    assert run_identity({"a": 0.1 + 0.2}) != run_identity({"a": 0.3})
