"""Predicted against simulated: how far the metamodels can be trusted, by leaving runs out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.formatting import plain
from grainfit.metamodels.kriging import NORMAL_QUANTILE, POOR_Q2, LeaveOneOut
from grainfit.metamodels.metamodels import Metamodels
from grainfit.plots.labels import Label
from grainfit.plots.style import BLUE, QUIET, VERMILION, named_runs
from grainfit.problem import Target
from grainfit.report.rendering import render
from grainfit.report.section import Figure, ReportContext, Section, waiting

_KEY, _TITLE = "predicted", "Can the metamodels be trusted?"
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
    names: Sequence[str]
    simulated: NDArray[np.float64]
    left_out: LeaveOneOut
    scatter: float
    warnings: Sequence[str]

    @property
    def spread(self) -> float:
        return float(self.simulated.std())

    @property
    def is_mostly_scatter(self) -> bool:
        """Whether the scatter from run to run explains that runs are predicted poorly."""
        return self.left_out.q2 < POOR_Q2 and self.scatter**2 >= (1 - POOR_Q2) * self.spread**2

    @property
    def half_widths(self) -> NDArray[np.float64]:
        return np.asarray(NORMAL_QUANTILE * self.left_out.standard_deviation)

    @property
    def inside(self) -> NDArray[np.bool_]:
        return np.asarray(np.abs(self.simulated - self.left_out.predicted) <= self.half_widths)


def predicted(context: ReportContext) -> Section:
    """Each run against what the metamodel of all other runs expects of it."""
    metamodels = context.analysis.metamodels
    if metamodels is None:
        return waiting(context, _KEY, _TITLE)
    checks = [_check(context, metamodels, index) for index in range(len(metamodels.models))]
    figures = {f"{_KEY}-{index}": _figure(check) for index, check in enumerate(checks)}
    html = render(
        f"{_KEY}/page",
        checks=[_words(check) for check in checks],
        figures=list(figures),
        notes=_notes(context),
    )
    return Section(_KEY, _TITLE, html, figures)


def _notes(context: ReportContext) -> list[str]:
    """What the reader should know of all that follows from the runs."""
    posterior = context.analysis.posterior
    elsewhere = {posterior.convergence} if posterior else set()
    return [plain(note) for note in context.analysis.notes if note not in elsewhere]


def _check(context: ReportContext, metamodels: Metamodels, index: int) -> _Check:
    target, model = metamodels.problem.targets[index], metamodels.models[index]
    # What a metamodel rests on, it knows best: of many runs, some are left out.
    known = model.to_plain(factors=False)
    simulated = known["offset"] + known["scale"] * np.array(known["values"])
    runs = [tuple(point) for point in known["points"]]
    quality = context.analysis.quality.get(target.name)
    return _Check(
        target,
        context.response_label(target.name),
        _names(context, metamodels, target, list(zip(runs, simulated, strict=True))),
        simulated,
        model.leave_one_out(),
        model.noise_standard_deviation,
        [plain(text) for text in quality.warnings] if quality else [],
    )


def _names(
    context: ReportContext,
    metamodels: Metamodels,
    target: Target,
    runs: Sequence[tuple[tuple[float, ...], float]],
) -> list[str]:
    """Names of runs, by their place and response."""
    known: dict[tuple[float, ...], list[tuple[float, str]]] = {}
    for name, evaluation in named_runs(context.reading):
        if target.name in evaluation.responses:
            point = tuple(metamodels.problem.to_unit(evaluation.proposal.parameters).tolist())
            value = evaluation.responses[target.name].value
            known.setdefault(point, []).append((value, name))
    return [min(known[point], key=lambda run: abs(run[0] - value))[1] for point, value in runs]


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
        "is_mostly_scatter": check.is_mostly_scatter,
        "spread": check.spread,
        "scatter": check.scatter,
        "runs": len(check.names),
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
        "line": {"color": QUIET, "width": 1.5, "dash": "dot"},
        "hoverinfo": "skip",
        "name": "predicted as simulated",
    }
    axis = {"range": reach, "zeroline": False}
    return Figure(
        data=(
            diagonal,
            _points(check, check.inside, "inside its 95 % interval", BLUE, "circle"),
            _points(check, ~check.inside, "outside", VERMILION, "diamond"),
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
            [name, float(width)]
            for name, width, kept in zip(check.names, check.half_widths, chosen, strict=True)
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
            "%{customdata[0]}<br>simulated %{x:.4g}<br>"
            "predicted %{y:.4g} ± %{customdata[1]:.2g}<extra></extra>"
        ),
    }
