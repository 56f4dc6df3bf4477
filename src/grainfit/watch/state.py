"""State of the calibration in a work folder, as the page shows it: plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grainfit.analysis.analysis import Analysis
from grainfit.calibration.live_file import LiveState, read_live_holdouts, read_live_state
from grainfit.campaign.folder_lock import is_held
from grainfit.campaign.store.records import RequestRecord, RunRecord
from grainfit.campaign.store.store import STORE_NAME
from grainfit.errors import StoreError
from grainfit.files import is_file
from grainfit.formatting import plain, probability
from grainfit.plots.labels import in_words
from grainfit.report import verdict_messages as messages
from grainfit.report.page import REPORT_NAME
from grainfit.report.section import ReportContext
from grainfit.report.verdict import shown_verdict
from grainfit.result import Result
from grainfit.result.holdout import HOLDOUT_STAGE, holdouts_in_short
from grainfit.verdict.messages import state_name
from grainfit.verdict.reasons import Deterministic
from grainfit.watch.messages import NOT_IN_USE
from grainfit.watch.rows import (
    MOST_ROWS,
    failure_rows,
    job_rows,
    parameter_rows,
    response_rows,
    run_rows,
    several_tests,
)
from grainfit.watch.stopping import why_not_to_be_stopped
from grainfit.work_folder.open_folder import open_folder
from grainfit.work_folder.saved_calibration import SavedCalibration

_STAGES = {
    "design": "Design: first runs all over the intervals",
    "optimisation": "Search: every run where it improves the answer most",
    "verification": "Verification: fresh seeds at the answer",
    HOLDOUT_STAGE: "Hold-outs: tests that were not fitted, at the answer and about it",
}


_LISTS = ("failures", "responses", "parameters", "runs", "jobs", "notices")


@dataclass(frozen=True)
class Reading:
    """Content of a work folder at one moment.

    Parameters
    ----------
    folder : Path
        The work folder.
    saved : SavedCalibration or None
        The calibration; None if there is none yet. Its state is ``running`` also while hold-outs
        are simulated, and it has its result then.
    requests : sequence of RequestRecord
        The parameter sets that it asked for.
    failed : sequence of RunRecord
        All failed runs of the store.
    live : LiveState or None
        What only its process knows, while it runs.
    is_running : bool
        Whether the calibration is running.
    is_held : bool
        Whether a process uses the folder: it also writes the result of one that has ended.
    why_not_stopped : str
        Reason why the running calibration cannot be stopped here; empty if it can.
    fault : str
        Reason why nothing can be read; empty if it can.
    """

    folder: Path
    saved: SavedCalibration | None = None
    requests: Sequence[RequestRecord] = ()
    failed: Sequence[RunRecord] = ()
    live: LiveState | None = None
    is_running: bool = False
    is_held: bool = False
    why_not_stopped: str = ""
    fault: str = ""


def read_folder(folder: Path, *, is_alive_elsewhere: bool = False) -> Reading:
    """Read a work folder, without changing it or disturbing a running calibration.

    Parameters
    ----------
    folder : Path
        The work folder.
    is_alive_elsewhere : bool
        Whether a process of another machine was seen to use the folder, which its lock may not
        tell.
    """
    if not is_file(folder / STORE_NAME):
        return Reading(folder)
    try:
        with open_folder(folder) as opened:
            requests, failed = opened.requests, opened.store.runs("failed")
            if opened.calibration is None:
                return Reading(folder, is_running=opened.state == "running")
        saved = SavedCalibration.open(folder)
    except StoreError as error:
        return Reading(folder, fault=str(error))
    if is_alive_elsewhere and saved.state == "interrupted":
        saved = replace(saved, state="running", result=None)
    elif saved.in_holdouts or (is_alive_elsewhere and read_live_holdouts(folder, saved.identity)):
        saved = replace(saved, state="running", in_holdouts=True)
    is_running = saved.state == "running"
    live = read_live_state(folder, saved.identity) if is_running else None
    why = why_not_to_be_stopped(folder) if is_running else ""
    return Reading(folder, saved, requests, failed, live, is_running, is_held(folder), why)


def state_of(
    reading: Reading, so_far: Result | None, estimate: Sequence[str] = ()
) -> dict[str, Any]:
    """Return all that the page shows of a work folder, but particles.

    Parameters
    ----------
    reading : Reading
        The work folder.
    so_far : Result, optional
        Best answer by the runs so far, where there is no result.
    estimate : sequence of str, optional
        What the atlas expects, shown while the runs are too few for an answer.
    """
    saved = reading.saved
    if saved is None:
        return _without_calibration(reading)
    result = saved.result if saved.result and saved.result.parameters else so_far
    failures, failed = failure_rows(saved, reading.requests, reading.failed)
    return {
        "name": plain(saved.name) or plain(saved.folder.absolute().name),
        "folder": plain(str(saved.folder)),
        "state": saved.state,
        "title": state_name(saved.state),
        "started": reading.live.started if reading.live else saved.started,
        "verdict": _verdict(reading, so_far, estimate),
        "progress": _progress(reading, failed),
        "failures": failures,
        "failed": failed,
        "responses": response_rows(saved, result),
        "parameters": parameter_rows(saved, result),
        "provisional": result is not None and result is not saved.result,
        **_of_live(reading),
        "several": several_tests(reading.requests) or saved.in_holdouts,
        "notices": [in_words(saved, notice) for notice in _notices(reading)],
        "stop": _stop(reading),
        "report": _has_report(reading),
        "shown": MOST_ROWS,
    }


def _without_calibration(reading: Reading) -> dict[str, Any]:
    line = messages.STARTING if reading.is_running else messages.NOTHING_THERE
    if reading.fault:
        line = messages.UNREADABLE
    details = [plain(reading.fault)] if reading.fault else []
    grade = "bad" if reading.fault else "warn"
    state = "unreadable" if reading.fault else "not started"
    return {
        "name": plain(reading.folder.absolute().name),
        "folder": plain(str(reading.folder)),
        "state": state,
        "title": state,
        "started": None,
        "verdict": {"grade": grade, "mark": "!", "line": line(), "details": details},
        "progress": None,
        **{key: [] for key in _LISTS},
        "failed": 0,
        "run_counts": {},
        "provisional": False,
        "several": False,
        "stop": {"possible": False, "why": ""},
        "report": False,
        "shown": MOST_ROWS,
    }


def _verdict(reading: Reading, so_far: Result | None, estimate: Sequence[str]) -> dict[str, Any]:
    assert reading.saved is not None, "there is a calibration"
    if reading.saved.in_holdouts:
        holdouts = reading.saved.result.holdouts if reading.saved.result else ()
        ended = [one for one in holdouts if one.state != "pending"]
        details = [*filter(None, [plain(holdouts_in_short(ended))]), messages.VERDICT_STAYS()]
        return _in_progress(messages.HOLDOUTS_UNDER_WAY(), details)
    if reading.is_running:
        return _verdict_so_far(so_far, estimate)
    if reading.is_held and reading.saved.result is None and reading.saved.state != "failed":
        return _in_progress(messages.LAST_RUN_ENDED(), [messages.WRITING_RESULT()])
    # Intervals are shown beside the parameters; the analysis would take seconds.
    found = shown_verdict(ReportContext(reading.saved, Analysis()))
    return {
        "grade": found.grade,
        "mark": found.mark,
        "line": found.line,
        "details": list(found.details),
    }


def _verdict_so_far(so_far: Result | None, estimate: Sequence[str]) -> dict[str, Any]:
    if so_far is None or so_far.probability_all_met is None:
        details = [messages.TOO_FEW_RUNS(), *map(plain, estimate)]
        return _in_progress(messages.FIRST_RUNS(), details)
    missed = [name for name, found in so_far.responses.items() if found.verdict == "missed"]
    missed += [name for name, found in so_far.curves.items() if found.verdict == "missed"]
    likely = probability(so_far.probability_all_met)
    details = [messages.ABOUT_SO_FAR()]
    if missed:
        details.append(messages.MISSED_SO_FAR(targets=", ".join(map(plain, missed))))
    details += [plain(str(one)) for one in so_far.out_of_reach]
    details += [plain(str(one)) for one in so_far.reasons if isinstance(one, Deterministic)]
    return _in_progress(messages.SO_FAR(probability=likely), details)


def _in_progress(line: str, details: list[str]) -> dict[str, Any]:
    return {"grade": "run", "mark": "…", "line": line, "details": details}


def _progress(reading: Reading, failed: int) -> dict[str, Any] | None:
    saved, live = reading.saved, reading.live
    assert saved is not None, "there is a calibration"
    ended = sum(len(evaluation.runs) for evaluation in saved.evaluations)
    holdouts = saved.result.holdouts if saved.result and not saved.in_holdouts else ()
    done = ended + sum(one.runs for one in holdouts)
    failed += sum(one.failed for one in holdouts)
    known = {"done": done, "failed": failed, "workers": saved.workers}
    if live is None:
        return known | {"stage": "", "left": None, "seconds_left": None, "estimated": None}
    if live.stage == HOLDOUT_STAGE:
        # Its process counts those of this stage.
        known |= {"done": ended + live.done, "failed": failed + live.failed}
    else:
        known |= {"done": max(ended, live.done)}
    return known | {
        "stage": _STAGES.get(live.stage, plain(live.stage)),
        "left": list(live.left),
        "seconds_left": None if live.seconds_left is None else list(live.seconds_left),
        "estimated": live.estimated,
    }


def _of_live(reading: Reading) -> dict[str, Any]:
    if reading.saved is None or reading.live is None:
        return {"runs": [], "run_counts": {}, "jobs": []}
    runs, counts = run_rows(reading.saved, reading.requests, reading.live)
    return {"runs": runs, "run_counts": counts, "jobs": job_rows(reading.live.jobs)}


def _notices(reading: Reading) -> Sequence[str]:
    if reading.live is not None:
        return reading.live.notices
    if reading.saved is None or reading.saved.result is None:
        return ()
    shown = shown_verdict(ReportContext(reading.saved, Analysis())).details
    return [notice for notice in reading.saved.result.notices if plain(notice) not in shown]


def _stop(reading: Reading) -> Mapping[str, Any]:
    why = reading.why_not_stopped
    if why == NOT_IN_USE():
        # It ended while it was read: the next look tells how.
        return {"possible": False, "why": ""}
    return {"possible": reading.is_running and not why, "why": plain(why)}


def _has_report(reading: Reading) -> bool:
    return not reading.is_running and (reading.folder / REPORT_NAME).is_file()
