"""Looking at a work folder from outside disturbs nothing."""

from __future__ import annotations

import fcntl
import io
import json
import shutil
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

import grainfit
import grainfit as gf
from grainfit.calibration.live_file import LiveFile
from grainfit.calibration.runs_to_come import RunsToCome
from grainfit.campaign import messages
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.pending import ClusterJob, PendingRun, executing
from grainfit.campaign.store.records import RequestRecord, RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.cli.console import print_status
from grainfit.errors import StoreError
from grainfit.run_definition import RunDefinition
from grainfit.work_folder.status import read_status


def work(folder: Path) -> RunStore:
    store = RunStore.in_folder(folder)
    store.begin_calibration("c", "beads", {})
    store.add_request("c", RequestRecord(1, "design", {"x": 0.5}, 7, {"heap": "abc"}))
    store.save(RunRecord("abc", "heap", "finished", RunDefinition({}, {}, 1)))
    return store


def files(folder: Path) -> dict[str, tuple[int, int]]:
    # The index of the write-ahead log is memory that processes share, not a file.
    kept = [path for path in folder.iterdir() if not path.name.endswith("-shm")]
    return {path.name: (path.stat().st_mtime_ns, path.stat().st_size) for path in kept}


def shown(folder: Path) -> str:
    console = Console(file=io.StringIO(), width=200)
    print_status(console, read_status(folder))
    return console.file.getvalue()  # type: ignore[attr-defined]


def test_status_of_a_finished_calibration_changes_no_file(tmp_path: Path) -> None:
    work(tmp_path).close()
    before = files(tmp_path)
    assert read_status(tmp_path).kept == 1
    assert files(tmp_path) == before
    assert not list(tmp_path.glob("*-shm"))


def test_status_of_a_calibration_at_work_sees_its_latest_run_and_changes_no_file(
    tmp_path: Path,
) -> None:
    with hold(tmp_path):
        store = work(tmp_path)
        before = files(tmp_path)
        status = read_status(tmp_path)
        assert files(tmp_path) == before
        store.save(RunRecord("next", "heap", "finished", RunDefinition({}, {}, 1)))
        assert (status.state, status.kept) == ("running", 1)
        assert read_status(tmp_path).kept == 2


@pytest.mark.parametrize(("about", "running"), [({}, 1), ({"workers": 2}, 2), ({"workers": 9}, 3)])
def test_no_more_runs_are_running_than_there_are_workers(
    about: dict[str, int], running: int, tmp_path: Path
) -> None:
    with hold(tmp_path):
        store = RunStore.in_folder(tmp_path)
        store.begin_calibration("c", "beads", {}, about=about)
        for name in ("one", "two", "three"):
            store.save(RunRecord(name, "heap", "running", RunDefinition({}, {}, 1)))
        assert read_status(tmp_path).running == running
    # Nothing runs where the process has died.
    assert read_status(tmp_path).running == 0


def test_runs_whose_jobs_wait_in_a_queue_do_not_run(tmp_path: Path) -> None:
    jobs = [ClusterJob("7", "pending", "Resources"), ClusterJob("8", "pending", "Resources")]
    pending = tuple(PendingRun(name, "heap", "submitted") for name in ("one", "two", "three"))
    with hold(tmp_path):
        store = RunStore.in_folder(tmp_path)
        store.begin_calibration("c", "beads", {}, about={"workers": 4})
        for run in pending:
            store.save(RunRecord(run.identity, "heap", "running", RunDefinition({}, {}, 1)))
        for state, running, waiting in (("pending", 0, 3), ("running", 2, 1)):
            now = (replace(jobs[0], state=state), jobs[1])
            count = executing(3, 4, now)
            progress = gf.Progress(
                *("design", 0, count, 0, RunsToCome(9.0), None, None, ()), pending=pending, jobs=now
            )
            assert (progress.running, progress.waiting) == (running, waiting)
            LiveFile(tmp_path).update("c", progress)
            status = read_status(tmp_path)
            assert (status.running, status.waiting) == (running, waiting)
            assert f"{running} running, {waiting} waiting" in shown(tmp_path)


def test_status_of_a_killed_calibration_sees_its_latest_run_and_changes_no_file(
    tmp_path: Path,
) -> None:
    (tmp_path / "alive").mkdir()
    store = work(tmp_path / "alive")
    shutil.copytree(tmp_path / "alive", tmp_path / "killed")
    store.close()
    before = files(tmp_path / "killed")
    status = read_status(tmp_path / "killed")
    assert files(tmp_path / "killed") == before
    assert (status.state, status.kept, dict(status.asked)) == ("interrupted", 1, {"design": 1})


def test_runs_that_stopped_a_calibration_are_counted_until_they_are_repeated(
    tmp_path: Path,
) -> None:
    seeds: list[int] = []
    is_broken = True

    def model(parameters: dict[str, float], seed: int) -> dict[str, float]:
        seeds.append(seed)
        if is_broken:
            raise ValueError("the heap has no plate")
        return {"angle": 60 * parameters["friction"]}

    problem = grainfit.Problem(
        [grainfit.Parameter("friction", 0.1, 0.9)], [grainfit.Target("angle", 30.0)]
    )
    with pytest.raises(grainfit.RunFailedError):
        grainfit.calibrate(problem, model, workdir=tmp_path)
    status = read_status(tmp_path)
    assert (len(status.failed), dict(status.finished)) == (len(seeds), {"design": len(seeds)})
    assert all("no plate" in run.reason for run in status.failed)
    failed, is_broken = seeds.copy(), False
    grainfit.calibrate(problem, model, workdir=tmp_path)
    assert seeds[len(failed) : 2 * len(failed)] == failed
    assert not read_status(tmp_path).failed


def test_status_before_the_store_is_written(tmp_path: Path) -> None:
    (tmp_path / "runs.sqlite").touch()
    with pytest.raises(StoreError, match=messages.STORE_EMPTY.pattern):
        read_status(tmp_path)
    assert (tmp_path / "runs.sqlite").stat().st_size == 0


def test_a_look_at_the_lock_does_not_refuse_a_run(tmp_path: Path) -> None:
    with hold(tmp_path):
        pass
    looking = (tmp_path / "lock").open()
    fcntl.flock(looking, fcntl.LOCK_SH)
    threading.Timer(0.3, looking.close).start()
    with hold(tmp_path):
        assert looking.closed


def test_a_folder_in_use_is_refused_soon(tmp_path: Path) -> None:
    with hold(tmp_path):
        began = time.monotonic()
        with pytest.raises(StoreError, match=messages.FOLDER_IN_USE.pattern), hold(tmp_path):
            pass
        # A lock of another machine is watched for 20 s.
        assert time.monotonic() - began < 15


@pytest.mark.parametrize(
    "result",
    [
        {"parameters": {"friction": "high", "density": None, "size": [1.0]}},
        {"parameters": [1.0, 2.0]},
        {"parameters": None},
        {"parameters": {"friction": 10**400}},
        ["a list"],
        {},
    ],
)
def test_a_result_of_another_form_does_no_harm(tmp_path: Path, result: object) -> None:
    work(tmp_path).close()
    if isinstance(result, dict):
        result = {"identity": "c", **result}
    (tmp_path / "result.json").write_text(json.dumps(result))
    assert "1 finished runs kept" in shown(tmp_path)
    assert "is damaged" in shown(tmp_path)


@pytest.mark.parametrize(("identity", "appears"), [("c", True), ("of an earlier one", False)])
def test_the_parameters_of_this_calibration_are_shown(
    tmp_path: Path, identity: str, appears: bool
) -> None:
    work(tmp_path).close()
    wanted = grainfit.Problem(
        [grainfit.Parameter("friction", 0.1, 0.9)], [grainfit.Target("angle", 30.0)]
    )
    result = grainfit.calibrate(wanted, lambda p, _seed: {"angle": 60 * p["friction"]})
    found = replace(result, identity=identity, parameters={"friction": 0.123456789})
    found.to_json(tmp_path / "result.json")
    assert ("friction = 0.12346" in shown(tmp_path)) is appears
