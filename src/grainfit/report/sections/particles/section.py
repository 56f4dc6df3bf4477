"""Particles at the end of a bulk test: those of the answer, and across the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from grainfit.bulk_tests.registry import bulk_tests, class_of_test
from grainfit.bulk_tests.view import RunView, shown
from grainfit.formatting import in_a_row, number, unit_for_people, with_unit
from grainfit.measurement.drawing import Drawing
from grainfit.plots.labels import Label
from grainfit.problem import Target
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.particles.drawn_scenes import scene_of, scenes_of_one_scale
from grainfit.report.sections.particles.shown_runs import (
    ShownRun,
    at_corners,
    first_readable,
    measured,
    picture,
    runs_to_show,
    shown_response,
    shown_runs,
    shown_target,
)

#: Parameters whose corners are shown in the strip, and parameters that are named below each.
_CORNERS = 2
_NAMED = 3


@dataclass(frozen=True)
class StripRun:
    """A run of the strip: its silhouette, and the values of some parameters."""

    key: str
    number: int
    value: str
    expected: str
    met: bool
    drawing: Drawing
    values: Sequence[tuple[Label, str]]


@dataclass(frozen=True)
class SeenTest:
    """View of one bulk test on the page."""

    noun: str
    response: str
    words: str
    target: str
    chosen: bool
    key: str = ""
    title: str = ""
    value: str = ""
    measured: str = ""
    drawing: Drawing | None = None
    picture: str | None = None
    particles: int = 0
    height: str = ""
    strip: Sequence[StripRun] = ()
    strip_width: int = 1
    strip_height: int = 1


def particles(context: ReportContext) -> Section:
    """Silhouette beside its target, the particles in three dimensions, and runs compared."""
    reading = context.reading
    tests = shown_runs(reading.evaluations, reading.records, reading.folder)
    views: list[SeenTest] = []
    data: dict[str, Any] = {}
    for position, (test, runs) in enumerate(tests.items(), 1):
        key = f"particles-{position}"
        view, scenes = _view(context, key, test if len(tests) > 1 else "", runs)
        views.append(view)
        data.update(scenes)
    drawn = [name for name, test in bulk_tests().items() if shown(test) is not None]
    nouns = dict.fromkeys(view.noun for view in views)
    html = fill_template(
        "particles/page", views=views, begun=bool(reading.evaluations), drawn=in_a_row(drawn, "or")
    )
    title = f"The {next(iter(nouns))}" if len(nouns) == 1 else "The particles"
    return Section("particles", title, html, data=data)


def _view(
    context: ReportContext, key: str, title: str, runs: list[ShownRun]
) -> tuple[SeenTest, dict[str, Any]]:
    seen, view = seen_test(context, runs)
    strip, scenes = _strip(context, key, runs, shown_target(context.reading, runs))
    seen = replace(
        seen,
        key=key,
        title=title,
        strip=strip,
        strip_width=max((run.drawing.half_width for run in strip), default=1),
        strip_height=max((run.drawing.height for run in strip), default=1),
    )
    return seen, scenes if view is None else {key: scene_of(view), **scenes}


def seen_test(context: ReportContext, runs: list[ShownRun]) -> tuple[SeenTest, RunView | None]:
    """Return a test with the picture of its best run, and that run; None if it cannot be read."""
    target = shown_target(context.reading, runs)
    candidates, words = runs_to_show(context.reading, runs, target)
    found = first_readable(candidates)
    seen = SeenTest(
        noun=runs[0].shown.noun if runs else "particles",
        response=shown_response(runs),
        words=words,
        target=""
        if target is None
        else measured(target, context.reading.problem, _unit(runs, target)),
        chosen=len(context.parameters) > _NAMED,
    )
    if found is None:
        images = (picture(run) for run in candidates[:5])
        return replace(seen, picture=next((image for image in images if image), None)), None
    run, view = found
    value = with_unit(number(run.value, 3), _unit([run], target))
    return replace(_with_particles(seen, run, view, target), value=value), view


def _with_particles(
    seen: SeenTest, run: ShownRun, view: RunView, target: Target | None
) -> SeenTest:
    drawn = view.measured_drawing(None if target is None else target.value)
    top = float((view.particles.positions[:, 2] + view.particles.radii).max())
    return replace(
        seen,
        words=f"{seen.words}: run {run.number}",
        measured=drawn.words,
        drawing=drawn.drawing,
        particles=len(view.particles),
        height=_length(top),
    )


def _unit(runs: list[ShownRun], target: Target | None) -> str:
    """The unit of the response shown: that of the test, else of the target."""
    test = class_of_test(runs[0].record.definition) if runs else None
    info = test.responses.get(runs[0].shown.response) if test else None
    return unit_for_people(info.unit if info else target.unit if target else "")


def _strip(
    context: ReportContext, key: str, runs: list[ShownRun], target: Target | None
) -> tuple[list[StripRun], dict[str, Any]]:
    names = _named(context, target)
    shown = at_corners(runs, context.reading.problem, names[:_CORNERS])
    values = [run.value for run, _ in shown]
    if target is not None and shown and max(values) - min(values) < target.tolerance:
        # They look alike, and tell nothing.
        return [], {}
    strip = []
    for position, (run, view) in enumerate(shown, 1):
        mean = _mean_over_seeds(context, run, target)
        value = run.value if mean is None else mean
        strip.append(
            StripRun(
                key=f"{key}-run-{position}",
                number=run.number,
                value=with_unit(number(run.value, 3), _unit([run], target)),
                expected="" if mean is None else with_unit(number(mean, 3), _unit([run], target)),
                met=target is not None and target.is_met_by(value),
                drawing=view.measured_drawing(None).drawing,
                values=[_named_value(context, run, name) for name in names],
            )
        )
    scenes = scenes_of_one_scale([view for _, view in shown])
    return strip, dict(zip((run.key for run in strip), scenes, strict=True))


def _mean_over_seeds(context: ReportContext, run: ShownRun, target: Target | None) -> float | None:
    """Return the response that is expected where a run was made; None without a metamodel."""
    metamodels = context.analysis.metamodels
    names = [known.name for known in metamodels.problem.targets] if metamodels else []
    if metamodels is None or target is None or target.name not in names:
        return None
    point = metamodels.problem.to_unit(run.evaluation.proposal.parameters)
    found = float(metamodels.predict(point)[0][0, names.index(target.name)])
    return found / metamodels.problem.ratios.get(target.name, 1.0)


def _named_value(context: ReportContext, run: ShownRun, name: str) -> tuple[Label, str]:
    label = context.parameter_label(name)
    value = run.evaluation.proposal.parameters[name]
    return label, with_unit(number(value, 3), label.unit)


def _named(context: ReportContext, target: Target | None) -> list[str]:
    """The parameters with the largest effect on the response shown."""
    names = [parameter.name for parameter in context.parameters]
    sensitivity = context.analysis.sensitivity
    if target is None or sensitivity is None or target.name not in sensitivity.responses:
        return names[:_NAMED]
    shares = np.asarray(sensitivity.total)[list(sensitivity.responses).index(target.name)]
    order = dict(zip(sensitivity.names, shares.tolist(), strict=True))
    return sorted(names, key=lambda name: -order.get(name, 0.0))[:_NAMED]


def _length(metres: float) -> str:
    if metres >= 1:
        return f"{number(metres, 3)} m"
    return f"{number(1000 * metres, 3)} mm"
