"""Share a store between processes on one or several machines, so that each run is executed once.

A process claims a run before it starts it, and sends a heartbeat every few seconds. Other processes
that need the same run wait for it. A claim without heartbeat for long enough is taken over: its
owner has died. Nothing here depends on wall clocks, which differ between machines and can jump.

A server that goes away for a while ends no calibration. Until it is back nothing is found or
claimed, runs in progress go on, and their outcomes are kept to be sent.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from grainfit.campaign import messages
from grainfit.campaign.store.owner import earlier_owner, new_owner, note_owner
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import Claim, RunStore
from grainfit.errors import StoreError, StoreUnreachableError

#: Interval between tries to reach a server that is away, s.
_RETRY_SECONDS = 1.0
#: Longest wait for a thread that talks to a server, when the user has interrupted, s.
_HURRY_SECONDS = 3.0
_Answer = TypeVar("_Answer")


@dataclass(frozen=True)
class Timing:
    """Times after which processes that share a store give each other, or the server, up.

    Parameters
    ----------
    beat_seconds : float
        Interval of the heartbeats of an owner of claims, s.
    lease_seconds : float
        Time without a heartbeat after which a claim is taken over, s.
    patience_seconds : float
        Time for which a server that is away is tried again, s.
    """

    beat_seconds: float = 5.0
    lease_seconds: float = 60.0
    patience_seconds: float = 60.0


@dataclass(frozen=True)
class _Watch:
    """A claim of another process, and how long it has been seen without a heartbeat."""

    claim: Claim
    silent: float
    looked: float


@dataclass(frozen=True)
class _Outage:
    """The time since which a store cannot be reached, and why."""

    error: StoreUnreachableError
    since: float


@contextmanager
def share(
    address: str, folder: Path | None, own: RunStore, timing: Timing | None = None
) -> Iterator[SharedRuns]:
    """Open a shared store, and copy the finished runs of a work folder to it, without its own.

    Parameters
    ----------
    address : str
        URL of the database.
    folder : Path or None
        The work folder, locked by this process.
    own : RunStore
        The store of the work folder.
    timing : Timing, optional
        Times after which others, or the server, are given up.
    """
    store = _twice(lambda: RunStore(address))
    owner = new_owner(folder)
    try:
        with SharedRuns(store, owner, timing) as shared:
            if folder is not None:
                earlier = earlier_owner(folder)
                if earlier is not None:
                    shared.patiently(lambda store: store.release(earlier))
                note_owner(folder, owner)
            # Runs at other scales, taken from there, would be there at every scale.
            shared.give(run for run in own.runs("finished") if run.origin != shared.place)
            yield shared
    finally:
        store.close()


class SharedRuns:
    """Runs exchanged with other processes through a shared store.

    While the store cannot be reached, nothing is found and nothing can be claimed; when it cannot
    be reached for too long, every method but `cancel` and `close` raises the `StoreError`.

    Parameters
    ----------
    store : RunStore
        The shared store.
    owner : str
        Name of this process, which no other process has.
    timing : Timing, optional
        Times after which others, or the server, are given up.
    """

    def __init__(self, store: RunStore, owner: str, timing: Timing | None = None) -> None:
        self.store = store
        self._owner = owner
        self._timing = timing or Timing()
        self._seen: dict[str, _Watch] = {}
        #: Held by the thread that asks the store; those that wait for it learn of an outage.
        self._turn = threading.Lock()
        self._changing = threading.Lock()
        self._outage: _Outage | None = None
        self._unsent: deque[Callable[[], object]] = deque()
        self._notices: list[str] = []
        self._wake = threading.Event()
        self._ended = self._cancelled = False
        self._pulse = threading.Thread(target=self._keep_in_touch, name="pulse", daemon=True)
        self._pulse.start()

    def __enter__(self) -> SharedRuns:
        return self

    def __exit__(self, *_raised: object) -> None:
        self.close()

    @property
    def place(self) -> str:
        """Location of the shared store."""
        return self.store.place

    @property
    def notices(self) -> tuple[str, ...]:
        """Notices for the user, in the order of their events."""
        return tuple(self._notices)

    def patiently(self, use: Callable[[RunStore], _Answer]) -> _Answer:
        """Use the store in a way that may be repeated, and wait while it cannot be reached."""
        while True:
            answer = self._ask(lambda: (use(self.store),))
            if answer is not None:
                return answer[0]
            time.sleep(_RETRY_SECONDS / 10)

    def find(self, identities: Iterable[str]) -> dict[str, RunRecord]:
        """Return the runs of these identities that have ended, by identity."""
        wanted = list(identities)
        found = self._ask(lambda: self.store.find_many(wanted)) or {}
        return {
            identity: replace(record, origin=record.origin or self.place)
            for identity, record in found.items()
            if record.status != "running"
        }

    def claim(self, record: RunRecord) -> bool | None:
        """Claim a run.

        Returns
        -------
        bool or None
            True if this process is to execute it, also if it does already; None while the store
            cannot be reached.
        """
        return self._ask(lambda: self.store.claim(record, self._owner))

    def take_over(self, record: RunRecord) -> bool | None:
        """Claim a run whose owner has died or has released it; the answers are those of `claim`."""
        return self._ask(lambda: self._take_over(record))

    def _take_over(self, record: RunRecord) -> bool:
        claim = self.store.claims([record.identity]).get(record.identity)
        if claim is None or claim.owner == self._owner:
            return self.store.claim(record, self._owner)
        now = time.monotonic()
        seen = self._seen.get(record.identity)
        if seen is None or seen.claim != claim:
            self._seen[record.identity] = _Watch(claim, 0.0, now)
            return False
        # While this process is suspended, or the server is away, the owner cannot be heard.
        silent = seen.silent + min(now - seen.looked, self._timing.beat_seconds)
        self._seen[record.identity] = _Watch(claim, silent, now)
        if silent < self._timing.lease_seconds:
            return False
        return self.store.claim(record, self._owner, instead_of=claim)

    def save(self, record: RunRecord) -> bool:
        """Store the outcome of a run for all processes, now or when the store is back.

        Returns
        -------
        bool
            False if another process has taken the run over, and this outcome does not count there.
        """
        return self._send(lambda: self.store.save_outcome(record, self._owner))

    def give(self, records: Iterable[RunRecord]) -> None:
        """Copy runs that the shared store does not have yet."""
        given = list(records)
        self._send(lambda: self.store.add_missing(given))

    def forget(self, identity: str) -> None:
        """Let a run that has ended be repeated."""
        self._send(lambda: self.store.forget_ended(identity))

    def forget_failed(self, identities: Collection[str]) -> None:
        """Let the failed ones of these runs be repeated."""
        self._send(lambda: self.store.forget_failed(identities))

    def cancel(self) -> None:
        """Wait no longer for a server that does not answer: the user has interrupted."""
        self._cancelled = True
        self.store.hurry()

    def close(self) -> None:
        """Stop the heartbeat, and release the claims of unfinished runs."""
        while self._unsent and self._outage and not self._cancelled and self._has_patience():
            time.sleep(_RETRY_SECONDS / 10)
        self._ended = True
        self._wake.set()
        self._pulse.join(_HURRY_SECONDS if self._cancelled else None)
        # Without the database, others take the claims over when the heartbeat is missing, and the
        # next start in this work folder gives what was not sent.
        if self._outage is None and not self._pulse.is_alive():
            with suppress(StoreError):
                self._deliver()
                self.store.release(self._owner)

    # A server that goes away and comes back ----------------------------------------------------

    def _send(self, change: Callable[[], object]) -> bool:
        """Change the store, now or when it is back; return False if it refuses the change."""
        answer = self._ask(lambda: (change(),))
        if answer is None:
            self._unsent.append(change)
        return answer != (False,)

    def _ask(self, question: Callable[[], _Answer]) -> _Answer | None:
        """Return the answer of the store; None while it cannot be reached."""
        with self._turn:
            if self._outage is None:
                try:
                    return _twice(question, self._is_patient)
                except StoreUnreachableError as error:
                    self._note_outage(error)
            if not self._has_patience():
                raise self._given_up()
            return None

    def _is_patient(self) -> bool:
        return not self._cancelled

    def _has_patience(self) -> bool:
        outage = self._outage
        return outage is None or time.monotonic() - outage.since < self._timing.patience_seconds

    def _keep_in_touch(self) -> None:
        """Send heartbeats, and notice when a store that was away is back."""
        while True:
            self._wake.wait(_RETRY_SECONDS if self._outage else self._timing.beat_seconds)
            self._wake.clear()
            if self._ended:
                return
            try:
                _twice(lambda: self.store.beat(self._owner), self._is_patient)
                self._deliver()
            except StoreUnreachableError as error:
                self._note_outage(error)
            except StoreError:
                # If this does not pass, the next run that ends reports it.
                continue
            else:
                self._note_return()

    def _deliver(self) -> None:
        while self._unsent:
            self._unsent[0]()
            self._unsent.popleft()

    def _note_outage(self, error: StoreUnreachableError) -> None:
        with self._changing:
            if self._outage is not None:
                return
            self._outage = _Outage(error, time.monotonic())
            patience = self._timing.patience_seconds
            self._notices.append(
                f"The store {self.place} cannot be reached. It is tried again for {patience:g} s; "
                "runs in progress go on."
            )
        self._wake.set()

    def _note_return(self) -> None:
        with self._changing:
            if self._outage is not None:
                away = time.monotonic() - self._outage.since
                self._outage = None
                self._notices.append(messages.STORE_BACK(store=self.place, seconds=away))

    def _given_up(self) -> StoreError:
        error = self._outage.error if self._outage else ""
        patience = self._timing.patience_seconds
        return StoreError(messages.STORE_AWAY(reason=error, seconds=patience))


def _twice(
    question: Callable[[], _Answer], is_patient: Callable[[], bool] = lambda: True
) -> _Answer:
    """Ask again over a new connection if one was cut: everything here may be repeated."""
    try:
        return question()
    except StoreUnreachableError:
        if not is_patient():
            raise
        return question()
