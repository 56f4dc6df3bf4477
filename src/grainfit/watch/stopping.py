"""Stop the calibration that uses a work folder, as Ctrl-C in its terminal does."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from grainfit import platforms
from grainfit.campaign.folder_lock import Signature, holder, is_held
from grainfit.errors import GrainfitError
from grainfit.watch import messages


class CannotStopError(GrainfitError):
    """A calibration cannot be stopped from here; the message says why, and where it can be."""


def why_not_to_be_stopped(folder: Path) -> str:
    """Return why the calibration that runs in a folder cannot be stopped here; "" if it can."""
    try:
        with _holding_process(folder):
            return ""
    except CannotStopError as error:
        return str(error)


def stop_calibration(folder: Path) -> None:
    """Interrupt the process that holds a work folder: it ends with its best result so far.

    Raises
    ------
    CannotStopError
        No process holds it, or one of another machine or user, or one that takes no interrupts.
    """
    with _holding_process(folder) as interrupt:
        interrupt()


@contextmanager
def _holding_process(folder: Path) -> Iterator[Callable[[], None]]:
    """Yield what interrupts the process that holds a folder."""
    signature = holder(folder)
    if signature.process and not signature.is_of_this_machine():
        about = {"host": signature.host, "process": signature.process}
        raise CannotStopError(messages.ANOTHER_MACHINE(**about))
    if not is_held(folder):
        raise CannotStopError(messages.NOT_IN_USE())
    if not platforms.CAN_INTERRUPT:
        raise CannotStopError(messages.NO_SIGNALS(process=signature.process))
    try:
        process = int(signature.process)
        with platforms.pinned(process) as send:
            if not _has_open(process, folder / "lock"):
                raise CannotStopError(_unknown(signature))
            yield partial(send, _interrupt_of(process))
    except PermissionError as error:
        raise CannotStopError(messages.ANOTHER_USER(process=signature.process)) from error
    except (OSError, ValueError, OverflowError) as error:
        raise CannotStopError(_unknown(signature)) from error


def _unknown(signature: Signature) -> str:
    known = f"process {signature.process}, which signed it," if signature.process else "no process"
    return messages.UNKNOWN_PROCESS(process=known)


def _has_open(process: int, path: Path) -> bool:
    """Return whether a process has a file open: a number alone may be that of a later process."""
    wanted = path.stat()
    for opened in Path(f"/proc/{process}/fd").iterdir():
        try:
            found = opened.stat()
        except FileNotFoundError:
            continue
        if (found.st_dev, found.st_ino) == (wanted.st_dev, wanted.st_ino):
            return True
    return False


def _interrupt_of(process: int) -> signal.Signals:
    """Return the signal that a process handles: in the background, SIGINT may be ignored."""
    text = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    handled = int(text.partition("SigCgt:")[2].split()[0], 16)
    for number in (signal.SIGINT, signal.SIGTERM):
        if handled & 1 << (number - 1):
            return number
    raise CannotStopError(messages.NO_INTERRUPTS(process=process))
