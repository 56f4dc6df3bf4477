"""Predicted against simulated: leave-one-out predictions of the metamodels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis.analysis import Analysis
from grainfit.formatting import plain
from grainfit.plots.arrange import arrange, in_columns
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.leave_one_out import LeaveOneOutCheck, leave_one_out_checks
from grainfit.plots.style import BLUE, LEGEND_ABOVE, QUIET, VERMILION
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

_COLUMNS = 2


def predicted(saved: SavedCalibration, analysis: Analysis | None = None) -> PlotlyFigure:
    """Draw each run as simulated against its prediction from all other runs.

    Takes a calibration and its analysis, by default ``saved.analyse()``; returns a Plotly figure.

    Raises
    ------
    InputError
        There are too few runs for a metamodel.
    """
    analysis = analysis or saved.analyse()
    figures = [predicted_figure(check) for check in leave_one_out_checks(saved, analysis)]
    if not figures:
        raise no_figure(" ".join(analysis.notes))
    rows = in_columns(figures, min(len(figures), _COLUMNS))
    return arrange(rows, "Predicted from all other runs, and simulated", one_legend=True)


def predicted_figure(check: LeaveOneOutCheck) -> Figure:
    """Return the figure of one response."""
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
            "legend": LEGEND_ABOVE,
            "hovermode": "closest",
        },
        description=(
            f"{plain(check.target.name)} of each run as simulated (across) and as predicted from "
            "all other runs, with its 95 % interval (upwards). On the diagonal both are equal."
        ),
        height=400,
    )


def _points(
    check: LeaveOneOutCheck, chosen: NDArray[np.bool_], name: str, color: str, symbol: str
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
        "meta": {
            "runs": [name for name, kept in zip(check.names, chosen, strict=True) if kept],
        },
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
