"""Predicted against simulated: how far the metamodels can be trusted, by leaving runs out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.kriging import LeaveOneOut
from grainfit.printable import plain
from grainfit.problem import Target
from grainfit.report.labels import Label
from grainfit.report.palette import BLUE, GREY, VERMILLION
from grainfit.report.rendering import render
from grainfit.report.section import Figure, ReportContext, Section
from grainfit.report.waiting import waiting
from grainfit.strategies.metamodels import runs_that_yield

_KEY, _TITLE = "predicted", "Can the metamodels be trusted?"
_NORMAL_QUANTILE = 1.959963984540054
_JUDGEMENTS = (
    (0.9, "very well", "good"),
    (0.7, "well", "good"),
    (0.5, "roughly", "warn"),
    (-math.inf, "hardly", "bad"),
)


@dataclass(frozen=True)
class _Check:
    """Runs of one response against what the others predict of them."""

    target: Target
    label: Label
    numbers: Sequence[int]
    simulated: NDArray[np.float64]
    left_out: LeaveOneOut
    warnings: Sequence[str]

    @property
    def half_widths(self) -> NDArray[np.float64]:
        return np.asarray(_NORMAL_QUANTILE * self.left_out.standard_deviation)

    @property
    def inside(self) -> NDArray[np.bool_]:
        return np.asarray(np.abs(self.simulated - self.left_out.predicted) <= self.half_widths)


def predicted(context: ReportContext) -> Section:
    """Each run against what the metamodel of all other runs expects of it."""
    if context.analysis.metamodels is None:
        return waiting(context, _KEY, _TITLE)
    checks = [_check(context, index) for index in range(len(context.targets))]
    figures = {f"{_KEY}-{index}": _figure(check) for index, check in enumerate(checks)}
    html = render(_KEY, checks=[_words(check) for check in checks], figures=list(figures))
    return Section(_KEY, _TITLE, html, figures)


def _check(context: ReportContext, index: int) -> _Check:
    assert context.analysis.metamodels is not None
    target = context.targets[index]
    evaluations = context.reading.evaluations
    runs = runs_that_yield(evaluations, target.name)
    numbers = {id(evaluation): n for n, evaluation in enumerate(evaluations, start=1)}
    quality = context.analysis.quality.get(target.name)
    return _Check(
        target,
        context.response_label(target.name),
        [numbers[id(run)] for run in runs],
        np.array([run.responses[target.name].value for run in runs]),
        context.analysis.metamodels.models[index].leave_one_out(),
        [plain(text) for text in quality.warnings] if quality else [],
    )


def _words(check: _Check) -> Mapping[str, Any]:
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
        "runs": len(check.numbers),
        "inside": int(check.inside.sum()),
        "warnings": check.warnings,
    }


def _figure(check: _Check) -> Figure:
    label, half = check.label, check.half_widths
    simulated, expected = check.simulated, check.left_out.predicted
    low = float(min(simulated.min(), (expected - half).min()))
    high = float(max(simulated.max(), (expected + half).max()))
    margin = 0.04 * (high - low) or 0.01 * abs(high) or 1.0
    reach = [low - margin, high + margin]
    diagonal = {
        "type": "scatter",
        "mode": "lines",
        "x": reach,
        "y": reach,
        "line": {"color": GREY, "width": 1.5, "dash": "dot"},
        "hoverinfo": "skip",
        "name": "predicted as simulated",
    }
    axis = {"range": reach, "zeroline": False}
    return Figure(
        data=(
            diagonal,
            _points(check, check.inside, "inside its 95 % interval", BLUE, "circle"),
            _points(check, ~check.inside, "outside", VERMILLION, "diamond"),
        ),
        layout={
            "xaxis": {**axis, "title": {"text": f"simulated {label.axis}"}},
            "yaxis": {**axis, "title": {"text": f"predicted {label.axis}"}},
            "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
            "hovermode": "closest",
        },
        description=(
            f"{plain(check.target.name)} of each run as simulated (across) and as predicted from "
            "all other runs, with its 95 % interval (upwards). On the diagonal both are equal."
        ),
        height=400,
    )


def _points(
    check: _Check, chosen: NDArray[np.bool_], name: str, color: str, symbol: str
) -> Mapping[str, Any]:
    half = check.half_widths[chosen]
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": check.simulated[chosen].tolist(),
        "y": check.left_out.predicted[chosen].tolist(),
        "customdata": [
            [number, float(width)]
            for number, width, kept in zip(check.numbers, check.half_widths, chosen, strict=True)
            if kept
        ],
        "error_y": {
            "type": "data",
            "array": half.tolist(),
            "thickness": 1,
            "width": 0,
            "color": color,
        },
        "marker": {"color": color, "symbol": symbol, "size": 7},
        "showlegend": bool(chosen.any()),
        "hovertemplate": (
            "run %{customdata[0]}<br>simulated %{x:.4g}<br>"
            "predicted %{y:.4g} ± %{customdata[1]:.2g}<extra></extra>"
        ),
    }
