"""What the tests leave open: verdicts in words first, then what they rest on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from grainfit.analysis import Posterior
from grainfit.analysis.identifiability import DETERMINED, OPEN
from grainfit.formatting import number, plain
from grainfit.plots.style import BLUE, ORANGE, QUIET, VERMILION
from grainfit.problem import Parameter
from grainfit.report.rendering import render
from grainfit.report.section import Figure, ReportContext, Section, waiting, without_metamodel

_KEY, _TITLE = "undetermined", "What do the tests not determine?"
_BINS = 30
#: Of logarithms: a bound that is a power of ten is not missed.
_ROUNDING = 1e-9
#: More cells are too small for a number in each.
_MOST_NUMBERS = 8
_CELL = 44
_BAR = 30
_FRAME_HEIGHT = 100


def undetermined(context: ReportContext) -> Section:
    """Verdicts, further tests, correlations, and how much was learnt of each parameter."""
    posterior, found = context.posterior, context.analysis.identifiability
    if posterior is None or found is None:
        return waiting(context, _KEY, _TITLE, context.why_no_posterior)
    figures = {f"{_KEY}-learnt": _learnt(context, posterior, found.narrowing)}
    if len(posterior.names) > 1:
        figures[f"{_KEY}-correlations"] = _correlations(context, posterior)
    histograms = {
        f"{_KEY}-marginal-{index}": _marginal(context, posterior, index)
        for index in range(len(posterior.names))
    }
    html = render(
        f"{_KEY}/page",
        verdicts=[plain(verdict) for verdict in found.verdicts],
        further_tests=[plain(test) for test in found.further_tests],
        missing=without_metamodel(context),
        figures=list(figures),
        marginals=[
            {
                "figure": key,
                "label": context.parameter_label(name),
                "between": _between(posterior, name),
            }
            for key, name in zip(histograms, posterior.names, strict=True)
        ],
        converged=posterior.converged,
        convergence=plain(posterior.convergence),
        has_answer=bool(context.answer),
    )
    return Section(_KEY, _TITLE, html, figures | histograms)


def _between(posterior: Posterior, name: str) -> str:
    low, high = posterior.interval(name)
    return f"{number(low, 3)} to {number(high, 3)}"


def _learnt(context: ReportContext, posterior: Posterior, narrowing: Mapping[str, float]) -> Figure:
    # Plotly draws the first category at the bottom.
    parameters = [p for p in reversed(context.parameters) if p.name in narrowing]
    shares = [1.0 - narrowing[p.name] for p in parameters]
    return Figure(
        data=(
            {
                "type": "bar",
                "orientation": "h",
                "x": shares,
                "y": list(range(len(parameters))),
                "marker": {"color": [_color(narrowing[p.name]) for p in parameters]},
                "text": [f"{share:.0%}" for share in shares],
                "textposition": "outside",
                "cliponaxis": False,
                "customdata": [
                    [
                        _between(posterior, p.name),
                        f"{number(p.minimum, 3)} to {number(p.maximum, 3)}",
                    ]
                    for p in parameters
                ],
                "hovertemplate": (
                    "with 95 % probability from %{customdata[0]}<br>"
                    "sought from %{customdata[1]}<extra></extra>"
                ),
            },
        ),
        layout={
            "xaxis": {
                "range": [0, 1.12],
                "tickvals": [0, 0.25, 0.5, 0.75, 1],
                "tickformat": ".0%",
                "title": {"text": "share of the interval ruled out"},
            },
            "yaxis": {
                "tickvals": list(range(len(parameters))),
                "ticktext": [context.parameter_label(p.name).plot for p in parameters],
                "range": [-0.6, len(parameters) - 0.4],
                "zeroline": False,
            },
        },
        description="Share of each parameter's interval that the measurements rule out.",
        height=_FRAME_HEIGHT + _BAR * len(parameters),
    )


def _color(narrowing: float) -> str:
    if narrowing <= DETERMINED:
        return BLUE
    return VERMILION if narrowing >= OPEN else ORANGE


def _correlations(context: ReportContext, posterior: Posterior) -> Figure:
    names, found = posterior.names, posterior.correlations
    labels = [context.parameter_label(name).plot for name in names]
    last = len(names) - 1
    # Each pair once; that a parameter goes with itself tells nothing.
    cells = [(row, column) for row in range(1, len(names)) for column in range(row)]
    heat = {
        "type": "heatmap",
        "x": list(range(last)),
        "y": list(range(1, last + 1)),
        "z": [
            [float(found[row, column]) if column < row else None for column in range(last)]
            for row in range(1, last + 1)
        ],
        "text": [
            [f"{labels[row]} and {labels[column]}" for column in range(last)]
            for row in range(1, last + 1)
        ],
        "zmin": -1,
        "zmax": 1,
        # Seen through, so that numbers stand out on light and on dark paper.
        "colorscale": [
            [0, "rgba(213, 94, 0, 0.6)"],
            [0.5, "rgba(136, 136, 136, 0.1)"],
            [1, "rgba(0, 114, 178, 0.6)"],
        ],
        "colorbar": {"thickness": 12, "outlinewidth": 0, "tickvals": [-1, 0, 1]},
        "xgap": 2,
        "ygap": 2,
        "hovertemplate": "%{text}: %{z:.2f}<extra></extra>",
        "hoverongaps": False,
    }
    numbers = [
        {"x": column, "y": row, "text": _signed(found[row, column]), "showarrow": False}
        for row, column in cells
    ]
    return Figure(
        data=(heat,),
        layout={
            "xaxis": {
                "tickvals": heat["x"],
                "ticktext": labels[:-1],
                "showgrid": False,
                "zeroline": False,
            },
            "yaxis": {
                "tickvals": heat["y"],
                "ticktext": labels[1:],
                "showgrid": False,
                "zeroline": False,
                "autorange": "reversed",
            },
            "annotations": numbers if len(names) <= _MOST_NUMBERS else [],
        },
        description=(
            "Rank correlations of the parameters among the sets that agree with the measurements."
        ),
        height=_FRAME_HEIGHT + max(_CELL * last, 2 * _CELL),
    )


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def _marginal(context: ReportContext, posterior: Posterior, index: int) -> Figure:
    parameter = next(p for p in context.parameters if p.name == posterior.names[index])
    counts, edges = np.histogram(posterior.points[:, index], bins=_BINS, range=(0.0, 1.0))
    values = [parameter.from_unit(float(edge)) for edge in edges]
    heights = (counts / counts.max()).tolist()
    layout: dict[str, Any] = {
        "xaxis": _axis(context, parameter),
        "yaxis": {"range": [0, 1.08], "showticklabels": False, "ticks": "", "showgrid": False},
        "showlegend": False,
        "margin": {"l": 20, "r": 20, "t": 6, "b": 40},
    }
    if context.answer:
        layout["shapes"] = [_line_at(context.answer[parameter.name])]
    return Figure(
        data=(
            {
                "type": "scatter",
                "mode": "lines",
                "x": values,
                "y": [*heights, heights[-1]],
                "line": {"shape": "hv", "color": BLUE, "width": 1.5},
                "fill": "tozeroy",
                "fillcolor": "rgba(0,114,178,0.35)",
                "hovertemplate": "%{x:.4g}: %{y:.0%} as probable as the likeliest<extra></extra>",
            },
        ),
        layout=layout,
        description=(
            f"How probable each value of {plain(parameter.name)} is, given the measurements; 95 % "
            f"of the probability is from {_between(posterior, parameter.name)}."
        ),
        height=170,
    )


def _axis(context: ReportContext, parameter: Parameter) -> Mapping[str, Any]:
    common = {
        "title": {"text": context.parameter_label(parameter.name).axis},
        "zeroline": False,
        "ticklabeloverflow": "allow",
    }
    if parameter.scale == "linear":
        return {**common, "range": [parameter.minimum, parameter.maximum], "nticks": 5}
    low, high = math.log10(parameter.minimum), math.log10(parameter.maximum)
    powers = range(math.floor(low), math.floor(high + _ROUNDING) + 1)
    factors = (1, 2, 5) if high - low < 2 else (1,)
    ticks = [float(f"{factor}e{power}") for power in powers for factor in factors]
    ticks = [t for t in ticks if low - _ROUNDING <= math.log10(t) <= high + _ROUNDING]
    if len(ticks) < 2:
        ticks = [parameter.minimum, parameter.maximum]
    return {
        **common,
        "type": "log",
        "range": [low, high],
        "tickvals": ticks,
        "ticktext": [number(tick, 3) for tick in ticks],
    }


def _line_at(value: float) -> Mapping[str, Any]:
    return {
        "type": "line",
        "x0": value,
        "x1": value,
        "yref": "paper",
        "y0": 0,
        "y1": 1,
        "line": {"color": QUIET, "width": 1.5, "dash": "dot"},
    }
