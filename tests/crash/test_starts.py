"""Two starts at once, folders that cannot be written, clocks that jump."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grainfit.campaign import messages as of_campaign
from grainfit.campaign.reserve import RESERVE_NAME, Reserve
from grainfit.campaign.store.store import RunStore
from grainfit.work_folder.status import read_status
from tests.crash.crash_harness import (
    PROGRAM,
    Tally,
    Trial,
    Variant,
    children,
    is_alive,
    small_disk,
)

FILE = """
name = "beads"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
type = "command"
folder = "model"
command = ["./simulate.sh", "{{ friction }}", "{{ seed }}"]
targets.angle = { value = 27, uncertainty = 0.5 }
"""


def calibration(folder: Path) -> Path:
    (folder / "model").mkdir()
    program = folder / "model" / "simulate.sh"
    program.write_text(PROGRAM, encoding="utf-8")
    program.chmod(0o755)
    file = folder / "beads.toml"
    file.write_text(FILE, encoding="utf-8")
    return file


def start(file: Path, seconds: float) -> subprocess.Popen[str]:
    environment = {
        "CRASH_LOG": str(file.with_suffix(".log")),
        "CRASH_SECONDS": str(seconds),
        "CRASH_OUTPUT": "100",
    }
    return subprocess.Popen(
        [sys.executable, "-m", "grainfit", "run", file.name, "--workers", "1", "--no-report"],
        cwd=file.parent,
        env={**os.environ, **environment, "COLUMNS": "400"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def files(folder: Path) -> dict[str, tuple[int, int]]:
    return {
        str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.stat().st_size)
        for path in folder.rglob("*")
        # The first one touches its lock every few seconds.
        if path.name not in ("runs.sqlite-shm", "lock")
    }


def test_a_second_start_in_the_same_folder_says_who_is_at_work_and_disturbs_nothing(
    tmp_path: Path,
) -> None:
    file = calibration(tmp_path)
    work = tmp_path / "beads.grainfit"
    first = start(file, seconds=60)
    try:
        # The last file of a start, which the first one may be about to write.
        while not any(path.stat().st_size for path in work.glob("runs/*.partial/.session")):
            assert first.poll() is None, first.communicate()
            time.sleep(0.05)
        before = files(work)
        second = start(file, seconds=0)
        _, message = second.communicate(timeout=60)
        assert second.returncode == 1
        assert of_campaign.FOLDER_IN_USE.is_in(message, process=first.pid)
        assert "Traceback" not in message
        assert files(work) == before
        assert first.poll() is None
    finally:
        first.send_signal(signal.SIGTERM)
        first.communicate(timeout=60)
    # What the first one was making was given up by it, and is made by the next one.
    third = start(file, seconds=0)
    out, message = third.communicate(timeout=120)
    assert third.returncode == 0, out + message


def test_solvers_that_work_elsewhere_end_before_their_runs_are_repeated(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    program = tmp_path / "model" / "simulate.sh"
    moved = PROGRAM.replace("sleep", "mkdir work; cd work; sleep")
    program.write_text(moved.replace("> responses.json", "> ../responses.json"), encoding="utf-8")
    first = start(file, seconds=600)
    log = file.with_suffix(".log")
    while not log.exists() or not log.read_text().strip():
        assert first.poll() is None, first.communicate()
        time.sleep(0.05)
    solver = int(log.read_text().split()[1])
    first.kill()
    first.communicate()
    assert is_alive(solver)
    second = start(file, seconds=0)
    out, message = second.communicate(timeout=120)
    assert second.returncode == 0, out + message
    assert not is_alive(solver)


def test_the_solvers_of_killed_workers_end_with_the_calibration(tmp_path: Path) -> None:
    variant = Variant("pool", workers=2, pool=True, seconds=60.0)
    trial = Trial(variant, tmp_path, Tally(""))
    process = trial.start()
    try:
        # A program notes its number a moment after its log has been opened.
        while len(trial.programs()) < 2:
            assert trial.ending().error == ""
            time.sleep(0.02)
        for worker in children(process):
            os.kill(worker, signal.SIGKILL)
        ending = trial.wait(process)
    finally:
        trial.clear_away()
    assert ending.error == "ExecutorError"
    programs = [pid for pid, _ in trial.programs()]
    assert len(programs) == 2
    assert not any(map(is_alive, programs))


def test_a_disk_that_cannot_be_written_ends_in_a_message(tmp_path: Path) -> None:
    try:
        with small_disk(tmp_path / "disk", 16 * 2**20) as disk:
            trial = Trial(Variant("read-only"), tmp_path / "trial", Tally(""), disk / "work")
            first = trial.wait(trial.start())
            subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
            # Whatever a start needs to write first: the lock, the store, a file of its own.
            existing = trial.wait(trial.start())
            trial.work = disk / "another"
            new = trial.wait(trial.start())
    except PermissionError as error:
        pytest.skip(str(error))
    assert first.result is not None
    for ending in (existing, new):
        assert ending.error == "StoreError"
        assert "cannot be used: Read-only file system. Choose another" in ending.message


def test_nothing_is_set_aside_on_a_disk_that_has_no_room_for_it(tmp_path: Path) -> None:
    try:
        with small_disk(tmp_path / "disk", 10_000_000) as disk:
            Reserve(disk)
            assert (disk / RESERVE_NAME).stat().st_size == 4_000_000
            # Now there is room for less than half as much again, and for this one it is there.
            Reserve(disk)
            assert (disk / RESERVE_NAME).stat().st_size == 4_000_000
            (disk / "other").mkdir()
            Reserve(disk / "other")
            assert not (disk / "other" / RESERVE_NAME).exists()
            Reserve(disk).close()
            assert not (disk / RESERVE_NAME).exists()
    except PermissionError as error:
        pytest.skip(str(error))


def test_a_clock_that_jumps_back_changes_neither_order_nor_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trial = Trial(Variant("clock"), tmp_path, Tally(""))
    first = trial.wait(trial.start(name="first", timeouts={"command": 30.0}))
    now = time.time
    monkeypatch.setattr(time, "time", lambda: now() - 3600)
    second = trial.wait(trial.start(name="second", seed=2, timeouts={"command": 30.0}))
    status = read_status(trial.work)
    assert first.result is not None
    assert second.result is not None
    assert (status.name, status.state) == ("second", "calibrated")
    store = RunStore.read_only(trial.work)
    latest = store.latest_calibration()
    store.close()
    assert latest is not None
    assert latest.started < now() - 3000
