"""Writes files so that they are whole or not there."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def in_place_of(path: Path) -> Iterator[Path]:
    """Yield where to write a file that takes the place of another one when it is whole.

    Behind a link, the file is replaced and not the link. A device or a pipe is written to, never
    replaced.

    Raises
    ------
    OSError
        It cannot be written; what was there is still there.
    """
    if not _may_be_replaced(path):
        yield path
        return
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{target.name}.{os.getpid()}.new")
    try:
        yield temporary
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        temporary.replace(target)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise


def _may_be_replaced(path: Path) -> bool:
    try:
        return stat.S_ISREG(path.stat().st_mode)
    except FileNotFoundError:
        return True


def write_atomically(path: Path, text: str) -> None:
    """Write a text file so that it is either whole or not there, even after a crash.

    Raises
    ------
    OSError
        It cannot be written; what was there is still there.
    """
    with in_place_of(path) as place:
        place.write_text(text, encoding="utf-8")
