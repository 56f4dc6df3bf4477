"""See it: the heap of the calibrated material, and heaps across the range of the parameters."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import Any

import numpy as np

from grainfit.formatting import number, with_unit
from grainfit.measurement.drawing import Drawing
from grainfit.measurement.particles import Particles
from grainfit.plots.labels import Label
from grainfit.problem import Target
from grainfit.report.rendering import render
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.heap.heaps import (
    Heap,
    HeapRun,
    first_readable,
    heap_runs,
    picture,
    spread,
)

#: Heaps in the strip, and parameters that are named below each.
_STRIP = 6
_NAMED = 3
#: Positions are whole numbers of that many to the largest one.
_STEPS = 32_000


@dataclass(frozen=True)
class StripHeap:
    """A heap of the strip: its run, how it looks, and the values of some parameters."""

    number: int
    angle: str
    met: bool
    drawing: Drawing
    values: Sequence[tuple[Label, str]]


@dataclass(frozen=True)
class HeapView:
    """All that is seen of one heap test."""

    key: str
    title: str
    words: str
    target: str
    angle: str
    flanks: int
    drawing: Drawing | None
    picture: str | None
    particles: int
    height: str
    strip: Sequence[StripHeap]
    strip_width: int
    strip_height: int
    chosen: bool


def heap(context: ReportContext) -> Section:
    """Silhouette beside the target angle, the heap in three dimensions, and heaps compared."""
    reading = context.reading
    tests = heap_runs(reading.evaluations, reading.records, reading.folder)
    views, data = [], {}
    for position, (test, runs) in enumerate(tests.items(), 1):
        key = f"heap-{position}"
        view, particles = _view(context, key, test if len(tests) > 1 else "", runs)
        views.append(view)
        if particles is not None:
            data[key] = particles
    html = render("heap/page", views=views, begun=bool(reading.evaluations))
    return Section("heap", "The heap", html, data=data)


def _view(
    context: ReportContext, key: str, title: str, runs: list[HeapRun]
) -> tuple[HeapView, dict[str, Any] | None]:
    target = _target(context, runs)
    candidates, words = _candidates(context, runs, target)
    found = first_readable(candidates)
    strip = _strip(context, runs, target)
    seen = HeapView(
        key=key,
        title=title,
        words=words,
        target="" if target is None else number(target.value, 6),
        angle="",
        flanks=0,
        drawing=None,
        picture=None,
        particles=0,
        height="",
        strip=strip,
        strip_width=max((heap.drawing.half_width for heap in strip), default=1),
        strip_height=max((heap.drawing.height for heap in strip), default=1),
        chosen=len(context.parameters) > _NAMED,
    )
    if found is None:
        images = (picture(run) for run in candidates[:5])
        return replace(seen, picture=next((image for image in images if image), None)), None
    run, heap = found
    return _with_heap(seen, run, heap, target), _particles(heap)


def _with_heap(view: HeapView, run: HeapRun, heap: Heap, target: Target | None) -> HeapView:
    measured = heap.measured()
    wanted = None if target is None else target.value
    drawing = heap.drawing() if measured is None else heap.fitted_drawing(measured, wanted)
    views = () if measured is None else measured.views
    top = float((heap.particles.positions[:, 2] + heap.particles.radii).max())
    return replace(
        view,
        words=f"{view.words}: run {run.number}",
        angle=number(run.angle, 3),
        flanks=sum((v.left is not None) + (v.right is not None) for v in views),
        drawing=drawing,
        particles=len(heap.particles),
        height=_length(top),
    )


def _target(context: ReportContext, runs: list[HeapRun]) -> Target | None:
    """The measured angle of repose of these runs' test."""
    names = {run.response for run in runs}
    return next((target for target in context.targets if target.name in names), None)


def _candidates(
    context: ReportContext, runs: list[HeapRun], target: Target | None
) -> tuple[list[HeapRun], str]:
    """Runs to show, the most telling first, and what they are."""
    answer = context.answer
    verified = [
        run
        for run in runs
        if run.evaluation.proposal.stage == "verification"
        and run.evaluation.proposal.parameters == answer
    ]
    if verified:
        mean = fmean(run.angle for run in verified)
        words = "Of the verification runs, the one whose angle of repose is nearest to their mean"
        return sorted(verified, key=lambda run: abs(run.angle - mean)), words
    if answer:
        point = context.reading.problem.to_unit(answer)

        def distance(run: HeapRun) -> float:
            at = context.reading.problem.to_unit(run.evaluation.proposal.parameters)
            return float(np.linalg.norm(at - point))

        return sorted(runs, key=distance), "The run whose parameters are nearest to the answer"
    if target is not None:
        value = target.value
        words = "The run whose angle of repose is nearest to the measured one so far"
        return sorted(runs, key=lambda run: abs(run.angle - value)), words
    return runs[::-1], "The last run"


def _strip(context: ReportContext, runs: list[HeapRun], target: Target | None) -> list[StripHeap]:
    names = _named(context, target)
    return [
        StripHeap(
            number=run.number,
            angle=number(run.angle, 3),
            met=target is not None and abs(run.angle - target.value) <= target.tolerance,
            drawing=heap.drawing(),
            values=[_named_value(context, run, name) for name in names],
        )
        for run, heap in spread(runs, _STRIP)
    ]


def _named_value(context: ReportContext, run: HeapRun, name: str) -> tuple[Label, str]:
    label = context.parameter_label(name)
    value = run.evaluation.proposal.parameters[name]
    return label, with_unit(number(value, 3), label.unit)


def _named(context: ReportContext, target: Target | None) -> list[str]:
    """The parameters that decide most about the angle of repose."""
    names = [parameter.name for parameter in context.parameters]
    sensitivity = context.analysis.sensitivity
    if target is None or sensitivity is None or target.name not in sensitivity.responses:
        return names[:_NAMED]
    shares = np.asarray(sensitivity.total)[list(sensitivity.responses).index(target.name)]
    order = dict(zip(sensitivity.names, shares.tolist(), strict=True))
    return sorted(names, key=lambda name: -order.get(name, 0.0))[:_NAMED]


def _particles(heap: Heap) -> dict[str, Any]:
    """What the page draws in three dimensions: positions and radii as small whole numbers."""
    shown: Particles = heap.visible()
    table = np.column_stack([shown.positions, shown.radii])
    step = float(np.abs(table).max()) / _STEPS
    packed = np.round(table / step).astype("<i2")
    setup = heap.test.setup
    return {
        "particles": base64.b64encode(packed.tobytes()).decode("ascii"),
        "plate": setup.plate_radius / step,
        "rim": setup.rim_height / step,
    }


def _length(metres: float) -> str:
    if metres >= 1:
        return f"{number(metres, 3)} m"
    return f"{number(1000 * metres, 3)} mm"
