"""Run a solver as an external process that can be timed out, cancelled, and found after a crash."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from grainfit.errors import RunFailedError
from grainfit.solvers.base import Workspace

LOG_NAME = "solver.log"
PROCESS_NAME = "process.json"
_POLL_SECONDS = 0.02
_GRACE_SECONDS = 2.0


def run_process(
    command: Sequence[str],
    workspace: Workspace,
    environment: Mapping[str, str] | None = None,
    log_name: str = LOG_NAME,
) -> float:
    """Run a command in the workspace's folder to its end; return the wall time, s.

    Standard output and error go to a log in the folder, ``solver.log`` unless another name is
    given. No shell is involved. The process leads its own group, so that a time-out or Ctrl-C ends
    all of its MPI ranks too.

    Raises
    ------
    RunFailedError
        The program cannot be started, ends with a non-zero code, is killed by a signal, takes
        longer than the workspace allows, or is cancelled.
    """
    log_path = workspace.folder / log_name
    started = time.monotonic()
    with log_path.open("wb") as log:
        try:
            process = subprocess.Popen(
                list(command),
                cwd=workspace.folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env={**os.environ, "OMP_NUM_THREADS": "1", **(environment or {})},
                start_new_session=True,
            )
        # ValueError: an argument that no program can be given, such as one with a zero byte.
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise RunFailedError(
                f"cannot start {command[0]!r}: {reason}", kind="machine"
            ) from error
        try:
            _note_process(workspace.folder, process.pid)
            _wait(process, workspace, started, log_path)
        finally:
            end_process_group(process.pid)
            process.wait()
            (workspace.folder / PROCESS_NAME).unlink(missing_ok=True)
    _raise_for_exit(process.returncode, command[0], log_path)
    return time.monotonic() - started


def _wait(
    process: subprocess.Popen[bytes], workspace: Workspace, started: float, log_path: Path
) -> None:
    delay = _POLL_SECONDS / 10
    while process.poll() is None:
        if workspace.cancelled.is_set():
            raise RunFailedError("stopped by the user", kind="cancelled")
        if workspace.timeout is not None and time.monotonic() - started > workspace.timeout:
            raise RunFailedError(
                f"took longer than its time-out of {workspace.timeout:g} s and was ended",
                log_tail(log_path),
                "timeout",
            )
        time.sleep(delay)
        delay = min(delay * 2, _POLL_SECONDS)


def _raise_for_exit(code: int, program: str, log_path: Path) -> None:
    if code == 0:
        return
    name = Path(program).name
    if code < 0:
        try:
            reason = f"{name} was killed by {signal.Signals(-code).name}"
        except ValueError:
            reason = f"{name} was killed by signal {-code}"
        # An outside kill (out of memory, a person) is the machine's doing; a fault is the deck's.
        outside = -code in (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
        raise RunFailedError(reason, log_tail(log_path), "machine" if outside else "simulation")
    raise RunFailedError(f"{name} ended with exit code {code}", log_tail(log_path))


def log_tail(path: Path, lines: int = 20) -> str:
    """Return the last lines of a log, or an empty text when there is none."""
    try:
        with path.open("rb") as file:
            file.seek(0, os.SEEK_END)
            file.seek(max(0, file.tell() - 8192))
            text = file.read().decode("utf-8", errors="replace")
    except OSError:
        return ""
    return "\n".join(text.splitlines()[-lines:])


def end_process_group(leader: int) -> None:
    """End a process group: ask first, then kill; does nothing when it is gone already."""
    for number, grace in ((signal.SIGTERM, _GRACE_SECONDS), (signal.SIGKILL, 0.0)):
        try:
            os.killpg(leader, number)
        except (ProcessLookupError, PermissionError):
            return
        deadline = time.monotonic() + grace
        while time.monotonic() < deadline and _is_alive(leader):
            time.sleep(_POLL_SECONDS)


def _is_alive(pid: int) -> bool:
    try:
        status = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"


def _note_process(folder: Path, pid: int) -> None:
    (folder / PROCESS_NAME).write_text(json.dumps({"pid": pid}), encoding="utf-8")


def end_orphan(folder: Path) -> bool:
    """End the solver that a killed calibration left running in this folder, if there is one.

    A process number alone may have been given to somebody else since, so the process must still
    work in this folder.
    """
    note = folder / PROCESS_NAME
    try:
        pid = int(json.loads(note.read_text(encoding="utf-8"))["pid"])
        if Path(f"/proc/{pid}/cwd").readlink() != folder.resolve():
            return False
    except (OSError, ValueError, KeyError, TypeError):
        return False
    end_process_group(pid)
    return True
