"""Causes of a store that cannot be used: what SQLite's error codes mean, and what the files say.

SQLite names a full disk, a missing permission and an unusable file beside the store with the same
short text. Only trying again what it did tells which of them it was.
"""

from __future__ import annotations

import os
import sqlite3
import tempfile
from collections.abc import Iterator
from pathlib import Path

from grainfit.campaign import messages

#: Errors of a file whose contents are not those of a store.
_DAMAGED = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_ERROR)
_IN_USE = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)
#: More than SQLite writes at once to a file that it creates, bytes.
_TRIED_BYTES = 65_536


def remedy(cause: BaseException, path: Path | None, renew: str) -> str:
    """Return what made a store unusable, and what to do.

    Parameters
    ----------
    cause : BaseException
        Error of the driver.
    path : Path, optional
        File of the store in a work folder; None for another store.
    renew : str
        What to do with a damaged file.
    """
    code = getattr(cause, "sqlite_errorcode", None)
    if code is None:
        return messages.CHECK_SERVER()
    # The low byte is the kind of the error, the rest its details.
    kind = code & 0xFF
    if kind in _DAMAGED:
        return renew
    if kind == sqlite3.SQLITE_FULL:
        return messages.MAKE_ROOM()
    if kind in _IN_USE:
        return messages.USED_OR_NO_LOCKS()
    found = next(_obstacles(path), "") if path is not None else ""
    if found:
        return messages.CORRECT_THAT(cause=found)
    return messages.CHECK_FILES()


def _obstacles(path: Path) -> Iterator[str]:
    """Yield why the file of a store, or one beside it, cannot be used."""
    if not path.parent.is_dir():
        yield messages.FOLDER_MISSING(folder=str(path.parent))
    for name in (path.name, f"{path.name}-wal", f"{path.name}-shm"):
        file = path.with_name(name)
        try:
            with file.open("r+b"):
                pass
        except FileNotFoundError:
            continue
        except OSError as error:
            yield messages.NOT_WRITABLE(file=str(file), reason=error.strerror)
    try:
        with tempfile.TemporaryFile(dir=path.parent) as trial:
            trial.write(bytes(_TRIED_BYTES))
            trial.flush()
            os.fsync(trial.fileno())
    except OSError as error:
        yield messages.NOTHING_WRITABLE(folder=str(path.parent), reason=error.strerror)
