"""Read files within limits, write them atomically, and read the end of logs."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from grainfit import ground_messages as messages
from grainfit import platforms
from grainfit.errors import GrainfitError, InputError
from grainfit.messages import Message

#: Largest files that are read, bytes. A file of the wrong name must not fill the memory.
LARGEST_CALIBRATION_FILE = 1_000_000
#: Python takes about 1 kB of memory for a byte of code.
LARGEST_PYTHON_FILE = 1_000_000
LARGEST_TABLE = 20_000_000
LARGEST_CURVE = 10_000_000
LARGEST_MESH = 100_000_000
LARGEST_RESPONSES = 100_000_000
LARGEST_SERIES = 500_000_000
LARGEST_RESULT = 100_000_000
LARGEST_TEMPLATE = 10_000_000
LARGEST_RUN_OUTPUT = 4_000_000_000
#: The folder of a model, which is copied for every run: bytes, files and folders.
LARGEST_MODEL = 200_000_000
MOST_MODEL_FILES = 20_000

_PIECE = 1_000_000

#: Size of the end of a log that is searched for causes, and of the part that is kept.
_LOG_BYTES = 65536
_TAIL_CHARACTERS = 8192


def is_file(path: Path) -> bool:
    """Return True if there is such a file; False also where a folder may not be entered."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Return True if there is such a folder; False also where a folder may not be entered."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


class TooLargeError(OSError):
    """A file is larger than what is read of its kind."""


def is_irregular(path: Path) -> bool:
    """Return True for a pipe, a socket or a device, which may keep a reader waiting."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)


def open_regular(path: Path) -> BinaryIO:
    """Open a file for reading; nothing that may keep a reader waiting.

    Raises
    ------
    OSError
        It cannot be opened, or is a pipe, a socket or a device.
    """
    # A pipe would be opened only when somebody writes to it.
    file: BinaryIO = os.fdopen(platforms.open_to_read(path), "rb")
    if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        return file
    file.close()
    raise OSError(errno.EINVAL, "it is a pipe or a device, not a file", str(path))


def read_within(path: Path, largest: int, *, waiting: bool = False) -> bytes:
    """Return the contents of a file that is not larger than a limit.

    Parameters
    ----------
    path : Path
        The file; it may grow while it is read.
    largest : int
        Largest size, bytes: one of the limits of this module.
    waiting : bool, optional
        Read a pipe as well, whose writer is waited for: a file that the user names.

    Raises
    ------
    TooLargeError
        It is larger; hardly anything of it was read.
    OSError
        It cannot be read.
    """
    with path.open("rb") if waiting else open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        # Python reserves memory for as much as is asked for.
        content = file.read(size + 1) if size <= largest else b""
        while len(content) > size and len(content) <= largest and (more := file.read(_PIECE)):
            content += more
    if max(size, len(content)) > largest:
        shown = f"it has {size / 1e6:.6g} MB" if size > largest else "it is too long"
        raise TooLargeError(
            errno.EFBIG, f"{shown}, and at most {largest / 1e6:.0f} MB are read", str(path)
        )
    return content


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
        platforms.write_to_disk(temporary)
        platforms.replace(temporary, target)
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


@contextmanager
def writing(
    path: Path,
    kind: type[GrainfitError] = InputError,
    message: Message = messages.CANNOT_BE_WRITTEN,
) -> Iterator[None]:
    """Raise an error that names the file and the reason if it cannot be written within."""
    try:
        yield
    except OSError as error:
        about = {"path": str(path), "reason": error.strerror or error}
        if kind is InputError:
            raise InputError(message.fault("", **about)) from error
        raise kind(message(**about)) from error


def log_tail(path: Path, lines: int = 20) -> str:
    """Return the last lines of a log, or an empty text when there is none."""
    return last_lines(text_of(path), lines)


def line_of(error: UnicodeDecodeError) -> int:
    """Return the number of the line that could not be decoded, from 1.

    Positions count from behind a byte order mark, in what the error has of the text.
    """
    return error.object.count(b"\n", 0, error.start) + 1


def text_of(path: Path) -> str:
    """Return the end of a log, or an empty text when there is none."""
    try:
        with open_regular(path) as file:
            return end_of_file(file.fileno())
    except OSError:
        return ""


def end_of_file(file: int) -> str:
    """Return the last 64 KiB of an open file as text."""
    # Not by seek: the position in an open file is shared with the program that writes it.
    size = os.fstat(file).st_size
    start = max(0, size - _LOG_BYTES)
    return platforms.read_at(file, size - start, start).decode("utf-8", errors="replace")


def last_lines(text: str, lines: int = 20) -> str:
    """Return the last lines of a text, cut to the length that a record keeps."""
    return "\n".join(text[-_TAIL_CHARACTERS:].splitlines()[-lines:])
