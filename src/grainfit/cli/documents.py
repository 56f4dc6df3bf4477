"""JSON documents of the command line, see docs/command_line.md."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import scalars

if TYPE_CHECKING:
    from grainfit.atlas.estimate import Estimate
    from grainfit.calibration_file.plan import Plan
    from grainfit.campaign.store.records import RunRecord
    from grainfit.result import Result
    from grainfit.work_folder.run_columns import RunColumns
    from grainfit.work_folder.status import WorkdirStatus

#: Raised when a key changes its meaning or goes; new keys do not raise it.
DOCUMENT_VERSION = 1

AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON document, for other programs.")
]


def json_is_wanted() -> bool:
    """Return whether the command line asks for JSON, also when it cannot be understood."""
    return "--json" in sys.argv[1:]


def print_document(kind: str, content: Mapping[str, Any]) -> None:
    """Print a document on standard output."""
    document = {"document": kind, "document_version": DOCUMENT_VERSION, **content}
    # Escaped to ASCII: it is the same on every terminal, also with text that is not valid Unicode.
    typer.echo(json.dumps(_plain(document), indent=2, allow_nan=False))


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: numbers that are not finite are null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, datetime):
        return value.isoformat(timespec="seconds")
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(entry) for entry in value]
    return str(value) if isinstance(value, Path) else value


def status_document(folder: Path, status: WorkdirStatus) -> dict[str, Any]:
    """Return the progress of the calibration in a work folder."""
    return {
        "folder": folder,
        "name": status.name,
        "state": status.state,
        "failure": status.failure,
        "stages": {
            stage: {"asked": asked, "ended": status.finished.get(stage, 0)}
            for stage, asked in status.asked.items()
        },
        "running": status.running,
        "waiting": status.waiting,
        "failed": [asdict(run) for run in status.failed],
        "failed_in_holdouts": status.failed_in_holdouts,
        "kept": status.kept,
        "parameters": _parameters(status.result) if status.result else None,
        "holdouts": [asdict(one) for one in status.result.holdouts] if status.result else [],
        "result_fault": status.result_fault,
    }


def _parameters(result: Result) -> dict[str, Any]:
    nothing = {"low": None, "high": None, "determination": None, "bias": ""}
    intervals = {name: asdict(found) for name, found in result.intervals.items()}
    return {
        name: {"value": value, "unit": result.units.get(name, ""), **intervals.get(name, nothing)}
        for name, value in result.parameters.items()
    }


def result_document(folder: Path, result: Result) -> dict[str, Any]:
    """Return a result, as result.json has it."""
    return {"folder": folder, "result": result.to_dict()}


def runs_document(source: str, total: int, runs: RunColumns) -> dict[str, Any]:
    """Return runs, one entry for each, without curves and logs."""
    return {
        "source": source,
        "total": total,
        "units": runs.parameter_units,
        "runs": [
            {**_run(runs, row), "responses": _measured(scalars(record.responses))}
            for row, record in enumerate(runs.records)
        ],
    }


def run_document(runs: RunColumns, folder: Path | None) -> dict[str, Any]:
    """Return all that is known of the only run in a table."""
    [record] = runs.records
    return {
        "units": runs.parameter_units,
        "run": {
            **_run(runs, 0),
            "responses": _measured(record.responses),
            "log_tail": record.log_tail,
            "definition": record.definition.to_json(),
            "folder": folder,
        },
    }


def _run(runs: RunColumns, row: int) -> dict[str, Any]:
    from grainfit.work_folder.run_columns import COMMON_COLUMNS

    record: RunRecord = runs.records[row]
    common = {name: runs.values[name][row] for name in COMMON_COLUMNS}
    return {**common, "parameters": record.definition.parameters}


def _measured(responses: Mapping[str, Any]) -> dict[str, Any]:
    return {name: asdict(found) for name, found in responses.items()}


def plan_document(file: Path, plan: Plan) -> dict[str, Any]:
    """Return the plan of a calibration."""
    return {
        "file": file,
        "name": plan.name,
        "is_ready": not plan.problems,
        "parameters": [
            _fields(one, "name", "minimum", "maximum", "scale", "unit") for one in plan.parameters
        ],
        "targets": [_fields(one, "name", "value", "tolerance", "unit") for one in plan.targets],
        "curves": [
            {
                **_fields(curve, "name", "unit", "coordinate", "coordinate_unit"),
                "points": len(curve.values),
            }
            for curve in plan.curves
        ],
        "apparatus": {
            test: [asdict(value) for value in values] for test, values in plan.apparatus.items()
        },
        "plan": [line.strip() for line in plan.lines],
        "notes": plan.notes,
        "findings": [asdict(finding) for finding in plan.findings],
        "runs": plan.runs,
        "seconds": plan.seconds,
        "executes": plan.executes,
        "problems": plan.problems,
    }


def estimate_document(file: Path | None, found: Estimate) -> dict[str, Any]:
    """Return an estimate by the atlas; SI units, as everywhere."""
    return {
        "file": file,
        "status": "estimate: not simulated",
        "parameters": {
            one.parameter.name: {
                "value": found.best[one.parameter.name],
                "unit": one.parameter.unit,
                **_fields(one, "low", "median", "high", "is_open"),
            }
            for one in found.parameters
        },
        "responses": {
            one.target.name: {
                **_fields(one, "value", "standard_error", "scatter", "is_in_reach", "agrees"),
                "unit": one.target.unit,
                "measured": _fields(one.target, "value", "tolerance"),
            }
            for one in found.responses
        },
        "untold": found.untold,
        "less_sure": found.less_sure,
        "left_out": found.left_out,
        "doubts": found.doubts,
        "chance": found.chance,
        "runs": found.runs,
        "seconds": found.seconds,
        "further": [
            {**_fields(one, "test", "response", "left"), "accuracy": asdict(one.accuracy)}
            for one in found.further
        ],
    }


def _fields(source: object, *names: str) -> dict[str, Any]:
    return {name: getattr(source, name, None) for name in names}


def error_document(error: BaseException, message: str, code: int) -> dict[str, Any]:
    """Return an error that ended a command, and its exit code."""
    faults = error.faults if isinstance(error, InputError) else ()
    source = error.source if isinstance(error, InputError) else ""
    return {
        "exit_code": code,
        "kind": type(error).__name__,
        "message": message,
        "source": source,
        "faults": [_fields(fault, "key", "line", "message", "remedy") for fault in faults],
        "log_tail": error.log_tail if isinstance(error, RunFailedError) else "",
    }
