"""Run a solver as an external process, with time-out and cancellation."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

from grainfit import platforms
from grainfit.errors import RunFailedError, SolverNotFoundError
from grainfit.files import end_of_file, last_lines, log_tail, text_of
from grainfit.solvers.base import Workspace
from grainfit.solvers.process import messages
from grainfit.solvers.process.ending import GRACE_SECONDS, end_process_group
from grainfit.solvers.process.faults import Cause, cause_of_exit, machine_error, machine_fault
from grainfit.solvers.process.orphans import (
    MARK,
    end_orphans,
    forget_session,
    mark_of,
    record_session,
)
from grainfit.solvers.process.run_folder import RunFolder
from grainfit.solvers.process.stopwatch import Stopwatch

LOG_NAME = "solver.log"
_POLL_SECONDS = 0.02
#: Interval at which the existence of the folder is checked.
_WATCH_SECONDS = 0.5
#: Set in a job of a cluster whose run takes all nodes of the job.
OVER_NODES = "GRAINFIT_OVER_NODES"
#: Within a job of a cluster, mpiexec of MPICH, Intel MPI and Open MPI would let the scheduler start
#: the ranks, as many as the job has tasks. With these a run stays on its machine.
_ON_ONE_NODE = {
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
    watch = Stopwatch()
    # The log is read through the open file, which remains readable after its removal.
    with RunFolder(workspace.folder) as folder, (workspace.folder / log_name).open("w+b") as log:
        mark = mark_of(workspace.folder)
        try:
            process = subprocess.Popen(
                list(command),
                cwd=workspace.folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env={**_environment(), MARK: mark, **(environment or {})},
                **platforms.apart(),
            )
        # ValueError: an argument that no program can be given, such as one with a zero byte.
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            failure = messages.NOT_STARTED(program=command[0], reason=reason)
            raise RunFailedError(failure, kind="machine") from error
        has_ended = False
        try:
            record_session(workspace.folder, process.pid)
            stopped = _wait(process, workspace, watch, folder)
            has_ended = stopped is None
        finally:
            _end(process)
            if not has_ended:
                # A program that detached itself would go on simulating.
                end_orphans(workspace.folder)
            forget_session(workspace.folder)
        text = end_of_file(log.fileno())
        if stopped is None and process.returncode != 0:
            # Without its folder a program ends with various errors; this is their cause.
            gone = Cause(messages.FOLDER_REMOVED(), "machine") if folder.is_gone() else None
            stopped = gone or cause_of_exit(command[0], process.returncode, text)
    if stopped is not None:
        raise RunFailedError(stopped.reason, last_lines(text), stopped.kind)
    return watch.look()


def _environment() -> dict[str, str]:
    """Return the environment of a program, whose ranks have one thread each."""
    nodes = {} if os.environ.get(OVER_NODES) else _ON_ONE_NODE
    return {**os.environ, "OMP_NUM_THREADS": "1", **nodes}


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
                    reason = messages.FOLDER_UNUSABLE(reason=error)
                tail = log_tail(path / LOG_NAME)
                raise RunFailedError(reason, tail, "machine") from error
    except OSError as error:
        reason = messages.FOLDER_UNUSABLE(reason=error)
        raise RunFailedError(reason, kind="machine") from error


def _wait(
    process: subprocess.Popen[bytes], workspace: Workspace, watch: Stopwatch, folder: RunFolder
) -> Cause | None:
    """Wait for the end of a process; return the reason to end it early, if there is one."""
    delay = _POLL_SECONDS / 10
    watched = 0.0
    while process.poll() is None:
        seconds = watch.look()
        if workspace.cancelled.is_set():
            return Cause(messages.STOPPED(), "cancelled")
        if workspace.timeout is not None and seconds > workspace.timeout:
            return Cause(messages.TOO_LONG(timeout=workspace.timeout), "timeout")
        if seconds - watched > _WATCH_SECONDS:
            if folder.is_gone():
                return Cause(messages.FOLDER_REMOVED(), "machine")
            watched = seconds
        time.sleep(delay)
        delay = min(delay * 2, _POLL_SECONDS)
    return None


def _end(process: subprocess.Popen[bytes]) -> None:
    end_process_group(process.pid)
    # A process that waits for a disk that does not answer cannot be killed.
    with suppress(subprocess.TimeoutExpired):
        process.wait(GRACE_SECONDS)
