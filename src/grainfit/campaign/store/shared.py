"""Share a store between processes on one or several machines, so that each run is executed once.

A process claims a run before it starts it, and sends a heartbeat every few seconds. Other processes
that need the same run wait for it. A claim without heartbeat for long enough is taken over: its
owner has died. Nothing here depends on wall clocks, which differ between machines and can jump.
"""

from __future__ import annotations

import socket
import threading
import time
import uuid
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import Claim, RunStore
from grainfit.errors import StoreError

#: Interval of the heartbeats of an owner, and time without one after which it counts as dead, s.
BEAT_SECONDS = 5.0
LEASE_SECONDS = 60.0


@contextmanager
def share(address: str, folder: Path | None, own: RunStore) -> Iterator[SharedRuns]:
    """Open a shared store, and copy the finished runs of a work folder to it.

    Parameters
    ----------
    address : str
        URL of the database.
    folder : Path or None
        The work folder, locked by this process.
    own : RunStore
        The store of the work folder.
    """
    store = RunStore(address)
    # With the same name after a crash, the claims of the dead process are released immediately.
    owner = f"{socket.gethostname()}:{folder}" if folder else f"{uuid.uuid4()}"
    shared = SharedRuns(store, owner)
    try:
        shared.give(own.runs("finished"))
        yield shared
    finally:
        shared.close()
        store.close()


class SharedRuns:
    """Runs exchanged with other processes through a shared store.

    Parameters
    ----------
    store : RunStore
        The shared store.
    owner : str
        Name of this process; the same after a crash, so that its old claims are released.
    beat_seconds, lease_seconds : float
        Interval of the heartbeats, and time without one after which a claim is taken over.
    """

    def __init__(
        self,
        store: RunStore,
        owner: str,
        beat_seconds: float = BEAT_SECONDS,
        lease_seconds: float = LEASE_SECONDS,
    ) -> None:
        self.store = store
        self._owner = owner
        self._beat_seconds = beat_seconds
        self._lease_seconds = lease_seconds
        self._seen: dict[str, tuple[Claim, float]] = {}
        self._ended = threading.Event()
        store.release(owner)
        self._pulse = threading.Thread(target=self._show_life, name="pulse", daemon=True)
        self._pulse.start()

    @property
    def place(self) -> str:
        """Location of the shared store."""
        return self.store.place

    def find(self, identities: Iterable[str]) -> dict[str, RunRecord]:
        """Return the runs of these identities that have ended, by identity."""
        found = self.store.find_many(list(identities))
        return {
            identity: replace(record, origin=record.origin or self.place)
            for identity, record in found.items()
            if record.status != "running"
        }

    def claim(self, record: RunRecord) -> bool:
        """Claim a run; return True if this process is to execute it."""
        return self.store.claim(record, self._owner)

    def take_over(self, record: RunRecord) -> bool:
        """Claim a run whose owner has died or has released it."""
        claim = self.store.claims([record.identity]).get(record.identity)
        if claim is None:
            return self.store.claim(record, self._owner)
        now = time.monotonic()
        seen, since = self._seen.setdefault(record.identity, (claim, now))
        if seen != claim:
            self._seen[record.identity] = (claim, now)
            return False
        if now - since < self._lease_seconds:
            return False
        return self.store.claim(record, self._owner, instead_of=claim)

    def save(self, record: RunRecord) -> None:
        """Store the outcome of a run for all processes."""
        self.store.save(record)

    def give(self, records: Iterable[RunRecord]) -> None:
        """Copy runs that the shared store does not have yet."""
        wanted = {record.identity: record for record in records}
        there = self.store.find_many(list(wanted))
        self.store.save_many(r for identity, r in wanted.items() if identity not in there)

    def forget(self, identity: str) -> None:
        """Release a run, or let a failed one be repeated."""
        self.store.forget(identity)

    def forget_failed(self, identities: Collection[str]) -> None:
        """Let the failed ones of these runs be repeated."""
        self.store.forget_failed(identities)

    def close(self) -> None:
        """Stop the heartbeat, and release the claims of unfinished runs."""
        self._ended.set()
        self._pulse.join()
        # Without the database, others take the claims over when the heartbeat is missing.
        with suppress(StoreError):
            self.store.release(self._owner)

    def _show_life(self) -> None:
        while not self._ended.wait(self._beat_seconds):
            try:
                self.store.beat(self._owner)
            except StoreError:
                # If the database stays unreachable, the next run that ends reports it.
                continue
