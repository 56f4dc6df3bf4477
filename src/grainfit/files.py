"""Write files atomically, and read the end of logs."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

#: Size of the end of a log that is searched for causes, and of the part that is kept.
_LOG_BYTES = 65536
_TAIL_CHARACTERS = 8192


@contextmanager
def in_place_of(path: Path) -> Iterator[Path]:
    """Yield a temporary path, and move it to `path` when it is completely written.

    For a link, its target is replaced, not the link. A device or a pipe is written to, never
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
    """Write a text file so that it is complete or unchanged, even after a crash.

    Raises
    ------
    OSError
        It cannot be written; what was there is still there.
    """
    with in_place_of(path) as place:
        place.write_text(text, encoding="utf-8")


def log_tail(path: Path, lines: int = 20) -> str:
    """Return the last lines of a log, or an empty text when there is none."""
    return last_lines(text_of(path), lines)


def text_of(path: Path) -> str:
    """Return the end of a log, or an empty text when there is none."""
    try:
        with path.open("rb") as file:
            return end_of_file(file.fileno())
    except OSError:
        return ""


def end_of_file(file: int) -> str:
    """Return the last 64 KiB of an open file as text."""
    # Not by seek: the position in an open file is shared with the program that writes it.
    size = os.fstat(file).st_size
    start = max(0, size - _LOG_BYTES)
    return os.pread(file, size - start, start).decode("utf-8", errors="replace")


def last_lines(text: str, lines: int = 20) -> str:
    """Return the last lines of a text, cut to the length that a record keeps."""
    return "\n".join(text[-_TAIL_CHARACTERS:].splitlines()[-lines:])
