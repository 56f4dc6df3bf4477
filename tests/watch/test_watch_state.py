"""State that the page shows: of a running, a failed, a killed and a finished calibration."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import threading
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from watched_runs import NAME, calibration, go, run, served, wait_for

import grainfit as gf
from benchmarks import campaigns
from grainfit.atlas import messages as atlas_messages
from grainfit.bulk_tests.parameter_names import ROLLING
from grainfit.calibration import live_file
from grainfit.calibration.live_file import LIVE_NAME
from grainfit.calibration.so_far import result_so_far
from grainfit.campaign.folder_lock import hold, is_held
from grainfit.report import verdict_messages
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES
from grainfit.verdict.options import HOLDOUT
from grainfit.watch import follower, messages
from grainfit.watch.state import read_folder, state_of
from grainfit.watch.stopping import CannotStopError, stop_calibration, why_not_to_be_stopped


def state(folder: Path) -> dict[str, Any]:
    """Return the state with the best answer so far."""
    reading = read_folder(folder)
    saved = reading.saved
    found = result_so_far(saved.problem, saved.evaluations) if saved else None
    return state_of(reading, found)


@pytest.fixture(scope="module")
def half_way(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with campaigns.campaign("running_half_way", tmp_path_factory.mktemp("half")) as folder:
        yield folder


def test_a_running_calibration_shows_what_runs_and_what_is_expected(half_way: Path) -> None:
    # The live file is written once a second.
    wait_for(lambda: [row["number"] for row in state(half_way)["runs"]] == [10])
    found = state(half_way)
    assert found["state"] == "running"
    assert found["progress"]["done"] == 9
    low, high = found["progress"]["left"]
    assert 0 < low < high
    assert found["progress"]["seconds_left"][0] < found["progress"]["seconds_left"][1]
    assert found["progress"]["estimated"] == pytest.approx(time.time(), abs=60)
    [pending] = found["runs"]
    assert pending["number"] == 10
    assert pending["since"] == pytest.approx(time.time(), abs=60)
    assert "particle.density = " in pending["parameters"]
    assert verdict_messages.SO_FAR.is_in(found["verdict"]["line"])
    assert {row["name"] for row in found["responses"]} == {"bulk_density", "angle_of_repose"}
    for row in found["responses"]:
        bar = row["bar"]
        assert bar["low"] < bar["value"] < bar["high"]
        assert bar["from"] < 50 < bar["to"]
        assert "±" in row["expected"]
    assert found["provisional"]


def test_the_answer_so_far_is_that_of_the_calibration(tmp_path: Path) -> None:
    with campaigns.campaign("one_parameter", tmp_path):
        saved = gf.open(tmp_path)
    found = result_so_far(saved.problem, saved.evaluations, options=saved.strategy_options)
    assert saved.result is not None
    assert found is not None
    assert found.parameters == saved.result.parameters
    assert found.responses == saved.result.responses
    assert found.probability_all_met == saved.result.probability_all_met
    assert result_so_far(saved.problem, saved.evaluations[:1]) is None


def test_the_answer_so_far_prefers_what_the_calibration_does(tmp_path: Path) -> None:
    wanted = campaigns.problem(("particle.density", "particle.youngs_modulus"))
    model = campaigns.Model(wanted)
    strategy = gf.Sequential(prefer="accuracy")
    result = gf.calibrate(wanted, model, strategy=strategy, workdir=tmp_path)
    saved = gf.open(tmp_path)
    found = result_so_far(wanted, saved.evaluations, options=saved.strategy_options)
    assert found is not None
    assert found.parameters == result.parameters


def test_failures_are_shown_with_reason_the_latest_first(tmp_path: Path) -> None:
    with campaigns.campaign("only_failures_yet", tmp_path):
        found = state(tmp_path)
    assert found["state"] == "interrupted"
    assert [row["number"] for row in found["failures"]] == [2, 1]
    assert {row["reason"] for row in found["failures"]} == {"particles were lost"}
    assert found["failed"] == 2
    with campaigns.campaign("all_failed", tmp_path / "all"):
        stopped = state(tmp_path / "all")
    assert stopped["verdict"]["line"] == verdict_messages.STOPPED()
    assert "no licence" in stopped["verdict"]["details"][0]


def test_a_finished_calibration_shows_its_verdict_and_intervals(tmp_path: Path) -> None:
    with campaigns.campaign("one_parameter", tmp_path):
        found = state(tmp_path)
    assert found["state"] == found["title"] == "calibrated"
    assert found["verdict"]["grade"] == "good"
    assert not found["provisional"]
    assert found["parameters"][0]["interval"]
    assert found["runs"] == []
    assert not found["stop"]["possible"]
    assert not (tmp_path / LIVE_NAME).exists()


@pytest.mark.usefixtures("ctrl_c")
def test_hold_outs_are_simulated_before_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_file, "_INTERVAL_SECONDS", 0.0)
    seen: list[dict[str, Any]] = []

    def look(progress: gf.Progress) -> None:
        if progress.stage == "hold-out":
            seen.append(state(tmp_path))

    problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 30.0)])
    gf.calibrate(
        problem,
        lambda p: {"angle": 60 * p["friction"]},
        workdir=tmp_path,
        holdouts=[gf.Holdout("drum", lambda p: {"flow": p["friction"]})],
        on_progress=look,
    )

    assert {found["state"] for found in seen} == {"running"}
    lines = {found["verdict"]["line"] for found in seen}
    assert lines == {verdict_messages.HOLDOUTS_UNDER_WAY()}
    # The first time before the verdict was kept.
    assert not any(found["provisional"] or found["report"] for found in seen[1:])
    assert all(found["stop"]["possible"] for found in seen)
    assert "Hold-outs" in seen[0]["progress"]["stage"]
    done = [found["progress"]["done"] for found in seen]
    assert done[-1] == done[0] + HOLDOUT.sets
    rows = [row for found in seen for row in found["runs"]]
    assert {(row["test"], row["stage"]) for row in rows} == {("drum", "hold-out")}
    ended = state(tmp_path)
    assert (ended["state"], ended["progress"]["done"]) == ("calibrated", done[-1])
    assert not ended["stop"]["possible"]


def test_a_result_that_is_not_written_yet_is_not_missing(tmp_path: Path) -> None:
    with campaigns.campaign("one_parameter", tmp_path):
        (tmp_path / "result.json").unlink()
        with hold(tmp_path):
            found = state(tmp_path)
            assert found["verdict"]["line"] == "The last run has ended."
            assert found["provisional"]
        assert verdict_messages.NO_ANSWER.is_in(state(tmp_path)["verdict"]["line"])


def test_a_folder_without_calibration_or_store_says_so(tmp_path: Path) -> None:
    nothing = verdict_messages.NOTHING_THERE()
    assert state(tmp_path / "no_such_folder")["verdict"]["line"] == nothing
    (tmp_path / "runs.sqlite").write_bytes(b"no store" * 100)
    found = state(tmp_path)
    assert found["verdict"]["line"] == verdict_messages.UNREADABLE()
    assert "runs.sqlite" in found["verdict"]["details"][0]


def test_runs_without_a_worker_wait(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    work = tmp_path / "work"
    # One worker less than runs at a time, as on a cluster whose jobs are in the queue.
    with ThreadPoolExecutor(1) as executor, ThreadPoolExecutor(1) as caller:
        setup = gf.load(file)
        ended = caller.submit(
            gf.calibrate,
            setup.problem,
            setup.solvers,
            workers=2,
            executor=executor,
            workdir=work,
        )
        try:
            wait_for((work / LIVE_NAME).exists)
            wait_for(lambda: len(state(work)["runs"]) == 2)
            wait_for(lambda: state(work)["run_counts"]["running"] == 1)
            found = state(work)
            assert [row["state"] for row in found["runs"]] == ["running", "waiting"]
            assert found["run_counts"]["waiting"] == 1
        finally:
            go(tmp_path)
        assert ended.result(60).status == "calibrated"


def test_a_run_that_is_tried_again_says_so(tmp_path: Path) -> None:
    tries = []

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        tries.append(seed)
        if len(tries) == 1:
            raise gf.RunFailedError("no licence", kind="machine")
        return {"angle": 60 * parameters["friction"]}

    problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 30.0)])
    seen: list[tuple[str, int]] = []

    def look(progress: gf.Progress) -> None:
        seen.extend((run.state, run.tries) for run in progress.pending)

    gf.calibrate(problem, PythonCallable(simulate), workdir=tmp_path, on_progress=look)
    assert {("postponed", 1), ("submitted", 1)} <= set(seen)


def test_a_killed_run_is_shown_as_stopped(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    work = tmp_path / "sand.grainfit"
    with run(file) as process:
        wait_for(lambda: len(state(work)["runs"]) == 2)
        assert state(work)["name"] == NAME
        assert state(work)["stop"]["possible"]
        process.kill()
        process.wait(60)
    assert (work / LIVE_NAME).exists()
    found = state(work)
    assert found["state"] == "interrupted"
    assert found["verdict"]["line"].startswith("Interrupted.")
    assert found["runs"] == []
    assert found["progress"]["left"] is None
    go(tmp_path)
    with hold(work):
        # Another command at work in the folder does not bring it to life.
        assert state(work)["runs"] == []


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{", "null", '{"calibration": 1}', "[" * 100_000, '{"process": {"x": 1}}'],
)
def test_a_damaged_live_file_is_ignored(half_way: Path, content: str) -> None:
    wait_for((half_way / LIVE_NAME).exists)
    before = (half_way / LIVE_NAME).read_text()
    try:
        (half_way / LIVE_NAME).write_text(content)
        found = state(half_way)
        assert found["state"] == "running"
        assert found["runs"] == []
        # Of another process, such as one that was killed in the folder before.
        other = json.loads(before) | {"process": {"process": "1", "host": "h", "boot": "b"}}
        (half_way / LIVE_NAME).write_text(json.dumps(other))
        assert state(half_way)["runs"] == []
    finally:
        (half_way / LIVE_NAME).write_text(before)


def test_an_interrupted_calibration_leaves_no_live_file(tmp_path: Path) -> None:
    with campaigns.campaign("interrupted", tmp_path):
        assert not (tmp_path / LIVE_NAME).exists()


# Stopping ------------------------------------------------------------------------------------


def test_a_calibration_of_another_machine_is_not_stopped_here(tmp_path: Path) -> None:
    (tmp_path / "lock").write_text(f"{os.getpid()} another-host other-boot\n")
    assert "kill -INT" in why_not_to_be_stopped(tmp_path)
    with pytest.raises(CannotStopError, match=messages.ANOTHER_MACHINE.pattern):
        stop_calibration(tmp_path)


def test_a_process_that_does_not_hold_the_folder_is_not_stopped(tmp_path: Path) -> None:
    received = []
    before = signal.signal(signal.SIGINT, lambda *given: received.append(given))
    other = subprocess.Popen(["sleep", "60"])
    try:
        with pytest.raises(CannotStopError, match=messages.NOT_IN_USE()):
            stop_calibration(tmp_path)
        with hold(tmp_path):
            signature = (tmp_path / "lock").read_text().split()
            # The number of a process that has ended, or is another one by now.
            for number in (str(other.pid), "999999999", "0", "-1", "x"):
                (tmp_path / "lock").write_text(" ".join([number, *signature[1:]]))
                with pytest.raises(CannotStopError, match=messages.UNKNOWN_PROCESS.pattern):
                    stop_calibration(tmp_path)
            (tmp_path / "lock").write_text(" ".join(signature))
            stop_calibration(tmp_path)
    finally:
        signal.signal(signal.SIGINT, before)
        was_alive = other.poll() is None
        other.kill()
        other.wait()
    assert len(received) == 1
    assert was_alive


# Following -----------------------------------------------------------------------------------


def test_a_heartbeat_of_another_machine_counts_as_running(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some file systems keep the locks of every machine apart."""
    monkeypatch.setattr(follower, "_SILENT_SECONDS", 3.0)
    file = calibration(tmp_path)
    work = tmp_path / "sand.grainfit"
    with run(file) as process:
        process.kill()
        process.wait(60)
    lock = work / "lock"
    lock.write_text("17 another-host other-boot\n")
    with served(work) as server:
        assert now(server.follower)["state"] == "interrupted"
        beat(lock, 1)
        wait_for(lambda: now(server.follower)["state"] == "running", 10)
        assert "another-host" in now(server.follower)["stop"]["why"]
        wait_for(lambda: now(server.follower)["state"] == "interrupted", 10)


def beat(lock: Path, seconds: float) -> None:
    changed = lock.stat().st_mtime + seconds
    os.utime(lock, (changed, changed))


def now(following: follower.Follower) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(following.wait(0, 1)[1])
    return found


def test_a_follower_tells_of_every_change(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    work = tmp_path / "sand.grainfit"
    with run(file) as process, served(work) as server, server.follower.watching():
        wait_for(lambda: len(now(server.follower)["runs"]) == 2)
        number, text = server.follower.wait(0, 1)
        states = [json.loads(text)["state"]]
        go(tmp_path)
        assert process.wait(60) == 0
        while states[-1] == "running":
            number, text = server.follower.wait(number, 30)
            states.append(json.loads(text)["state"])
        assert states[-1] == "calibrated"
        wait_for(lambda: now(server.follower)["responses"][0]["verdict"].startswith("met"))


def test_a_fault_while_reading_is_shown_and_survived(
    tmp_path: Path,
) -> None:
    with campaigns.campaign("no_run_finished", tmp_path), served(tmp_path) as server:
        assert now(server.follower)["state"] == "interrupted"
        store = tmp_path / "runs.sqlite"
        content = store.read_bytes()
        store.write_bytes(content[:100] + b"\0" * (len(content) - 100))
        wait_for(lambda: now(server.follower)["state"] == "unreadable", 10)
        assert "runs.sqlite" in now(server.follower)["verdict"]["details"][0]
        store.write_bytes(content)
        wait_for(lambda: now(server.follower)["state"] == "interrupted", 10)


def test_an_end_and_a_start_are_seen_while_a_verdict_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Metamodels of many runs take seconds, and rest for nine times as long."""
    done = threading.Event()
    monkeypatch.setattr(follower, "result_so_far", lambda *_, **__: done.wait(60) and None)
    file = calibration(tmp_path)
    work = tmp_path / "sand.grainfit"
    with run(file) as process, served(work) as server, server.follower.watching():
        wait_for(lambda: server.follower._so_far[0] is not None)
        assert now(server.follower)["state"] == "running"
        process.kill()
        process.wait(60)
        wait_for(lambda: now(server.follower)["state"] == "interrupted", 5)
        assert now(server.follower)["title"] == "interrupted"
        with run(file):
            wait_for(lambda: is_held(work))
            wait_for(lambda: now(server.follower)["state"] == "running", 5)
            assert now(server.follower)["stop"] == {"possible": True, "why": ""}
        done.set()
        # What was computed meanwhile brings no earlier state back.
        wait_for(lambda: now(server.follower)["state"] == "interrupted", 5)
        time.sleep(1.5)
        assert now(server.follower)["state"] == "interrupted"


def test_a_state_is_of_one_moment(tmp_path: Path) -> None:
    """The lock is not asked again for a page that was read before."""
    file = calibration(tmp_path)
    work = tmp_path / "sand.grainfit"
    with run(file) as process:
        wait_for(lambda: state(work)["stop"]["possible"])
        reading = read_folder(work)
        process.kill()
        process.wait(60)
        found = state_of(reading, None)
    assert (found["state"], found["stop"]) == ("running", {"possible": True, "why": ""})


class QuickHeap(Lammps):
    """A heap of LAMMPS whose runs end at once."""

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
    ) -> dict[str, gf.Response]:
        """Return an angle."""
        del seed, workspace
        return {"angle_of_repose": gf.Response(15 + 20 * parameters[ROLLING])}


def test_before_the_first_results_the_page_has_the_estimate_and_says_what_it_is(
    tmp_path: Path,
) -> None:
    damped = ("particle_particle.rolling_damping", "particle_wall.rolling_damping")
    material = {**ROUGH_SPHERES, **dict.fromkeys(damped, 0.0)}
    fixed = {name: value for name, value in material.items() if name != ROLLING}
    heap = QuickHeap(gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE), fixed)
    problem = gf.Problem(
        [gf.Parameter(ROLLING, 0.05, 1.0)], [gf.Target("angle_of_repose", 25.0, uncertainty=1.0)]
    )
    details: list[str] = []

    def look(progress: gf.Progress) -> None:
        if not progress.evaluations or details:
            return
        following = follower.Follower(tmp_path)
        following.start()
        with following.watching():
            wait_for(lambda: len(now(following)["verdict"]["details"]) > 1)
            details.extend(now(following)["verdict"]["details"])
        following.end()
        raise KeyboardInterrupt

    gf.calibrate(problem, {"heap": heap}, workdir=tmp_path, on_progress=look)

    assert verdict_messages.TOO_FEW_RUNS.is_in(details[0])
    assert atlas_messages.NOT_SIMULATED.is_in(details[1])
    assert "no calibration" in details[1]
    assert details[2].startswith(f"{ROLLING}: ")
    # With a result there is none.
    assert not any(map(atlas_messages.NOT_SIMULATED.is_in, state(tmp_path)["verdict"]["details"]))
