"""Sensitivity: effect of each parameter on each response, over the intervals."""

from __future__ import annotations

from grainfit.plots.sensitivity_figures import sensitivity_figures
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section, waiting

_KEY, _TITLE = "sensitivity", "Which parameters matter?"


def sensitivity(context: ReportContext) -> Section:
    """Sobol' indices of every response with their intervals, and their meaning in words."""
    found = context.analysis.sensitivity
    if found is None:
        return waiting(context, _KEY, _TITLE)
    drawn = sensitivity_figures(context.reading, found)
    figures = {f"{_KEY}-{row}": figure for row, figure in drawn.items()}
    html = fill_template(
        f"{_KEY}/page",
        responses=[
            {
                "label": context.response_label(name),
                "sentence": context.in_words(sentence),
                "figure": f"{_KEY}-{row}" if row in drawn else "",
            }
            for row, (name, sentence) in enumerate(
                zip(found.responses, found.in_words(), strict=True)
            )
        ],
    )
    return Section(_KEY, _TITLE, html, figures)
