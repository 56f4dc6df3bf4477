"""Follow a work folder: read it when something in it has changed, and tell who waits for it."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from grainfit.calibration.live_file import LIVE_NAME
from grainfit.calibration.so_far import result_so_far
from grainfit.campaign.folder_lock import holder, is_held, last_heartbeat
from grainfit.campaign.store.store import STORE_NAME
from grainfit.campaign.work_folder import RESULT_NAME
from grainfit.errors import error_in_words
from grainfit.formatting import plain
from grainfit.one_thread import one_thread
from grainfit.report.page import REPORT_NAME
from grainfit.report.rendering import script_json
from grainfit.result import Result
from grainfit.watch.drawings import LatestDrawings
from grainfit.watch.state import Reading, read_folder, state_of
from grainfit.work_folder.estimate import estimate_of_running

_LOOK_SECONDS = 1.0
#: What is read takes at most this share of a core, and what is computed as much.
_SHARE = 0.1
#: Time without a heartbeat after which a process of another machine counts as dead, s.
_SILENT_SECONDS = 20.0
_LONGEST_READ_SECONDS = 30.0
#: Number of marks that tell who uses the folder.
_USES = 2
_WATCHED = (STORE_NAME, f"{STORE_NAME}-wal", LIVE_NAME, RESULT_NAME, REPORT_NAME, "runs")


class Follower:
    """The latest state of a work folder, read by a thread of its own.

    Runs are read when they change; metamodels and particles only while somebody watches, by
    another thread: they take seconds, in which the calibration may end.

    Parameters
    ----------
    folder : Path
        The work folder.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._changed = threading.Condition()
        self._version = 0
        self._state: dict[str, Any] = {}
        self._watchers = 0
        self._ending, self._ended = threading.Event(), threading.Event()
        self._drawings = LatestDrawings()
        self._so_far: tuple[object, Result | None] = (None, None)
        #: Calibration and what the atlas expects of it.
        self._estimate: tuple[str, tuple[str, ...]] = ("", ())
        self._fault = ""
        self._heartbeat: tuple[int | None, float] = (None, float("-inf"))
        self._reading = Reading(folder)
        self._publishing = threading.Lock()
        #: Set when there may be something to compute, for somebody who watches.
        self._asked = threading.Event()
        #: Whether something was read since metamodels and particles were.
        self._is_stale = True
        self._threads = [
            threading.Thread(target=work, name=f"follower {name}", daemon=True)
            for name, work in (("looks", self._follow), ("computes", self._compute_when_asked))
        ]

    def start(self) -> None:
        """Read the folder once, and follow it from then on."""
        self._read()
        for thread in self._threads:
            thread.start()

    def end(self) -> None:
        """Read the folder for the last time, and let all who wait for changes go."""
        self._ending.set()
        self._asked.set()
        looking, computing = self._threads
        looking.join(_LONGEST_READ_SECONDS)
        self._read()
        computing.join(_LONGEST_READ_SECONDS)
        self._ended.set()
        with self._changed:
            self._version += 1
            self._changed.notify_all()

    @property
    def has_ended(self) -> bool:
        """Whether nothing is read any more."""
        return self._ended.is_set()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Count somebody who watches until the end of the block."""
        with self._changed:
            self._watchers += 1
        self._asked.set()
        try:
            yield
        finally:
            with self._changed:
                self._watchers -= 1

    @property
    def watchers(self) -> int:
        """Number of those who watch."""
        return self._watchers

    def wait(self, seen: int, seconds: float) -> tuple[int, str]:
        """Wait for a state that is newer than the one seen.

        Parameters
        ----------
        seen : int
            Number of that state; 0 for none.
        seconds : float
            Longest wait.

        Returns
        -------
        number, state : int and str
            The latest state as JSON, with the time at which it is given; the same number when
            nothing has changed.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._version > seen, seconds)
            state = self._state | {"now": time.time(), "ended": self.has_ended}
            return self._version, str(script_json(state))

    def drawing(self, key: str) -> str | None:
        """Return the data of the newest drawing of a test as JSON."""
        found = self._drawings.found(_calibration(self._reading)).get(key)
        return None if found is None else found.content

    def _follow(self) -> None:
        before: object = None
        rest_until = 0.0
        while not self._ending.is_set():
            begun = time.monotonic()
            marks = self._marks()
            # A large store is read seldom, but an end or a start is seen at once.
            is_other = any(marks[:_USES]) != self._reading.is_running
            if marks != before and (is_other or begun >= rest_until):
                before = marks
                self._read()
                rest_until = _rest_until(begun)
            self._ending.wait(_LOOK_SECONDS)

    def _marks(self) -> list[object]:
        """Return what differs when something in the folder has changed: first, who uses it."""
        found: list[object] = [is_held(self._folder), self._is_alive_elsewhere()]
        for name in _WATCHED:
            try:
                status = (self._folder / name).stat()
                found.append((status.st_ino, status.st_mtime_ns, status.st_size))
            except OSError:
                found.append(None)
        return found

    def _is_alive_elsewhere(self) -> bool:
        """Return whether a process of another machine was heard of lately.

        Its heartbeat counts when it changes, whatever the clocks of both machines say.
        """
        signature, beat = holder(self._folder), last_heartbeat(self._folder)
        last, when = self._heartbeat
        if beat != last:
            first = last is None
            self._heartbeat = (beat, float("-inf") if first else time.monotonic())
            when = self._heartbeat[1]
        if not signature.process or signature.is_of_this_machine():
            return False
        return time.monotonic() - when < _SILENT_SECONDS

    def _read(self) -> None:
        try:
            reading = read_folder(self._folder, is_alive_elsewhere=self._is_alive_elsewhere())
        except Exception as error:
            reading = self._faulty(error)
        if reading.saved is None:
            # The same calibration may begin again in a folder that was deleted.
            self._drawings, self._so_far = LatestDrawings(), (None, None)
        self._publish(reading)
        self._is_stale = True
        self._asked.set()

    def _faulty(self, error: Exception) -> Reading:
        """Return what says why nothing is shown, which an empty page would hide."""
        return Reading(self._folder, fault=error_in_words(error))

    def _compute_when_asked(self) -> None:
        while True:
            self._asked.wait()
            self._asked.clear()
            if self._ending.is_set():
                return
            if self._watchers and self._is_stale:
                begun = time.monotonic()
                self._is_stale = False
                self._compute(self._reading)
                self._ending.wait(_rest_until(begun) - time.monotonic())

    def _compute(self, reading: Reading) -> None:
        self._fault = ""
        try:
            self._compute_estimate(reading)
            self._compute_so_far(reading)
            if reading.saved is not None:
                self._drawings.update(reading.saved)
        except Exception as error:
            # The rest of the page is right nevertheless.
            self._fault = f"Verdict or particles cannot be shown: {error_in_words(error)}"
        self._publish()

    def _compute_estimate(self, reading: Reading) -> None:
        """Estimate the parameters once, before the first results, and show them at once."""
        identity = _calibration(reading)
        if not reading.is_running or identity == self._estimate[0] or not reading.requests:
            return
        self._estimate = (identity, ())
        found = estimate_of_running(self._folder)
        self._estimate = (identity, () if found is None else tuple(found.lines()))
        self._publish()

    def _compute_so_far(self, reading: Reading) -> None:
        saved = reading.saved
        if saved is None or (saved.result is not None and saved.result.parameters):
            return
        known = _known(reading)
        if known == self._so_far[0]:
            return
        # Tried once, whether it succeeds or not.
        self._so_far = (known, None)
        with one_thread():
            found = result_so_far(
                saved.problem,
                saved.evaluations,
                saved.warm_start,
                options=saved.strategy_options,
                seed=saved.seed,
                repetitions=reading.live.repetitions if reading.live else None,
            )
        self._so_far = (known, found)

    def _publish(self, newer: Reading | None = None) -> None:
        """Tell the state of a newer reading, or what was computed since with that of the newest."""
        with self._publishing:
            self._reading = newer or self._reading
            try:
                state = self._state_of(self._reading)
            except Exception as error:
                self._reading = self._faulty(error)
                state = self._state_of(self._reading)
            with self._changed:
                if json.dumps(state) != json.dumps(self._state):
                    self._state = state
                    self._version += 1
                    self._changed.notify_all()

    def _state_of(self, reading: Reading) -> dict[str, Any]:
        so_far = self._so_far[1] if _calibration(reading) == _of(self._so_far[0]) else None
        identity, lines = self._estimate
        estimate = lines if _calibration(reading) == identity else ()
        state = state_of(reading, so_far, estimate)
        if self._fault:
            state["notices"] = [*state["notices"], plain(self._fault)]
        drawings = self._drawings.found(_calibration(reading))
        state["drawings"] = [one.about for one in drawings.values()]
        return state


def _rest_until(begun: float) -> float:
    """Return the time until which work that was begun then, and ends now, takes its share."""
    return begun + (time.monotonic() - begun) / _SHARE


def _known(reading: Reading) -> object:
    saved = reading.saved
    return (_calibration(reading), len(saved.evaluations) if saved else 0)


def _calibration(reading: Reading) -> str:
    return reading.saved.identity if reading.saved else ""


def _of(known: object) -> object:
    return known[0] if isinstance(known, tuple) else None
