"""Response surfaces and slices: dependence of each response on the parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from grainfit.metamodels.metamodels import Metamodels
from grainfit.plots.style import STAGES, named_runs
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section, waiting, without_metamodel
from grainfit.report.sections.explorer.section import held_at, held_values

_KEY, _TITLE = "surfaces", "How do the responses depend on the parameters?"
#: Values of runs are drawn, not calculated with.
_DIGITS = 6


def surfaces(context: ReportContext) -> Section:
    """Contours over two parameters and slices along each, drawn in the page.

    The metamodels are those of the explorer's data: a grid for every pair of parameters and every
    response would be too much to ship.
    """
    metamodels = context.analysis.metamodels
    if metamodels is None:
        return waiting(context, _KEY, _TITLE)
    across, up = _leading_pair(context, metamodels)
    html = fill_template(
        f"{_KEY}/page",
        parameters=[context.parameter_label(p.name) for p in context.parameters],
        responses=[context.response_label(t.name) for t in metamodels.problem.targets],
        missing=without_metamodel(context),
        hardest=_hardest(context, metamodels),
        across=across,
        up=up,
        held_at=held_at(context),
        has_answer=bool(context.answer),
    )
    return Section(_KEY, _TITLE, html, data=_data(context, metamodels))


def _hardest(context: ReportContext, metamodels: Metamodels) -> int:
    """Return the response that may be furthest from its measurement, in tolerances."""
    targets = metamodels.problem.targets
    means, variances = metamodels.predict(metamodels.problem.to_unit(held_values(context)))
    values = np.array([target.value for target in targets])
    tolerances = np.array([target.tolerance for target in targets])
    return int(np.argmax((np.abs(means[0] - values) + 2 * np.sqrt(variances[0])) / tolerances))


def _leading_pair(context: ReportContext, metamodels: Metamodels) -> tuple[int, int]:
    """Return the two parameters that matter most, in the order of the problem.

    By total sensitivity; without it, by the curvature of the responses along them.
    """
    sensitivity = context.analysis.sensitivity
    if sensitivity is not None:
        matters = np.nan_to_num(np.asarray(sensitivity.total, dtype=float)).mean(axis=0)
    else:
        matters = -np.log([model.ranges for model in metamodels.models]).mean(axis=0)
    leading = sorted(int(j) for j in np.argsort(-matters, kind="stable")[:2])
    return leading[0], leading[-1]


def _data(context: ReportContext, metamodels: Metamodels) -> Mapping[str, Any]:
    return {
        "symbols": {stage: symbol for stage, (symbol, _) in STAGES.items()},
        "runs": _runs(context, metamodels),
    }


def _runs(context: ReportContext, metamodels: Metamodels) -> list[Mapping[str, Any]]:
    """All runs that gave a response."""
    return [
        {
            "name": name,
            "stage": evaluation.proposal.stage,
            "values": [
                _rounded(evaluation.proposal.parameters[p.name]) for p in context.parameters
            ],
            "responses": [
                _rounded(evaluation.responses[t.name].value)
                if t.name in evaluation.responses
                else None
                for t in metamodels.problem.targets
            ],
        }
        for name, evaluation in named_runs(context.reading, metamodels.reduction)
        if evaluation.responses
    ]


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
