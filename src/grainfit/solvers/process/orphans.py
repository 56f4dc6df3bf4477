"""Find and end the processes of a run that outlive the calibration that started them.

Three signs tell that a process belongs to a run:

- the environment variable ``GRAINFIT_RUN`` with the path and the inode of the run folder. Every
  child inherits it, also one that changes its working folder, its group or its session;
- its session, if a process of the run leads it, or one with the mark is left in it: also a child
  that cleared its environment stays there, unless it opens a session of its own;
- descent from a process with one of these signs.

A process of another user, one that runs in another folder of the same name, and the processes that
have started this one are never ended.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path

import psutil

from grainfit import platforms
from grainfit.solvers.process.ending import end_processes, is_alive

#: Environment variable of all processes of a run.
MARK = "GRAINFIT_RUN"
#: File in a run folder, as long as a program runs there: number and start of its first process.
_SESSION_NAME = ".session"
#: A process may start others while it is ended.
_ROUNDS = 5


def mark_of(folder: Path) -> str:
    """Return the value of the mark for processes of a run in this folder.

    Raises
    ------
    OSError
        The folder does not exist.
    """
    return f"{_inode(folder)}:{folder.resolve()}"


def record_session(folder: Path, leader: int) -> None:
    """Record the session of a run, which its first process leads, in the run folder."""
    # The run does not depend on this file: a full disk is reported where the run itself needs it.
    with suppress(OSError):
        text = f"{leader} {platforms.start_of(leader)}\n"
        (folder / _SESSION_NAME).write_text(text, encoding="utf-8")


def forget_session(folder: Path) -> None:
    """Remove the record of a session whose processes have ended."""
    with suppress(OSError):
        (folder / _SESSION_NAME).unlink()


def end_orphans(folder: Path) -> bool:
    """End all processes of the run in this folder; return whether there were any.

    Other processes in the folder, such as the shell of a user, are not ended.
    """
    spared = _this_process_and_its_ancestors()
    for number in range(_ROUNDS):
        found = _processes_of(folder, spared)
        if not found:
            return number > 0
        end_processes(found)
    return True


def _processes_of(folder: Path, spared: Collection[int]) -> list[psutil.Process]:
    """Return the processes of a run that have its mark, or are in a session of the run."""
    own = {one.pid: one for one in _processes_of_this_user() if one.pid not in spared}
    marked = {pid for pid, one in own.items() if _is_mark_of(_mark_in(one), folder)}
    # A user who repeats a run by hand, with its environment, does so in a session without mark.
    led_by_run = {
        session
        for session in map(_session_of, marked)
        if session in marked or not is_alive(session)
    }
    sessions = led_by_run | {_recorded_session(folder)}
    return [one for pid, one in own.items() if pid in marked or _session_of(pid) in sessions]


def _processes_of_this_user() -> Iterator[psutil.Process]:
    # Not by psutil.process_iter: several threads may be here at the same time.
    for pid in psutil.pids():
        with suppress(psutil.Error):
            process = psutil.Process(pid)
            if platforms.is_of_this_user(process) and process.status() != psutil.STATUS_ZOMBIE:
                yield process


def _mark_in(process: psutil.Process) -> str:
    with suppress(psutil.Error, OSError):
        return str(process.environ().get(MARK, ""))
    return ""


def _session_of(pid: int) -> int:
    with suppress(OSError):
        return platforms.session_of(pid)
    # The process has just ended.
    return pid


def _is_mark_of(value: str, folder: Path) -> bool:
    """Return True if a mark names a folder, also after the folder, or one above it, was moved."""
    inode, _, path = value.partition(":")
    if not path:
        return False
    if path == str(folder.resolve()):
        return True
    # A removed folder's inode is used again. The names of run folders are not.
    with suppress(OSError):
        return folder.name.startswith(Path(path).stem) and inode == _inode(folder)
    return False


def _inode(folder: Path) -> str:
    found = folder.stat()
    return f"{found.st_dev}-{found.st_ino}"


def _recorded_session(folder: Path) -> int | None:
    """Return the recorded session of a run, if its first process still leads it.

    The number of a process that has ended may be that of somebody else's session.
    """
    try:
        number, _, start = (folder / _SESSION_NAME).read_text(encoding="utf-8").partition(" ")
        leader = int(number)
        return leader if start.strip() == platforms.start_of(leader) else None
    except (OSError, ValueError):
        return None


def _this_process_and_its_ancestors() -> set[int]:
    with suppress(psutil.Error):
        return {os.getpid(), *(parent.pid for parent in psutil.Process().parents())}
    return {os.getpid(), os.getppid()}
