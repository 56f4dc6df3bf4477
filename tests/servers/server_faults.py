"""Restart the server of a shared store, and cut connections to it, during calibrations."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from grainfit.campaign.store.store import RunStore
from tests.crash.crash_harness import Ending, Faults, Progress, Tally, Trial, Variant
from tests.servers.postgresql_server import PostgresqlServer, postgresql_server, program
from tests.servers.tcp_forwarder import tcp_forwarder

#: A fault of the server; returns whether it hit a calibration.
_Fault = Callable[[], bool]


def restart_servers(times: int, folder: Path, seed: int, progress: Progress) -> Tally:
    """Restart the server at any moment, in good order or as after a crash.

    Raises
    ------
    FileNotFoundError
        PostgreSQL is not installed.
    """
    with _server() as server:
        faults = Faults(Variant("server restarted"), times, folder, seed, progress)

        def restart() -> bool:
            server.stop("immediate" if faults.chance.random() < 0.5 else "fast")
            time.sleep(faults.chance.random())
            server.start()
            return True

        return _disturb(faults, server, server.url, restart)


def cut_connections(times: int, folder: Path, seed: int, progress: Progress) -> Tally:
    """Cut the connections to the server at any moment: by the server, or on their way."""
    with _server() as server, tcp_forwarder(server.port) as forwarder:
        faults = Faults(Variant("connection cut"), times, folder, seed, progress)

        def cut() -> bool:
            by_server = faults.chance.random() < 0.5
            return (server.cut_connections() if by_server else forwarder.cut()) > 0

        return _disturb(faults, server, server.url_at(forwarder.port), cut)


def _is_refused(ending: Ending) -> bool:
    """Return whether a calibration ended at once because the server was away at its start."""
    return ending.error == "StoreUnreachableError" and "connection failed" in ending.message


@contextmanager
def _server() -> Iterator[PostgresqlServer]:
    if program("initdb") is None:
        raise FileNotFoundError("PostgreSQL is not installed: apt-get install postgresql")
    with postgresql_server() as server:
        yield server


def _disturb(faults: Faults, server: PostgresqlServer, url: str, fault: _Fault) -> Tally:
    """Calibrate, with faults at random moments, until there were enough of them."""
    for trial in faults.trials():
        next_one = [time.monotonic() + faults.seconds()]

        def meanwhile(next_one: list[float] = next_one) -> None:
            if faults.enough or time.monotonic() < next_one[0]:
                return
            if fault():
                faults.count()
            next_one[0] = time.monotonic() + faults.seconds()

        ending = trial.wait(trial.start(store=url), meanwhile)
        while _is_refused(ending):
            trial.complain(not trial.starts(), ending.message)
            ending = trial.wait(trial.start(store=url), meanwhile)
        faults.judge(trial, ending)
        faults.complain_about_repeats(trial, {})
        _compare_and_empty(server, trial, faults.tally)
    return faults.tally


def _compare_and_empty(server: PostgresqlServer, trial: Trial, tally: Tally) -> None:
    """Complain about runs that did not reach the shared store, and empty it for the next one."""
    shared, own = RunStore(server.url), RunStore.read_only(trial.work)
    states = shared.states()
    missing = [identity for identity in own.identities() if states.get(identity) != "finished"]
    tally.lost += [f"not in the shared store: {identity}" for identity in missing]
    trial.complain("running" not in states.values(), "a claim was left in the shared store")
    for identity in states:
        shared.forget(identity)
    shared.close()
    own.close()
