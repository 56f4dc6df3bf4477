"""Steps to reproduce the calibration: file, versions, seeds, command."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from datetime import datetime
from importlib.metadata import version

from grainfit.campaign.store.records import RunRecord
from grainfit.formatting import plain, plain_lines
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section


def reproduce(context: ReportContext) -> Section:
    """File, command, versions, seeds, date."""
    reading = context.reading
    html = fill_template(
        "reproduce/page",
        command=_command(context) if reading.source else "",
        source=plain(reading.source),
        text=plain_lines(reading.source_text),
        facts=[
            ("Name", plain(reading.name) or "–"),
            ("Started", _date(reading.started)),
            ("Strategy", plain(reading.strategy)),
            ("Seed", str(reading.seed)),
            ("Runs at a time", str(reading.workers)),
            ("Solver", "; ".join(_solvers(reading.records.values())) or "–"),
            ("grainfit", f"{plain(reading.version) or 'unknown'} (report: {version('grainfit')})"),
            ("Identity", reading.identity),
        ],
    )
    return Section("reproduce", "How to reproduce it", html)


def _command(context: ReportContext) -> str:
    reading = context.reading
    words = ["grainfit", "run", reading.source, "--strategy", reading.strategy]
    words += ["--seed", str(reading.seed), "--workers", str(reading.workers)]
    if reading.max_runs is not None:
        words += ["--max-runs", str(reading.max_runs)]
    return plain(shlex.join(words))


def _date(seconds: float) -> str:
    return datetime.fromtimestamp(seconds).astimezone().strftime("%d %B %Y, %H:%M %Z")


def _solvers(runs: Iterable[RunRecord]) -> list[str]:
    """Solver of the runs, its version, and the test."""
    found: dict[str, None] = {}
    for run in runs:
        solver, release = run.definition.model.get("solver"), run.definition.model.get("version")
        words = f"{solver or 'unknown'} {release}" if release else f"{solver or 'unknown'}"
        found[plain(f"{words} (test {run.test})")] = None
    return list(found)
