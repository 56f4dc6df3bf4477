"""A store that several processes share, on one machine or on many: each run is made by one of them.

Who is going to make a run claims it, and shows every few seconds that they live. Others who want
the same run wait for it. A claim that shows no life for long enough is taken over: its owner has
died. Nothing here depends on clocks, which differ between machines and jump.
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

#: How often an owner shows that it lives, and after how long without that it is given up, s.
BEAT_SECONDS = 5.0
LEASE_SECONDS = 60.0


@contextmanager
def share(address: str, folder: Path | None, own: RunStore) -> Iterator[SharedRuns]:
    """Open a shared store, and give it what a work folder has already.

    Parameters
    ----------
    address : str
        URL of the database.
    folder : Path or None
        The work folder, which is held by this process alone.
    own : RunStore
        The store of the work folder.
    """
    store = RunStore(address)
    # With the same name after a crash, what the dead process had claimed is free at once.
    owner = f"{socket.gethostname()}:{folder}" if folder else f"{uuid.uuid4()}"
    shared = SharedRuns(store, owner)
    try:
        shared.give(own.runs("finished"))
        yield shared
    finally:
        shared.close()
        store.close()


class SharedRuns:
    """Runs that this process makes for all, and finds that others have made.

    Parameters
    ----------
    store : RunStore
        The shared store.
    owner : str
        Who this is; the same again after a crash, so that what it left is released at once.
    beat_seconds, lease_seconds : float
        How often life is shown, and after how long without it a claim is taken over.
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
        """Where the shared store is."""
        return self.store.place

    def find(self, identities: Iterable[str]) -> dict[str, RunRecord]:
        """Return those of some runs that have ended, by identity."""
        found = self.store.find_many(list(identities))
        return {
            identity: replace(record, origin=record.origin or self.place)
            for identity, record in found.items()
            if record.status != "running"
        }

    def claim(self, record: RunRecord) -> bool:
        """Return whether the run is this process's to make now."""
        return self.store.claim(record, self._owner)

    def take_over(self, record: RunRecord) -> bool:
        """Claim a run whose maker has died, or has given it back."""
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
        """Give all what came of a run."""
        self.store.save(record)

    def give(self, records: Iterable[RunRecord]) -> None:
        """Give all those runs that the shared store does not have yet."""
        wanted = {record.identity: record for record in records}
        there = self.store.find_many(list(wanted))
        self.store.save_many(r for identity, r in wanted.items() if identity not in there)

    def forget(self, identity: str) -> None:
        """Give a run back, or let a failed one be made again."""
        self.store.forget(identity)

    def forget_failed(self, identities: Collection[str]) -> None:
        """Let those of some runs that failed be made again."""
        self.store.forget_failed(identities)

    def close(self) -> None:
        """Show no more life, and give back what was not made."""
        self._ended.set()
        self._pulse.join()
        # Without the database, others take the claims over when they show no more life.
        with suppress(StoreError):
            self.store.release(self._owner)

    def _show_life(self) -> None:
        while not self._ended.wait(self._beat_seconds):
            try:
                self.store.beat(self._owner)
            except StoreError:
                # Should the database stay away, the next run that ends says so.
                continue
