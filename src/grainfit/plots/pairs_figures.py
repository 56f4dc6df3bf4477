"""Pair plot: parameter sets that agree with the measurements, two parameters at a time."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from grainfit.analysis.analysis import Analysis
from grainfit.analysis.posterior import Posterior
from grainfit.plots import messages
from grainfit.plots.arrange import arrange, in_columns
from grainfit.plots.axes import parameter_axis
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.labels import label_of_parameter
from grainfit.plots.posterior_figures import shown_part
from grainfit.plots.style import BLUE, VERMILION
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

#: Pairs that are drawn, those with the strongest correlations first, and points of each.
_PAIRS = 6
_POINTS = 300
_COLUMNS = 3


def pairs(saved: SavedCalibration, analysis: Analysis | None = None) -> PlotlyFigure:
    """Draw the parameter sets that agree with the measurements, two parameters at a time.

    Takes a calibration and its analysis, by default ``saved.analyse()``; returns a Plotly figure.
    Of many pairs, those with the strongest rank correlations are drawn.

    Raises
    ------
    InputError
        There are too few runs for a posterior, no parameter set agrees, or there is only one
        parameter.
    """
    if saved.why_nothing_agrees:
        raise no_figure(saved.why_nothing_agrees)
    analysis = analysis or saved.analyse()
    if analysis.posterior is None:
        raise no_figure(" ".join(analysis.notes))
    figures = pairs_figures(saved, analysis.posterior)
    if not figures:
        raise no_figure(messages.NO_PAIR())
    rows = in_columns(figures, min(len(figures), _COLUMNS))
    return arrange(rows, "Pairs of parameters that agree with the measurements")


def pairs_figures(saved: SavedCalibration, posterior: Posterior) -> tuple[Figure, ...]:
    """Return a figure of each pair of parameters, those that compensate each other most first."""
    strength = np.abs(np.nan_to_num(posterior.correlations))
    found = sorted(
        combinations(range(len(posterior.names)), 2), key=lambda pair: -float(strength[pair])
    )
    return tuple(_pair(saved, posterior, *pair) for pair in found[:_PAIRS])


def _pair(saved: SavedCalibration, posterior: Posterior, across: int, up: int) -> Figure:
    names = posterior.names[across], posterior.names[up]
    of = {parameter.name: parameter for parameter in saved.problem.parameters}
    labels = [label_of_parameter(saved, name) for name in names]
    chosen = np.linspace(0, len(posterior.values) - 1, min(_POINTS, len(posterior.values)))
    points = posterior.values[chosen.astype(int)]
    cloud = {
        "type": "scatter",
        "mode": "markers",
        "x": points[:, across].tolist(),
        "y": points[:, up].tolist(),
        "marker": {"color": BLUE, "size": 4, "opacity": 0.6},
        "hovertemplate": f"{labels[0].plot} %{{x:.4g}}, {labels[1].plot} %{{y:.4g}}<extra></extra>",
    }
    answer = saved.result.parameters if saved.result else {}
    star = {
        "type": "scatter",
        "mode": "markers",
        "x": [answer.get(names[0])],
        "y": [answer.get(names[1])],
        "marker": {"color": VERMILION, "size": 12, "symbol": "star"},
        "hovertemplate": "the answer<extra></extra>",
    }
    return Figure(
        data=(cloud, star) if answer else (cloud,),
        layout={
            "xaxis": parameter_axis(saved, of[names[0]], shown_part(posterior, across)),
            "yaxis": parameter_axis(saved, of[names[1]], shown_part(posterior, up)),
            "showlegend": False,
            "margin": {"l": 48, "r": 16, "t": 8, "b": 40},
        },
        description=(
            f"Values of {labels[0].words} (across) and {labels[1].words} (upwards) that agree with "
            f"the measurements; their rank correlation is "
            f"{posterior.correlations[across, up]:.2f}."
        ),
        height=260,
    )
