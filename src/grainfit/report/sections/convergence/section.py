"""Convergence: deviation from the measurements, run by run."""

from __future__ import annotations

from grainfit.plots.convergence_figures import convergence_figures
from grainfit.plots.expected_course import checkpoints
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section

_KEY, _TITLE = "convergence", "Convergence"


def convergence(context: ReportContext) -> Section:
    """Largest deviation and every response over the number of the run."""
    evaluations = context.reading.evaluations
    html = fill_template(
        f"{_KEY}/page",
        count=len(evaluations),
        labels=[context.response_label(target.name) for target in context.targets],
        failed=sum(1 for evaluation in evaluations if evaluation.failures),
        expected=bool(checkpoints(context.reading)),
    )
    figures = convergence_figures(context.reading)
    return Section(_KEY, _TITLE, html, {f"{_KEY}-{key}": f for key, f in figures.items()})
