"""Rows of the page: responses, parameters, runs, failures and jobs, as text and plain numbers."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from grainfit.calibration.live_file import LiveState
from grainfit.campaign.pending import ALIVE, ClusterJob, PendingRun
from grainfit.campaign.store.records import RequestRecord, RunRecord
from grainfit.campaign.work_folder import PARTIAL_SUFFIX
from grainfit.evaluation import names_of_tests
from grainfit.formatting import (
    assigned,
    plain,
    plain_lines,
    probability,
)
from grainfit.plots.labels import label_of_parameter, label_of_response
from grainfit.problem import Parameter, Target
from grainfit.report.rows import ResponseRow, curve_row, parameter_row, response_row
from grainfit.result import Result
from grainfit.result.holdout import HOLDOUT_STAGE
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Most rows that are shown of a kind.
MOST_ROWS = 50
Row = dict[str, Any]


def response_rows(saved: SavedCalibration, result: Result | None) -> list[Row]:
    """Return every response with its target, and what the runs lead to expect."""
    responses, curves = (result.responses, result.curves) if result else ({}, {})
    rows = []
    for target in saved.problem.targets:
        found = responses.get(target.name)
        shown = response_row(label_of_response(saved, target.name), target, found)
        rows.append(_texts(shown) | {"bar": _bar(target, *found.expected) if found else None})
    for curve in saved.problem.curves:
        rows.append(_texts(curve_row(curve, curves.get(curve.name))) | {"bar": None})
    return rows


def _texts(shown: ResponseRow) -> Row:
    return {
        "name": plain(shown.label.name),
        "words": shown.label.words,
        "unit": shown.label.unit,
        "measured": _with(shown.measured, shown.tolerance),
        "expected": _with(shown.expected, shown.half_width),
        "deviation": shown.deviation,
        "verdict": shown.verdict + _likely(shown.probability),
    }


def _with(value: str, half_width: str) -> str:
    return f"{value} ± {half_width}" if half_width else value


def _likely(value: float | None) -> str:
    """Return a probability in few characters, after a verdict."""
    if value is None:
        return ""
    words = probability(value).replace("more than ", ">\u00a0").replace("less than ", "<\u00a0")
    return f", {words}"


def _bar(target: Target, value: float, half_width: float) -> dict[str, float]:
    """Return a bar about the target: percentages of its width."""
    reach = max(2 * target.tolerance, 1.15 * (abs(value - target.value) + half_width))

    def place(at: float) -> float:
        return round(50 + 50 * (at - target.value) / reach, 2)

    return {
        "from": place(target.value - target.tolerance),
        "to": place(target.value + target.tolerance),
        "low": place(value - half_width),
        "high": place(value + half_width),
        "value": place(value),
    }


def parameter_rows(saved: SavedCalibration, result: Result | None) -> list[Row]:
    """Return every free parameter with its value so far and, at the end, its interval."""
    return [_parameter_row(saved, parameter, result) for parameter in saved.problem.parameters]


def _parameter_row(saved: SavedCalibration, parameter: Parameter, result: Result | None) -> Row:
    values, intervals = (result.parameters, result.intervals) if result else ({}, {})
    name = parameter.name
    label = label_of_parameter(saved, name)
    shown = parameter_row(label, parameter, values.get(name), intervals.get(name))
    return {
        "name": plain(name),
        "words": label.words,
        "unit": label.unit,
        "value": shown.value,
        "interval": shown.interval,
        "determination": shown.determination,
        "bias": plain(shown.bias),
        "searched": shown.searched,
        "place": shown.position,
    }


def run_rows(
    saved: SavedCalibration, requests: Sequence[RequestRecord], live: LiveState
) -> tuple[list[Row], Mapping[str, int]]:
    """Return the runs that have not ended, and their numbers by state."""
    asked = {run: (request, name) for request in requests for name, run in request.runs.items()}
    begun = _beginnings(saved.folder)
    usual = _usual_seconds(saved.records.values())
    rows = [
        _run_row(run, asked.get(run.identity), begun, usual, saved.units) for run in live.pending
    ]
    if live.stage == HOLDOUT_STAGE:
        # The store has requests of the fitted tests alone.
        rows = [row | {"stage": live.stage} for row in rows]
    counts = {state: sum(row["state"] == state for row in rows) for state in _RUN_STATES}
    rows.sort(key=lambda row: _RUN_STATES.index(row["state"]))
    return rows[:MOST_ROWS], counts


_RUN_STATES = ("running", "submitted", "waiting", "again", "elsewhere")


def _run_row(
    run: PendingRun,
    asked: tuple[RequestRecord, str] | None,
    begun: Mapping[str, float],
    usual: Mapping[str, float],
    units: Mapping[str, str],
) -> Row:
    since = begun.get(run.identity, run.submitted)
    request, name = asked if asked else (None, run.test)
    return {
        "key": run.identity[:12],
        "number": request.position if request else None,
        "test": plain(name),
        "stage": request.stage if request else "",
        "state": _state_of(run, run.identity in begun),
        "since": since or None,
        "usual": usual.get(run.test),
        "tries": run.tries,
        "parameters": ", ".join(assigned(request.parameters, units)) if request else "",
    }


def _state_of(run: PendingRun, has_folder_now: bool) -> str:
    if run.state != "submitted":
        return "again" if run.state == "postponed" else "elsewhere"
    if has_folder_now or (run.has_begun and not run.has_folder):
        return "running"
    # Of a Python function in another process, nobody knows whether it has begun.
    return "waiting" if run.has_folder else "submitted"


def _usual_seconds(records: Iterable[RunRecord]) -> dict[str, float]:
    """Return the median wall time of the finished runs of every test, s."""
    times: dict[str, list[float]] = {}
    for record in records:
        if record.status == "finished":
            times.setdefault(record.test, []).append(record.seconds)
    return {test: median(seconds) for test, seconds in times.items()}


def _beginnings(folder: Path) -> dict[str, float]:
    """Return when a worker began with each run that has not ended, by identity of the run."""
    found: dict[str, float] = {}
    try:
        with os.scandir(folder / "runs") as entries:
            names = [entry.name for entry in entries if entry.name.endswith(PARTIAL_SUFFIX)]
    except OSError:
        return {}
    for name in names:
        if (when := _beginning(folder / "runs" / name)) is not None:
            found[name.partition(".")[0]] = when
    return found


def _beginning(partial: Path) -> float | None:
    # Files of a model are copied with their dates; the time of the change of a file's own record
    # is that of the copy.
    try:
        with os.scandir(partial) as entries:
            files = [entry.stat(follow_symlinks=False).st_ctime for entry in entries]
        return min([*files, partial.stat().st_ctime])
    except OSError:
        return None


def failure_rows(
    saved: SavedCalibration, requests: Sequence[RequestRecord], failed: Iterable[RunRecord]
) -> tuple[list[Row], int]:
    """Return the runs that failed, the latest first, and their number."""
    asked = {run: (request, name) for request in requests for name, run in request.runs.items()}
    known = {record.identity: record for record in (*saved.records.values(), *failed)}
    lost = [one for one in known.values() if one.status == "failed" and one.identity in asked]
    lost.sort(key=lambda record: record.ended, reverse=True)
    rows = [
        {
            "key": record.identity[:12],
            "number": asked[record.identity][0].position,
            "test": plain(asked[record.identity][1]),
            "kind": record.kind,
            "reason": plain(record.reason) or "no reason is known",
            "folder": _folder(saved.folder / "runs" / record.identity),
            "log": "\n".join(plain_lines(record.log_tail)),
        }
        for record in lost[:MOST_ROWS]
    ]
    return rows, len(lost)


def _folder(path: Path) -> str:
    """Return the folder of a run, if it has one: Python functions have none."""
    return plain(str(path)) if path.is_dir() else ""


def job_rows(jobs: Sequence[ClusterJob]) -> list[Row]:
    """Return the jobs of a cluster, those that have not ended first."""
    ordered = sorted(jobs, key=lambda job: job.state not in ALIVE)
    return [
        {
            "key": f"{place}-{job.number}",
            "number": plain(job.number) or "refused",
            "state": plain(job.state),
            "words": plain(job.message),
        }
        for place, job in enumerate(ordered[:MOST_ROWS])
    ]


def several_tests(requests: Iterable[RequestRecord]) -> bool:
    """Return whether there is more than one test, so that its name has to be shown."""
    return len(names_of_tests(run for request in requests for run in request.runs)) > 1
