"""Restart the server of a shared store, and cut connections to it, during calibrations."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from grainfit.campaign.store.store import RunStore
from grainfit.testing.crash_harness import Ending, Progress, Tally, Trial, Variant, undisturbed
from grainfit.testing.postgresql_server import PostgresqlServer, postgresql_server, program
from grainfit.testing.tcp_forwarder import tcp_forwarder

#: A fault of the server; returns whether it hit a calibration.
_Fault = Callable[[], bool]


def restart_servers(
    times: int, folder: Path, seed: int = 1, progress: Progress | None = None
) -> Tally:
    """Restart the server at any moment, in good order or as after a crash.

    Parameters
    ----------
    times : int
        Number of faults.
    folder : Path
        Folder for the calibrations.
    seed : int
        Decides the moments.
    progress : callable, optional
        Called after each time.

    Raises
    ------
    FileNotFoundError
        PostgreSQL is not installed.
    """
    chance = random.Random(seed)
    with _server() as server:

        def restart() -> bool:
            server.stop("immediate" if chance.random() < 0.5 else "fast")
            time.sleep(chance.random())
            server.start()
            return True

        tally = Tally("server restarted")
        return _disturb(tally, times, folder, chance, server, server.url, restart, progress)


def cut_connections(
    times: int, folder: Path, seed: int = 1, progress: Progress | None = None
) -> Tally:
    """Cut the connections to the server at any moment: by the server, or on their way.

    The parameters and errors are those of `restart_servers`.
    """
    chance = random.Random(seed)
    with _server() as server, tcp_forwarder(server.port) as forwarder:

        def cut() -> bool:
            by_server = chance.random() < 0.5
            return (server.cut_connections() if by_server else forwarder.cut()) > 0

        tally, url = Tally("connection cut"), server.url_at(forwarder.port)
        return _disturb(tally, times, folder, chance, server, url, cut, progress)


def _is_refused(ending: Ending) -> bool:
    """Return whether a calibration ended at once because the server was away at its start."""
    return ending.error == "StoreUnreachableError" and "connection failed" in ending.message


@contextmanager
def _server() -> Iterator[PostgresqlServer]:
    if program("initdb") is None:
        raise FileNotFoundError("PostgreSQL is not installed: apt-get install postgresql")
    with postgresql_server() as server:
        yield server


def _disturb(
    tally: Tally,
    times: int,
    folder: Path,
    chance: random.Random,
    server: PostgresqlServer,
    url: str,
    fault: _Fault,
    progress: Progress | None,
) -> Tally:
    """Calibrate, with faults at random moments, until there were enough of them."""
    variant = Variant(tally.fault)
    reference, seconds = undisturbed(variant, folder / "undisturbed")
    number = 0
    while tally.injected < times:
        number += 1
        trial = Trial(variant, folder / str(number), tally)
        next_one = [time.monotonic() + seconds * chance.random()]

        def meanwhile(next_one: list[float] = next_one) -> None:
            if tally.injected == times or time.monotonic() < next_one[0]:
                return
            tally.injected += fault()
            next_one[0] = time.monotonic() + seconds * chance.random()
            if progress is not None:
                progress(tally)

        ending = trial.wait(trial.start(store=url), meanwhile)
        while _is_refused(ending):
            trial.complain(not trial.starts(), ending.message)
            ending = trial.wait(trial.start(store=url), meanwhile)
        trial.compare(ending, reference)
        trial.look(f"calibration {number}")
        starts = trial.starts().items()
        tally.repeated += [f"calibration {number}: {key}" for key, count in starts if count > 1]
        _compare_and_empty(server, trial, tally)
    return tally


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
