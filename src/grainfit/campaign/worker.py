"""Execute one run: in this process, in another one, or on another machine.

A task holds everything that a worker needs; the returned record holds the complete outcome. A
worker knows neither the store nor the strategy. The run folder that it leaves is complete or
absent, so that a run is kept even if the process that started it has died.
"""

from __future__ import annotations

import math
import threading
import time
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from grainfit.campaign import messages
from grainfit.campaign.absent_responses import why_absent
from grainfit.campaign.keep import Keep
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.work_folder import close_run_folder, open_run_folder, put_aside, run_folder
from grainfit.errors import GrainfitError, RunFailedError
from grainfit.evaluation import Measured, scalars
from grainfit.solvers.base import Solver, Workspace
from grainfit.solvers.process import messages as process_messages
from grainfit.solvers.process.faults import machine_error

_TAIL_CHARACTERS = 2000


@dataclass(frozen=True)
class RunTask:
    """Input of a worker for one run.

    Parameters
    ----------
    record : RunRecord
        The run, with status ``running``.
    solver : Solver
        Solver that executes the run.
    parameters : mapping of str to float
        Values of the free parameters.
    seed : int
        Insertion seed.
    folder : Path
        The work folder.
    timeout : float, optional
        Longest wall time, s.
    keep : {"all", "results"}
        Files of the run folder that are kept.
    """

    record: RunRecord
    solver: Solver
    parameters: Mapping[str, float]
    seed: int
    folder: Path
    timeout: float | None = None
    keep: Keep = "all"


def execute(task: RunTask, cancelled: threading.Event | None = None) -> RunRecord:
    """Execute one run. A failure of the run is returned in the record, not raised.

    Parameters
    ----------
    task : RunTask
        The run.
    cancelled : threading.Event, optional
        Set when the user stops the calibration. Workers in other processes have none: they notice
        that the folder of their run has been removed.

    Returns
    -------
    RunRecord
        Finished, or failed with the reason.
    """
    started = time.monotonic()
    cancelled = cancelled or threading.Event()
    partial = None
    try:
        if cancelled.is_set():
            raise RunFailedError(process_messages.STOPPED(), kind="cancelled")
        if task.solver.uses_folder:
            partial = open_run_folder(task.folder, task.record.identity)
        workspace = Workspace(partial or task.folder, task.timeout, cancelled)
        responses = task.solver.run(task.parameters, task.seed, workspace)
        _refuse_non_finite(responses)
        reason = why_absent(task.solver.absent, responses)
        outcome = replace(task.record, status="finished", responses=responses, reason=reason)
    except Exception as error:
        outcome = _failed(task.record, error)
    outcome = replace(outcome, seconds=time.monotonic() - started, ended=time.time())
    return outcome if partial is None else _put_away(task, partial, outcome)


def _put_away(task: RunTask, partial: Path, outcome: RunRecord) -> RunRecord:
    """Keep the folder of a run. If the disk is full, the run still has its responses."""
    if outcome.kind == "cancelled":
        put_aside(partial)
        return outcome
    try:
        close_run_folder(partial, run_folder(task.folder, outcome.identity), outcome, task.keep)
    except OSError as error:
        if outcome.status == "failed":
            return outcome
        if not partial.exists():
            # The run was discarded, and its responses may be those of incomplete files.
            reason = messages.FOLDER_REMOVED()
            return replace(outcome, status="failed", responses={}, reason=reason, kind="machine")
        return replace(outcome, log_tail=messages.FOLDER_NOT_KEPT(reason=error))
    return outcome


def _failed(record: RunRecord, error: Exception) -> RunRecord:
    if isinstance(error, RunFailedError):
        return failed_record(record, error.reason, error.kind, error.log_tail)
    if isinstance(error, GrainfitError):
        return failed_record(record, str(error), "simulation")
    tail = "".join(traceback.format_exception(error))[-_TAIL_CHARACTERS:]
    if isinstance(error, (MemoryError, OSError)):
        return failed_record(record, machine_error(error) or str(error), "machine", tail)
    reason = messages.UNEXPECTED(kind=type(error).__name__, reason=error)
    return failed_record(record, reason, "evaluation", tail)


def failed_record(record: RunRecord, reason: str, kind: str, log_tail: str = "") -> RunRecord:
    """Return the record of a failed run, with a reason of one line."""
    one_line = " ".join(reason.split())
    return replace(record, status="failed", reason=one_line, kind=kind, log_tail=log_tail)


def _refuse_non_finite(responses: Mapping[str, Measured]) -> None:
    # The points of a curve are finite: it cannot be made of others.
    for name, response in scalars(responses).items():
        if not (math.isfinite(response.value) and math.isfinite(response.standard_error)):
            reason = messages.NOT_FINITE(name=name, value=response.value)
            raise RunFailedError(reason, kind="evaluation")
