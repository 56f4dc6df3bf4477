"""Posterior: distributions, correlations and narrowing of the parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from grainfit.analysis.analysis import Analysis
from grainfit.analysis.identifiability import Identifiability
from grainfit.analysis.posterior import Posterior
from grainfit.formatting import ends, number, plain
from grainfit.materials.card import Determination
from grainfit.plots.arrange import arrange, in_columns
from grainfit.plots.axes import SHARES, parameter_axis
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.labels import label_of_parameter
from grainfit.plots.style import BLUE, ORANGE, QUIET, VERMILION
from grainfit.result import ParameterInterval
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

_BINS = 30
#: With more parameters, the cells are too small for numbers.
_MOST_NUMBERS = 8
_COLORS: Mapping[Determination, str] = {
    "determined": BLUE,
    "determined, but biased": ORANGE,
    "narrowed": ORANGE,
    "not determined": VERMILION,
}
_CELL = 44
_BAR = 46
_FRAME_HEIGHT = 100


@dataclass(frozen=True)
class PosteriorFigures:
    """Figures of a posterior.

    Attributes
    ----------
    narrowing : Figure
        Share of each parameter's interval that is ruled out.
    correlations : Figure or None
        Rank correlations; None for a single parameter.
    marginals : tuple of Figure
        Distribution of each parameter.
    """

    narrowing: Figure
    correlations: Figure | None
    marginals: tuple[Figure, ...]


def posterior(saved: SavedCalibration, analysis: Analysis | None = None) -> PlotlyFigure:
    """Draw the parameter values that agree with the measurements, and their correlations.

    Takes a calibration and its analysis, by default ``saved.analyse()``; returns a Plotly figure.

    Raises
    ------
    InputError
        There are too few runs for a posterior, or no parameter set agrees.
    """
    if saved.why_nothing_agrees:
        raise no_figure(saved.why_nothing_agrees)
    analysis = analysis or saved.analyse()
    if analysis.posterior is None or analysis.identifiability is None:
        raise no_figure(" ".join(analysis.notes))
    figures = posterior_figures(
        saved, analysis.posterior, analysis.identifiability, analysis.intervals
    )
    rows = in_columns(figures.marginals, _columns(len(figures.marginals)))
    rows.append([figure for figure in (figures.narrowing, figures.correlations) if figure])
    return arrange(rows, "Parameters that agree with the measurements")


def posterior_figures(
    saved: SavedCalibration,
    posterior: Posterior,
    found: Identifiability,
    intervals: Mapping[str, ParameterInterval],
) -> PosteriorFigures:
    """Return all figures of a posterior."""
    several = len(posterior.names) > 1
    return PosteriorFigures(
        _narrowing_figure(saved, found.narrowing, intervals),
        _correlation_figure(saved, posterior) if several else None,
        tuple(
            _marginal_figure(saved, posterior, i, interval_in_words(intervals[name]))
            for i, name in enumerate(posterior.names)
        ),
    )


def _columns(marginals: int) -> int:
    return 2 if marginals in (2, 4) else min(marginals, 3)


def interval_in_words(found: ParameterInterval) -> str:
    """Return the 95 % interval of a parameter in words."""
    return ends(found.low, found.high)


def _narrowing_figure(
    saved: SavedCalibration,
    narrowing: Mapping[str, float],
    intervals: Mapping[str, ParameterInterval],
) -> Figure:
    # Plotly draws the first category at the bottom.
    parameters = [p for p in reversed(saved.problem.parameters) if p.name in narrowing]
    shares = [1.0 - narrowing[p.name] for p in parameters]
    return Figure(
        data=(
            {
                "type": "bar",
                "orientation": "h",
                "x": shares,
                "y": list(range(len(parameters))),
                "marker": {"color": [_COLORS[intervals[p.name].determination] for p in parameters]},
                "width": 0.4,
                "customdata": [
                    [
                        interval_in_words(intervals[p.name]),
                        f"{number(p.minimum, 3)} to {number(p.maximum, 3)}",
                    ]
                    for p in parameters
                ],
                "hovertemplate": (
                    "with 95 % probability from %{customdata[0]}<br>"
                    "interval %{customdata[1]}<extra></extra>"
                ),
            },
        ),
        layout={
            "xaxis": {
                "range": [0, 1.03],
                **SHARES,
                "title": {"text": "share ruled out"},
            },
            "yaxis": {
                "tickvals": list(range(len(parameters))),
                "ticktext": [label_of_parameter(saved, p.name).tick for p in parameters],
                "range": [-0.4, len(parameters) - 0.2],
                "zeroline": False,
            },
            "annotations": [
                _above(row, f"{100 * share:.0f} %, {intervals[p.name].determination}")
                for row, (p, share) in enumerate(zip(parameters, shares, strict=True))
            ],
        },
        description="Share of each parameter's interval that the measurements rule out.",
        height=_FRAME_HEIGHT + _BAR * len(parameters),
        title="Ruled out by the measurements",
    )


def _above(row: int, words: str) -> Mapping[str, Any]:
    """Return words above a bar: beside a long one they would be cut."""
    place = {"x": 0, "y": row + 0.2, "xanchor": "left", "yanchor": "bottom"}
    return {**place, "text": words, "showarrow": False, "xshift": 3}


def _correlation_figure(saved: SavedCalibration, posterior: Posterior) -> Figure:
    names, found = posterior.names, posterior.correlations
    labels = [label_of_parameter(saved, name).tick for name in names]
    plots = [label_of_parameter(saved, name).plot for name in names]
    last = len(names) - 1
    # Each pair once; the correlation of a parameter with itself has no information.
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
            [f"{plots[row]} and {plots[column]}" for column in range(last)]
            for row in range(1, last + 1)
        ],
        "zmin": -1,
        "zmax": 1,
        # Transparent, so that numbers are readable on a light and on a dark page.
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
        title="Rank correlations",
    )


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def _marginal_figure(
    saved: SavedCalibration, posterior: Posterior, index: int, between: str
) -> Figure:
    parameter = next(p for p in saved.problem.parameters if p.name == posterior.names[index])
    low, high = shown_part(posterior, index)
    counts, edges = np.histogram(posterior.points[:, index], bins=_BINS, range=(low, high))
    values = [parameter.from_unit(float(edge)) for edge in edges]
    heights = (counts / counts.max()).tolist()
    layout: dict[str, Any] = {
        "xaxis": parameter_axis(saved, parameter, (low, high)),
        "yaxis": {"range": [0, 1.08], "showticklabels": False, "ticks": "", "showgrid": False},
        "showlegend": False,
        "margin": {"l": 20, "r": 20, "t": 6, "b": 40},
    }
    if saved.result is not None and saved.result.parameters:
        layout["shapes"] = [_line_at(saved.result.parameters[parameter.name])]
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
            f"of the probability is from {between}."
        ),
        height=170,
        title=f"95 % from {between}",
    )


def shown_part(posterior: Posterior, index: int) -> tuple[float, float]:
    """Return the part of a parameter's interval that has the distribution, with some room."""
    low, high = np.quantile(posterior.points[:, index], (0.001, 0.999))
    room = max(0.15 * (high - low), 0.005)
    return max(float(low) - room, 0.0), min(float(high) + room, 1.0)


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
