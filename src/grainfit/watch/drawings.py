"""Newest particles of every bulk test, and photographs beside simulated heaps."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from grainfit.bulk_tests.registry import class_of_test
from grainfit.formatting import number, plain, unit_for_people, with_unit
from grainfit.report.rendering import script_json
from grainfit.report.sections.particles.drawn_scenes import scene_of
from grainfit.report.sections.particles.shown_runs import (
    ShownRun,
    at_simulated_size,
    first_readable,
    measured,
    picture,
    shown_runs,
)
from grainfit.report.sections.photographs.comparison import compared
from grainfit.report.sections.photographs.section import html_of
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Key of the photographs.
_PHOTOGRAPHS = "photographs"
#: Newest runs that are looked at for particles that can be read.
_TRIES = 3


@dataclass(frozen=True)
class LatestDrawing:
    """The particles of the newest run of a test, or photographs beside simulated heaps.

    Parameters
    ----------
    about : mapping
        What the page shows beside it, with its ``key``, its ``kind`` and the ``run``.
    content : str
        Data of the drawing, the kept picture, or HTML, as JSON.
    """

    about: dict[str, Any]
    content: str


class LatestDrawings:
    """Newest drawings of each test; files are read only when a newer run has ended."""

    def __init__(self) -> None:
        self._calibration = ""
        self._compared: object = None
        self._newest: dict[str, str] = {}
        self._found: dict[str, LatestDrawing] = {}

    def found(self, calibration: str) -> dict[str, LatestDrawing]:
        """Return the drawings of a calibration by key of the test; those of no other one."""
        return self._found if calibration == self._calibration else {}

    def update(self, saved: SavedCalibration) -> None:
        """Read the particles of runs that are newer."""
        if saved.identity != self._calibration:
            self._newest, self._found = {}, {}
            self._calibration = saved.identity
        tests = shown_runs(saved.evaluations, saved.records, saved.folder)
        found = dict(self._found)
        for position, (test, runs) in enumerate(tests.items(), 1):
            newest = sorted(runs, key=lambda run: run.record.ended)[: -_TRIES - 1 : -1]
            if not newest or self._newest.get(test) == newest[0].record.identity:
                continue
            self._newest[test] = newest[0].record.identity
            if latest := _latest(f"test-{position}", test if len(tests) > 1 else "", newest, saved):
                found[f"test-{position}"] = latest
        now = (dict(self._newest), self._calibration, saved.result is not None)
        if now != self._compared:
            self._compared = now
            if photographs := _photographs(saved):
                found[_PHOTOGRAPHS] = photographs
        self._found = found


def _photographs(saved: SavedCalibration) -> LatestDrawing | None:
    comparisons = compared(saved)
    if not comparisons:
        return None
    html = str(html_of(comparisons))
    about = {
        "key": _PHOTOGRAPHS,
        "kind": "page",
        "run": hashlib.sha256(html.encode("utf-8", errors="replace")).hexdigest(),
        "title": "Photographed and simulated",
        "words": "",
        "particles": 0,
        "ended": None,
    }
    return LatestDrawing(about, json.dumps(html))


def _latest(
    key: str, test: str, newest: Sequence[ShownRun], saved: SavedCalibration
) -> LatestDrawing | None:
    seen = first_readable(newest, _TRIES)
    if seen is not None:
        run, view = seen
        count = len(view.particles)
        return LatestDrawing(
            _about(key, test, run, saved) | {"particles": count, "kind": "scene"},
            str(script_json(scene_of(view))),
        )
    images = ((run, picture(run)) for run in newest)
    for run, image in images:
        if image:
            about = _about(key, test, run, saved) | {"particles": 0, "kind": "picture"}
            return LatestDrawing(about, json.dumps(image))
    return None


def _about(key: str, test: str, run: ShownRun, saved: SavedCalibration) -> dict[str, Any]:
    title = f"{run.shown.noun} of test {plain(test)}" if test else run.shown.noun
    return {
        "key": key,
        "run": run.record.identity,
        "title": f"Newest {title}",
        "words": ", ".join(_captions(run, saved)),
        "ended": run.record.ended,
    }


def _captions(run: ShownRun, saved: SavedCalibration) -> Iterator[str]:
    kind = class_of_test(run.record.definition)
    info = kind.responses.get(run.shown.response) if kind else None
    unit = unit_for_people(info.unit) if info else ""
    name = plain(run.shown.response.replace("_", " "))
    yield f"Run {run.number}: {name} {with_unit(number(run.value, 3), unit)}"
    for target in saved.problem.targets:
        if target.name == run.response:
            here = at_simulated_size(target, saved.problem)
            shown = measured(here, saved.problem, unit_for_people(target.unit))
            yield f"measured {shown}"
