"""Stop the calibration that uses a work folder, as Ctrl-C in its terminal does."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from grainfit.campaign.folder_lock import Signature, holder, is_held
from grainfit.errors import GrainfitError


class CannotStopError(GrainfitError):
    """A calibration cannot be stopped from here; the message says why, and where it can be."""


def why_not_to_be_stopped(folder: Path) -> str:
    """Return why the calibration that runs in a folder cannot be stopped here; "" if it can."""
    try:
        os.close(_open_process(folder)[0])
    except CannotStopError as error:
        return str(error)
    return ""


def stop_calibration(folder: Path) -> None:
    """Interrupt the process that holds a work folder: it ends with its best result so far.

    Raises
    ------
    CannotStopError
        No process holds it, or one of another machine or user, or one that takes no interrupts.
    """
    process, number = _open_process(folder)
    try:
        signal.pidfd_send_signal(process, number)
    except OSError as error:
        raise CannotStopError(f"the process cannot be interrupted: {error.strerror}.") from error
    finally:
        os.close(process)


def _open_process(folder: Path) -> tuple[int, signal.Signals]:
    """Return the process that holds a folder, as a descriptor, and the signal that interrupts it.

    A descriptor stays that of the process: its number may be that of another one a moment later.
    """
    signature = holder(folder)
    if signature.process and not signature.is_of_this_machine():
        raise CannotStopError(
            f"the calibration runs on another machine. Stop it on {signature.host}: "
            f"kill -INT {signature.process}"
        )
    if not is_held(folder):
        raise CannotStopError("no process uses the work folder any more.")
    try:
        process = os.pidfd_open(int(signature.process))
    except (OSError, ValueError, OverflowError) as error:
        raise CannotStopError(_unknown(signature)) from error
    try:
        if not _has_open(signature.process, folder / "lock"):
            raise CannotStopError(_unknown(signature))
        return process, _interrupt_of(signature.process)
    except PermissionError as error:
        os.close(process)
        raise CannotStopError(
            f"process {signature.process} belongs to another user, who can stop it."
        ) from error
    except (CannotStopError, OSError):
        os.close(process)
        raise


def _unknown(signature: Signature) -> str:
    known = f"process {signature.process}, which signed it," if signature.process else "no process"
    return (
        f"the work folder is in use, but {known} is found here to hold it: the calibration may run "
        "on another machine or in a container. Press Ctrl-C there."
    )


def _has_open(process: str, path: Path) -> bool:
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


def _interrupt_of(process: str) -> signal.Signals:
    """Return the signal that a process handles: in the background, SIGINT may be ignored."""
    text = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    handled = int(text.partition("SigCgt:")[2].split()[0], 16)
    for number in (signal.SIGINT, signal.SIGTERM):
        if handled & 1 << (number - 1):
            return number
    raise CannotStopError(f"process {process} does not handle interrupts.")
