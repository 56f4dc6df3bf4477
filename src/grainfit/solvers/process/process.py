"""Run a solver as an external process, with time-out, cancellation, and clean-up after a crash."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

from grainfit.errors import RunFailedError, SolverNotFoundError
from grainfit.files import end_of_file, last_lines, log_tail, text_of
from grainfit.solvers.base import Workspace
from grainfit.solvers.process.faults import Cause, cause_of_exit, machine_error, machine_fault
from grainfit.solvers.process.run_folder import REMOVED, RunFolder

LOG_NAME = "solver.log"
#: Environment variable of solvers by which they are found after a crash.
_MARK = "GRAINFIT_RUN"
_POLL_SECONDS = 0.02
_GRACE_SECONDS = 2.0
#: Interval at which the existence of the folder is checked.
_WATCH_SECONDS = 0.5
_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    # Within a job of a cluster, mpiexec of MPICH, Intel MPI and Open MPI would let the scheduler
    # start the ranks, as many as the job has tasks; a run must stay on its machine.
    "HYDRA_LAUNCHER": "fork",
    "HYDRA_RMK": "user",
    "I_MPI_HYDRA_BOOTSTRAP": "fork",
    "I_MPI_HYDRA_RMK": "user",
    "OMPI_MCA_plm": "isolated",
    "OMPI_MCA_ras": "^slurm",
    "PRTE_MCA_plm": "isolated",
    "PRTE_MCA_ras": "^slurm",
}


def run_process(
    command: Sequence[str],
    workspace: Workspace,
    environment: Mapping[str, str] | None = None,
    log_name: str = LOG_NAME,
) -> float:
    """Run a command in the workspace's folder to its end; return the wall time, s.

    Standard output and error go to a log in the folder, ``solver.log`` unless another name is
    given. No shell is used. The process leads its own group, so that a time-out or Ctrl-C also
    ends all of its MPI ranks. It is also ended soon after its folder is removed or renamed.

    Raises
    ------
    RunFailedError
        The program cannot be started, ends with a non-zero code, is killed by a signal, takes
        longer than the workspace allows, loses its folder, or is cancelled.
    OSError
        The folder cannot be written; see `recorded_faults`.
    """
    started = time.monotonic()
    # The log is read through the open file, which remains readable after its removal.
    with RunFolder(workspace.folder) as folder, (workspace.folder / log_name).open("w+b") as log:
        try:
            process = subprocess.Popen(
                list(command),
                cwd=workspace.folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env={**os.environ, **_ENVIRONMENT, _MARK: "", **(environment or {})},
                start_new_session=True,
            )
        # ValueError: an argument that no program can be given, such as one with a zero byte.
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise RunFailedError(
                f"cannot start {command[0]!r}: {reason}", kind="machine"
            ) from error
        try:
            stopped = _wait(process, workspace, started, folder)
        finally:
            _end(process)
        text = end_of_file(log.fileno())
        if stopped is None and process.returncode != 0:
            # Without its folder a program ends with various errors; this is their cause.
            gone = Cause(REMOVED, "machine") if folder.is_gone() else None
            stopped = gone or cause_of_exit(command[0], process.returncode, text)
    if stopped is not None:
        raise RunFailedError(stopped.reason, last_lines(text), stopped.kind)
    return time.monotonic() - started


@contextmanager
def recorded_faults(workspace: Workspace) -> Iterator[None]:
    """Convert errors of the block to a `RunFailedError` with their cause.

    A full disk leaves incomplete files, a removed folder missing ones, and a solver without licence
    may end with exit code 0. Responses that cannot be measured are then the fault of the machine.
    """
    path = workspace.folder
    try:
        with RunFolder(path) as folder:
            try:
                yield
            except RunFailedError as error:
                reason = "" if error.kind == "cancelled" else folder.fault()
                if not reason and error.kind == "evaluation":
                    reason = machine_fault(text_of(path / LOG_NAME))
                if not reason or reason == error.reason:
                    raise
                raise RunFailedError(reason, error.log_tail, "machine") from error
            except SolverNotFoundError as error:
                raise RunFailedError(str(error), kind="machine") from error
            except (OSError, MemoryError) as error:
                reason = folder.fault() or machine_error(error)
                if not reason and isinstance(error, OSError):
                    reason = f"its folder cannot be used: {error}"
                tail = log_tail(path / LOG_NAME)
                raise RunFailedError(reason, tail, "machine") from error
    except OSError as error:
        raise RunFailedError(f"its folder cannot be used: {error}", kind="machine") from error


def _wait(
    process: subprocess.Popen[bytes], workspace: Workspace, started: float, folder: RunFolder
) -> Cause | None:
    """Wait for the end of a process; return the reason to end it early, if there is one."""
    delay = _POLL_SECONDS / 10
    watched = started
    while process.poll() is None:
        now = time.monotonic()
        if workspace.cancelled.is_set():
            return Cause("stopped by the user", "cancelled")
        if workspace.timeout is not None and now - started > workspace.timeout:
            reason = f"took longer than its time-out of {workspace.timeout:g} s and was ended"
            return Cause(reason, "timeout")
        if now - watched > _WATCH_SECONDS:
            if folder.is_gone():
                return Cause(REMOVED, "machine")
            watched = now
        time.sleep(delay)
        delay = min(delay * 2, _POLL_SECONDS)
    return None


def _end(process: subprocess.Popen[bytes]) -> None:
    end_process_group(process.pid)
    # A process that waits for a disk that does not answer cannot be killed.
    with suppress(subprocess.TimeoutExpired):
        process.wait(_GRACE_SECONDS)


def end_process_group(leader: int) -> None:
    """End a process group and all its descendants, first by SIGTERM, then by SIGKILL.

    MPI launchers give their ranks separate groups or sessions, so the group alone is not enough.
    Nothing happens if it has already ended.
    """
    family = _descendants(leader)
    for number, grace in ((signal.SIGTERM, _GRACE_SECONDS), (signal.SIGKILL, 0.0)):
        try:
            os.killpg(leader, number)
        except (ProcessLookupError, PermissionError):
            break
        _wait_for_end([leader], grace)
        family |= _descendants(leader)
    for process in family:
        # psutil does not kill another process that has got the same number since.
        with suppress(psutil.Error):
            process.kill()
    _wait_for_end([process.pid for process in family if process.is_running()], _GRACE_SECONDS)


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
    while time.monotonic() < deadline and any(map(_is_alive, pids)):
        time.sleep(_POLL_SECONDS)


def _is_alive(pid: int) -> bool:
    try:
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    except psutil.Error:
        return False


def end_orphan(folder: Path) -> bool:
    """End the solvers that a killed calibration left running in this folder.

    They have a mark in their environment. Other processes in the folder, such as the shell of a
    user, are not ended.
    """
    here = str(folder.resolve())
    leaders = set()
    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):
            if process.cwd() == here and _MARK in process.environ():
                leaders.add(os.getpgid(process.pid))
    for leader in leaders:
        end_process_group(leader)
    return bool(leaders)
