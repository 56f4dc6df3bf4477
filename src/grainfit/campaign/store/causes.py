"""Causes of a store that cannot be used: what codes of errors mean, and what the files say.

SQLite names a full disk, a missing permission and an unusable file beside the store with the same
short text. Only trying again what it did tells which of them it was.
"""

from __future__ import annotations

import os
import re
import shlex
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


#: What to do about errors of PostgreSQL, by the beginning of their SQLSTATE.
_OF_SERVER = {
    "22P05": messages.UTF8_DATABASE,
    "25006": messages.WRITES_NOTHING,
    "42501": messages.GRANT,
    "42": messages.OWN_DATABASE,
    "53100": messages.SERVER_FULL,
}
#: PostgreSQL's driver has no SQLSTATE for a connection that could not be made.
_NO_DATABASE = re.compile(r'database "(.+)" does not exist')


def words_of(cause: BaseException) -> str:
    """Return the words of a driver in one line, without the statement that was at fault."""
    words = getattr(getattr(cause, "diag", None), "message_primary", None)
    return " ".join(str(words or cause).split())


def remedy(cause: BaseException, words: str, path: Path | None, renew: str) -> str:
    """Return what made a store unusable, and what to do.

    Parameters
    ----------
    cause : BaseException
        Error of the driver.
    words : str
        Its words, as they are shown.
    path : Path, optional
        File of the store; None for one of a server.
    renew : str
        What to do with a damaged file.
    """
    code = getattr(cause, "sqlite_errorcode", None)
    if code is None:
        return _remedy_of_server(cause, words)
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


def _remedy_of_server(cause: BaseException, words: str) -> str:
    state = getattr(cause, "sqlstate", None)
    if state is not None:
        known = (text() for beginning, text in _OF_SERVER.items() if state.startswith(beginning))
        return next(known, messages.CHECK_SERVER())
    if found := _NO_DATABASE.search(words):
        return messages.CREATE_DATABASE(name=shlex.quote(found[1]))
    # The driver's own, before it has asked the server.
    is_of_options = type(cause).__name__ == "ProgrammingError"
    return messages.CHECK_OPTIONS() if is_of_options else messages.CHECK_SERVER()


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
