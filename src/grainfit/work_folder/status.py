"""Progress of the calibration in a work folder, read from outside while it may be running."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from grainfit.campaign.absent_responses import failed_if_incomplete
from grainfit.campaign.store.records import RequestRecord, RunRecord
from grainfit.result import Result
from grainfit.result.holdout import HOLDOUT_STAGE
from grainfit.work_folder.open_folder import open_folder

if TYPE_CHECKING:
    from grainfit.calibration.live_file import LiveState


@dataclass(frozen=True)
class FailedRun:
    """A run that gave no responses."""

    folder: str
    reason: str
    log_tail: str


@dataclass(frozen=True)
class WorkdirStatus:
    """State of a work folder.

    Parameters
    ----------
    name : str
        Name of the calibration that was started last; empty when there is none.
    state : str
        ``running``, also while hold-outs are simulated, or how it ended; ``interrupted`` also when
        its process died.
    finished, asked : mapping of str to int
        Number of DEM runs by stage, hold-outs included.
    running : int
        Runs that execute.
    failed : tuple of FailedRun
        Runs of this calibration that failed.
    kept : int
        Finished runs in the store, those of other calibrations included.
    result : Result, optional
        Content of result.json, when there is one.
    result_fault : str
        Reason why the result cannot be used; empty if it can.
    failure : str
        Reason why the calibration stopped, if it failed.
    waiting : int
        Runs that wait for a worker, or for a job of a cluster.
    failed_in_holdouts : int
        Runs of its hold-outs that failed.
    """

    name: str
    state: str
    finished: Mapping[str, int]
    asked: Mapping[str, int]
    running: int
    failed: tuple[FailedRun, ...]
    kept: int
    result: Result | None
    result_fault: str = ""
    failure: str = ""
    waiting: int = 0
    failed_in_holdouts: int = 0


def read_status(folder: Path) -> WorkdirStatus:
    """Read the state of a work folder, without changing it or disturbing a running calibration.

    Raises
    ------
    StoreError
        The folder is not a work folder, or its store cannot be read.
    """
    with open_folder(folder) as opened:
        states = opened.store.states()
        failed = opened.store.runs("failed")
        incomplete = {record.identity: record for record in opened.store.incomplete_runs()}
    calibration, requests = opened.calibration, opened.requests
    if calibration is not None:
        failed += failed_if_incomplete(incomplete, requests, calibration.definition).values()
    result, fault = opened.read_result()
    running = opened.running(states.values())
    asked, ended = _of_holdouts(opened.holdouts, result)
    return WorkdirStatus(
        name=calibration.name if calibration else "",
        state="running" if opened.is_at_work else opened.state,
        finished={**_by_stage(requests, states, ("finished", "failed")), **ended},
        asked={**_by_stage(requests, None, ()), **asked},
        running=running,
        failed=tuple(_failures(folder, requests, failed)),
        kept=sum(state == "finished" for state in states.values()),
        result=result,
        result_fault=fault,
        failure=opened.failure,
        waiting=opened.under_way(states.values()) - running,
        failed_in_holdouts=_failed_in_holdouts(opened.holdouts, result),
    )


def _of_holdouts(
    live: LiveState | None, result: Result | None
) -> tuple[Mapping[str, int], Mapping[str, int]]:
    """Return how many runs of hold-outs were asked for, and have ended, by stage."""
    done = live.done if live else sum(one.runs for one in result.holdouts) if result else 0
    left = live.left[1] if live else 0
    return ({HOLDOUT_STAGE: done + left}, {HOLDOUT_STAGE: done}) if done + left else ({}, {})


def _failed_in_holdouts(live: LiveState | None, result: Result | None) -> int:
    if live is not None:
        return live.failed
    return sum(one.failed for one in result.holdouts) if result else 0


def _by_stage(
    requests: Sequence[RequestRecord],
    known: Mapping[str, str] | None,
    states: tuple[str, ...],
) -> Mapping[str, int]:
    return Counter(
        request.stage
        for request in requests
        for identity in request.runs.values()
        if known is None or known.get(identity) in states
    )


def _failures(
    folder: Path, requests: Sequence[RequestRecord], ended: Iterable[RunRecord]
) -> list[FailedRun]:
    wanted = {identity for request in requests for identity in request.runs.values()}
    return [
        FailedRun(str(folder / "runs" / record.identity), record.reason, record.log_tail)
        for record in ended
        if record.status == "failed" and record.identity in wanted
    ]
