"""Predicted against simulated: leave-one-out check of the metamodels."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from grainfit.formatting import plain
from grainfit.plots.leave_one_out import LeaveOneOutCheck, leave_one_out_checks
from grainfit.plots.predicted_figures import predicted_figure
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section, waiting

_KEY, _TITLE = "predicted", "Can the metamodels be trusted?"
_JUDGEMENTS = (
    (0.9, "very well", "good"),
    (0.7, "well", "good"),
    (0.5, "roughly", "warn"),
    (-math.inf, "hardly", "bad"),
)


def predicted(context: ReportContext) -> Section:
    """Each run against the prediction of the metamodel of all other runs."""
    if context.analysis.metamodels is None:
        return waiting(context, _KEY, _TITLE)
    checks = leave_one_out_checks(context.reading, context.analysis)
    figures = {f"{_KEY}-{index}": predicted_figure(check) for index, check in enumerate(checks)}
    html = fill_template(
        f"{_KEY}/page",
        checks=[_row(check) for check in checks],
        figures=list(figures),
        notes=_notes(context),
    )
    return Section(_KEY, _TITLE, html, figures)


def _notes(context: ReportContext) -> list[str]:
    """Warnings about the metamodels, which concern all sections that use them."""
    posterior = context.analysis.posterior
    elsewhere = {posterior.convergence} if posterior else set()
    return [plain(note) for note in context.analysis.notes if note not in elsewhere]


def _row(check: LeaveOneOutCheck) -> Mapping[str, Any]:
    q2 = check.left_out.q2
    known = math.isfinite(q2)
    judgement, look = next(
        (words, look) for least, words, look in _JUDGEMENTS if not known or q2 >= least
    )
    return {
        "label": check.label,
        "q2": q2 if known else None,
        "judgement": judgement,
        "look": look,
        "is_mostly_scatter": check.is_mostly_scatter,
        "spread": check.spread,
        "scatter": check.scatter,
        "runs": len(check.names),
        "inside": int(check.inside.sum()),
        "warnings": check.warnings,
    }
