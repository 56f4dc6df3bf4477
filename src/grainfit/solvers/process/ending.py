"""End processes with all their descendants: first by SIGTERM, then by SIGKILL."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from contextlib import suppress

import psutil

from grainfit import platforms

GRACE_SECONDS = 2.0
_POLL_SECONDS = 0.02


def end_process_group(leader: int) -> None:
    """End a process group and all its descendants.

    MPI launchers give their ranks separate groups or sessions, so the group alone is not enough.
    Nothing happens if it has already ended.
    """
    family = _descendants(leader)
    ends = platforms.signals("SIGTERM", "SIGKILL")
    for number, grace in zip(ends, (GRACE_SECONDS, 0.0), strict=False):
        try:
            platforms.signal_group(leader, number)
        except (ProcessLookupError, PermissionError):
            break
        _wait_for_end([leader], grace)
        family |= _descendants(leader)
    for process in family:
        # psutil does not kill another process that has got the same number since.
        with suppress(psutil.Error):
            process.kill()
    _wait_for_end([process.pid for process in family if process.is_running()], GRACE_SECONDS)


def end_processes(processes: Collection[psutil.Process]) -> None:
    """End processes and all their descendants."""
    family = set(processes)
    for end in (psutil.Process.terminate, psutil.Process.kill):
        for process in list(family):
            family |= _descendants(process.pid)
        for process in family:
            # psutil does not signal another process that has got the same number since.
            with suppress(psutil.Error):
                end(process)
        _wait_for_end([process.pid for process in family if process.is_running()], GRACE_SECONDS)


def is_alive(pid: int) -> bool:
    """Return True if a process exists and is no zombie."""
    try:
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    except psutil.Error:
        return False


def _descendants(pid: int) -> set[psutil.Process]:
    """Return all descendants of a process."""
    try:
        return set(psutil.Process(pid).children(recursive=True))
    except psutil.Error:
        return set()


def _wait_for_end(pids: Sequence[int], seconds: float) -> None:
    # Not by psutil.wait_procs: it reaps children, whose exit codes are needed elsewhere, and waits
    # for zombies that nobody reaps.
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline and any(map(is_alive, pids)):
        time.sleep(_POLL_SECONDS)
