"""Shared stores whose server restarts, hangs or cuts connections, and suspended owners."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Literal

import pytest
import sqlalchemy as sql

import grainfit as gf
from grainfit.calibration import calibrate as calibration
from grainfit.calibration.progress import Progress
from grainfit.campaign import messages
from grainfit.campaign.campaign import Campaign
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.shared import Timing, share
from grainfit.campaign.store.store import RunStore
from grainfit.errors import RunFailedError, StoreError, StoreUnreachableError
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.run_definition import RunDefinition
from grainfit.solvers.own_model.python_callable import PythonCallable
from tests.servers.postgresql_server import PostgresqlServer
from tests.servers.tcp_forwarder import TcpForwarder, tcp_forwarder

FORK = multiprocessing.get_context("fork")
PROBLEM = gf.Problem(
    [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 33.0, tolerance=0.5)]
)
BUDGET = 9
#: A test that has not come this far has failed, s.
PATIENCE = 600.0


@pytest.fixture
def forwarder(server: PostgresqlServer) -> Iterator[TcpForwarder]:
    with tcp_forwarder(server.port) as forwarder:
        yield forwarder


@pytest.fixture
def soon_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    """A server that does not answer is given up soon."""
    monkeypatch.setattr("grainfit.campaign.store.postgresql.SILENCE_SECONDS", 1.0)
    monkeypatch.setattr("grainfit.campaign.store.postgresql.CONNECT_SECONDS", 2)


def drum(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"angle": 20 + 25 * parameters["friction"] + seed % 101 / 500}


def wait_for(condition: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@cache
def undisturbed() -> gf.Result:
    solver = PythonCallable(drum, identity="drum in peace")
    return gf.calibrate(PROBLEM, solver, max_runs=BUDGET)


class Disturbed:
    """A calibration of which every third run does something to the server.

    Parameters
    ----------
    disturb : callable
        Called in the third run, the sixth and so on.
    repair : callable, optional
        Called once, when the calibration has said that it cannot reach the server.
    """

    def __init__(
        self, disturb: Callable[[], object], repair: Callable[[], object] = lambda: None
    ) -> None:
        self.seeds: list[int] = []
        self.notices: tuple[str, ...] = ()
        self._disturb = disturb
        self._repair = repair

    def calibrate(self, folder: Path, store: str) -> gf.Result:
        solver = PythonCallable(self._simulate, identity="drum of a store in trouble")
        return gf.calibrate(
            PROBLEM, solver, workdir=folder, store=store, on_progress=self._note, max_runs=BUDGET
        )

    def _note(self, progress: Progress) -> None:
        if progress.notices and not self.notices:
            self._repair()
        self.notices = progress.notices

    def _simulate(self, parameters: dict[str, float], seed: int) -> dict[str, float]:
        self.seeds.append(seed)
        if len(self.seeds) % 3 == 0:
            self._disturb()
        return drum(parameters, seed)

    def assert_nothing_happened(self, result: gf.Result, folder: Path, store: str) -> None:
        """Everything was simulated once, is in both stores, and is what it is without trouble."""
        quiet = undisturbed()
        assert result.parameters == quiet.parameters
        assert len(self.seeds) == len(set(self.seeds)) == result.runs.total == quiet.runs.total > 5
        own, shared = RunStore.read_only(folder), RunStore(store)
        assert own.states() == shared.states()
        assert set(own.states().values()) == {"finished"}
        assert len(own.states()) == quiet.runs.total
        own.close()
        shared.close()


def test_the_server_of_the_tests_keeps_what_it_has_and_wants_a_password(
    server: PostgresqlServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = RunStore(server.url)
    with store._reading() as connection:
        shown = [connection.exec_driver_sql(f"SHOW {name}").scalar() for name in ("fsync", "port")]
    assert shown == ["on", str(server.port)]
    store.close()
    monkeypatch.setenv("PGPASSFILE", "/dev/null")
    with pytest.raises(StoreError, match="no password supplied"):
        RunStore(server.url)
    wrong = server.url.replace("@", ":wrong@")
    with pytest.raises(StoreError, match="password authentication failed") as caught:
        RunStore(wrong)
    assert ":wrong" not in str(caught.value)


@pytest.mark.parametrize("how", ["terminated", "reset"])
def test_cut_connections_are_made_again_without_a_word(
    how: str, server: PostgresqlServer, forwarder: TcpForwarder, tmp_path: Path
) -> None:
    cut = server.cut_connections if how == "terminated" else forwarder.cut
    disturbed = Disturbed(cut)
    store = server.url_at(forwarder.port)
    result = disturbed.calibrate(tmp_path / "work", store)
    disturbed.assert_nothing_happened(result, tmp_path / "work", server.url)
    assert disturbed.notices == ()


@pytest.mark.parametrize("mode", ["fast", "immediate"])
def test_a_restart_of_the_server_ends_no_calibration(
    mode: Literal["fast", "immediate"], server: PostgresqlServer, tmp_path: Path
) -> None:
    starting = threading.Timer(2.0, server.start)

    def stop_once() -> None:
        if len(disturbed.seeds) == 3:
            server.stop(mode)

    disturbed = Disturbed(stop_once, starting.start)
    result = disturbed.calibrate(tmp_path / "work", server.url)
    starting.join()
    disturbed.assert_nothing_happened(result, tmp_path / "work", server.url)
    lost, back = disturbed.notices
    assert "cannot be reached. It is tried again for 60 s" in lost
    assert messages.STORE_BACK.is_in(back)


def test_a_server_that_stays_away_costs_nothing_that_is_finished(
    server: PostgresqlServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(calibration, "share", partial(share, timing=Timing(patience_seconds=2.0)))

    def stop_once() -> None:
        if len(disturbed.seeds) == 3:
            server.stop()

    disturbed = Disturbed(stop_once)
    try:
        with pytest.raises(StoreError, match=messages.CHECK_SERVER.pattern) as caught:
            disturbed.calibrate(tmp_path, server.url)
    finally:
        server.start()
    assert messages.STORE_AWAY.is_in(str(caught.value))
    assert messages.STORE_AWAY.is_in(str(caught.value), seconds=2)
    assert len(disturbed.seeds) == 3
    own = RunStore.read_only(tmp_path)
    assert len(own.runs("finished")) == 3
    own.close()
    result = disturbed.calibrate(tmp_path, server.url)
    disturbed.assert_nothing_happened(result, tmp_path, server.url)


def test_a_server_that_hangs_for_a_while_ends_no_calibration(
    server: PostgresqlServer, forwarder: TcpForwarder, tmp_path: Path, soon_silent: None
) -> None:

    def swallow(swallows: bool) -> None:
        forwarder.swallows = swallows and len(disturbed.seeds) == 3

    disturbed = Disturbed(lambda: swallow(True), lambda: swallow(False))
    result = disturbed.calibrate(tmp_path / "work", server.url_at(forwarder.port))
    disturbed.assert_nothing_happened(result, tmp_path / "work", server.url)
    assert len(disturbed.notices) == 2


@pytest.mark.slow
def test_a_server_that_hangs_for_good_ends_a_calibration_in_a_message(
    server: PostgresqlServer,
    forwarder: TcpForwarder,
    tmp_path: Path,
    soon_silent: None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(calibration, "share", partial(share, timing=Timing(patience_seconds=1.0)))
    disturbed = Disturbed(lambda: setattr(forwarder, "swallows", True))
    with pytest.raises(StoreError, match=messages.STORE_AWAY.pattern):
        disturbed.calibrate(tmp_path / "work", server.url_at(forwarder.port))
    assert len(disturbed.seeds) == 3
    with pytest.raises(StoreError, match="timeout"):
        RunStore(server.url_at(forwarder.port))


FILE = """
name = "drum"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
type = "command"
folder = "model"
command = ["./simulate.sh", "{{ friction }}"]
targets.angle = { value = 27, uncertainty = 0.5 }
"""
PROGRAM = """\
#!/bin/sh
echo started >> "$STARTED"
sleep 600
"""


def test_ctrl_c_ends_a_calibration_whose_server_hangs(
    server: PostgresqlServer, forwarder: TcpForwarder, tmp_path: Path
) -> None:
    (tmp_path / "model").mkdir()
    program = tmp_path / "model" / "simulate.sh"
    program.write_text(PROGRAM)
    program.chmod(0o755)
    (tmp_path / "drum.toml").write_text(FILE)
    started = tmp_path / "started"
    process = subprocess.Popen(
        [sys.executable, "-m", "grainfit", "run", "drum.toml", "--no-report"],
        cwd=tmp_path,
        env={
            **os.environ,
            "STARTED": str(started),
            "GRAINFIT_STORE": server.url_at(forwarder.port),
        },
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        # As in a terminal, whatever the tests were started with.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        wait_for(lambda: started.exists() or process.poll() is not None)
        forwarder.swallows = True
        process.send_signal(signal.SIGINT)
        # A few seconds, unless the machine is busy: the server is asked to release the claims.
        output, _ = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 130, output
    assert "Traceback" not in output


# Owners ------------------------------------------------------------------------------------------


@pytest.fixture(params=["sqlite", "postgresql"])
def address(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'shared.sqlite'}"
    return str(request.getfixturevalue("server").url)


def evaluate(
    simulate: Callable[[dict[str, float], int], dict[str, float]], address: str, own: RunStore
) -> Evaluation:
    """Ask for one run, which a process that shows no life when it is looked at five times loses."""
    timing = Timing(beat_seconds=0.2, lease_seconds=1.0)
    with share(address, None, own, timing) as shared:
        solver = PythonCallable(simulate, identity="one run of two")
        campaign = Campaign({"drum": solver}, own, None, shared=shared)
        campaign.start(Proposal({"friction": 0.5}, 1, "design"))
        evaluations: list[Evaluation] = []
        while not evaluations:
            evaluations = campaign.wait()
        campaign.close()
    return evaluations[0]


@pytest.mark.usefixtures("soon_silent")
def test_an_interrupt_is_not_lost_when_its_transaction_cannot_be_rolled_back(
    server: PostgresqlServer, forwarder: TcpForwarder
) -> None:
    def interrupt(_connection: object, _name: str) -> None:
        forwarder.swallows = True
        raise KeyboardInterrupt

    store = RunStore(server.url_at(forwarder.port))
    record = RunRecord("interrupted", "drum", "running", RunDefinition({}, {}, 1))
    sql.event.listen(sql.Engine, "savepoint", interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            store.claim(record, "somebody")
    finally:
        sql.event.remove(sql.Engine, "savepoint", interrupt)
    # What is done after an interrupt fails by its own cause.
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt:
        with pytest.raises(StoreUnreachableError):
            store.claim(record, "somebody")
    store.close()


@pytest.mark.parametrize("end", ["finished", "failed"])
def test_an_owner_that_was_suspended_beyond_its_lease_overwrites_nothing(
    end: str, address: str, tmp_path: Path
) -> None:
    claimed, go_on, seen = (tmp_path / name for name in ("claimed", "go_on", "seen"))

    def slow(_parameters: dict[str, float], _seed: int) -> dict[str, float]:
        claimed.touch()
        wait_for(go_on.exists)
        if end == "failed":
            # As of a solver whose time-out passed in the meantime.
            raise RunFailedError("longer than its time-out", kind="timeout")
        return {"angle": 1.0}

    def suspended() -> None:
        own = RunStore.in_folder(tmp_path)
        evaluation = evaluate(slow, address, own)
        assert own.states() == dict.fromkeys(evaluation.runs.values(), "finished")
        seen.write_text(f"{evaluation.responses['angle'].value}")

    process = FORK.Process(target=suspended)
    process.start()
    assert process.pid is not None
    wait_for(claimed.exists)
    os.kill(process.pid, signal.SIGSTOP)
    try:
        other = RunStore.in_memory()
        evaluation = evaluate(lambda _parameters, _seed: {"angle": 2.0}, address, other)
    finally:
        os.kill(process.pid, signal.SIGCONT)
    assert evaluation.responses == {"angle": Response(2.0)}
    go_on.touch()
    process.join(PATIENCE)
    assert process.exitcode == 0
    # Its own finished run is as true as that of the other; a failure is not.
    assert seen.read_text() == ("1.0" if end == "finished" else "2.0")
    shared = RunStore(address)
    (run,) = shared.runs()
    assert (run.status, run.responses) == ("finished", {"angle": Response(2.0)})
    shared.close()


def test_a_process_suspended_in_a_transaction_keeps_nobody_waiting(
    server: PostgresqlServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grainfit.campaign.store.postgresql._IDLE_SECONDS", 1)
    record = RunRecord("a", "drum", "running", RunDefinition({}, {}, 1))
    first, second = RunStore(server.url), RunStore(server.url)
    assert first.claim(record, "first")
    (claim,) = first.claims(["a"]).values()

    def beat_while_another_waits() -> None:
        with first._transaction() as connection:
            connection.exec_driver_sql("UPDATE runs SET beat = beat + 1")
            assert second.claim(record, "second", instead_of=claim)
            connection.exec_driver_sql("SELECT 1")

    with pytest.raises(StoreUnreachableError):
        beat_while_another_waits()
    assert first.claims(["a"])["a"].owner == "second"
    first.close()
    second.close()


def test_a_process_started_again_goes_on_at_once_and_a_copy_of_its_folder_does_not(
    address: str, tmp_path: Path
) -> None:
    work, copy = tmp_path / "work", tmp_path / "copy"
    work.mkdir()
    record = RunRecord("a", "drum", "running", RunDefinition({}, {}, 1))
    own = RunStore.in_memory()

    def claim_and_die() -> None:
        with share(address, work, RunStore.in_memory()) as shared:
            assert shared.claim(record)
            os.kill(os.getpid(), signal.SIGKILL)

    process = FORK.Process(target=claim_and_die)
    process.start()
    process.join(PATIENCE)
    assert process.exitcode == -signal.SIGKILL
    subprocess.run(["cp", "-a", work, copy], check=True)
    with share(address, copy, own) as shared:
        assert shared.claim(record) is False
    with share(address, work, own) as shared:
        assert shared.claim(record) is True
        # While it runs, so does everything else that has its name.
        subprocess.run(["cp", "-a", work / "owner", copy], check=True)
        with share(address, copy, own) as other:
            assert other.claim(record) is False
    own.close()
