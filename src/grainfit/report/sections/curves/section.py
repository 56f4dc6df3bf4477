"""Measured curves against simulated ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grainfit.formatting import counted, number, plain, plain_probability
from grainfit.plots.curves_figures import curve_figures
from grainfit.problem import CurveTarget
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section

_KEY, _TITLE = "curves", "Do the simulated curves follow the measured ones?"


def curves(context: ReportContext) -> Section | None:
    """Each measured curve with runs, expected curve and band; None when no curve was measured."""
    targets = context.reading.problem.curves
    if not targets:
        return None
    drawn = curve_figures(context.reading, context.analysis)
    figures = {f"{_KEY}-{index}": figure for index, figure in enumerate(drawn.values())}
    rows = [_row(context, target) for target in targets]
    html = fill_template(f"{_KEY}/page", rows=rows, figures=list(figures))
    return Section(_KEY, _TITLE, html, figures)


def _row(context: ReportContext, target: CurveTarget) -> Mapping[str, Any]:
    result = context.reading.result
    found = result.curves.get(target.name) if result else None
    row = {"name": plain(target.name), "points": len(target.values), "verdict": ""}
    if found is None:
        return row
    return row | {
        "verdict": found.verdict,
        "deviation": number(found.deviation, 2),
        "components": found.components,
        "probability": plain_probability(found.probability),
        "shape": plain_probability(found.shape_probability),
        "fresh": counted(found.verified_runs, "fresh seed"),
        "fresh_mean": found.fresh,
    }
