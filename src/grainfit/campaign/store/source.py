"""Open the store of another work folder, or of several machines, for reading."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from grainfit.campaign import messages
from grainfit.campaign.store.address import safe_address
from grainfit.campaign.store.store import STORE_NAME, RunStore
from grainfit.errors import InputError


@contextmanager
def open_source(source: str | Path, key: str = "runs_from") -> Iterator[RunStore]:
    """Open the store of a work folder, or the store at an address, for reading.

    Parameters
    ----------
    source : path or str
        A work folder, or the address of a store.
    key : str
        Key that a fault names.

    Raises
    ------
    InputError
        The folder has no store.
    StoreError
        The store cannot be read.
    """
    if "://" in str(source):
        store = RunStore(str(source), read_only=True)
    else:
        folder = Path(source)
        if not (folder / STORE_NAME).is_file():
            shown = safe_address(source)
            raise InputError(messages.NO_SOURCE.fault(key, folder=shown, store=STORE_NAME))
        store = RunStore.read_only(folder)
    try:
        yield store
    finally:
        store.close()
