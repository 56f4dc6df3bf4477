"""Sensitivity: Sobol' indices of every response with their intervals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis.analysis import Analysis
from grainfit.analysis.sensitivity import Sensitivity
from grainfit.formatting import plain
from grainfit.plots.arrange import arrange
from grainfit.plots.axes import SHARES
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.labels import label_of_parameter, label_of_response
from grainfit.plots.style import BLUE, VERMILION
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

_ROW_HEIGHT = 34
_FRAME_HEIGHT = 110


def sensitivity(saved: SavedCalibration, analysis: Analysis | None = None) -> PlotlyFigure:
    """Draw the share of each response's variation that each parameter explains.

    Takes a calibration and its analysis, by default ``saved.analyse()``; returns a Plotly figure.

    Raises
    ------
    InputError
        There are too few runs for a metamodel, or they do not show what any response depends on.
    """
    analysis = analysis or saved.analyse()
    if analysis.sensitivity is None:
        raise no_figure(" ".join(analysis.notes))
    found = analysis.sensitivity
    figures = sensitivity_figures(saved, found)
    if not figures:
        raise no_figure(" ".join(found.in_words()))
    unknown = [name for row, name in enumerate(found.responses) if row not in figures]
    heading = f"Sensitivity (not known: {', '.join(unknown)})" if unknown else "Sensitivity"
    return arrange([[figure] for figure in figures.values()], heading)


def sensitivity_figures(saved: SavedCalibration, found: Sensitivity) -> dict[int, Figure]:
    """Return a figure for each response whose indices are known, by its number."""
    rows = range(len(found.responses))
    return {row: _figure(saved, found, row) for row in rows if found.is_known(row)}


def _figure(saved: SavedCalibration, found: Sensitivity, row: int) -> Figure:
    # Plotly draws the first category at the bottom.
    order = np.argsort(found.total[row], kind="stable")
    labels = [label_of_parameter(saved, found.names[j]).tick for j in order]
    rows = np.arange(len(order), dtype=np.float64)
    indices = (
        ("alone (first)", found.first, found.first_low, found.first_high, BLUE, "circle", 0.14),
        (
            "alone and with others (total)",
            found.total,
            found.total_low,
            found.total_high,
            VERMILION,
            "diamond",
            -0.14,
        ),
    )
    return Figure(
        data=tuple(
            _dots(name, rows + shift, [a[row][order] for a in (best, low, high)], color, symbol)
            for name, best, low, high, color, symbol, shift in indices
        ),
        layout={
            "xaxis": {
                "range": [-0.03, 1.03],
                "title": {"text": "share of variation"},
                **SHARES,
                "zeroline": False,
            },
            "yaxis": {
                "tickvals": rows.tolist(),
                "ticktext": labels,
                "range": [-0.6, len(order) - 0.4],
                "zeroline": False,
            },
            "hovermode": "closest",
        },
        description=(
            f"First and total sensitivity of {plain(found.responses[row])} to each parameter, "
            "with 95 % intervals."
        ),
        height=_FRAME_HEIGHT + _ROW_HEIGHT * len(order),
        title=f"Variation of {label_of_response(saved, found.responses[row]).plot}",
    )


def _dots(
    name: str, rows: NDArray[np.float64], shares: list[NDArray[np.float64]], color: str, symbol: str
) -> Mapping[str, Any]:
    best, low, high = shares
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": best.tolist(),
        "y": rows.tolist(),
        "customdata": np.column_stack([low, high]).tolist(),
        "error_x": {
            "type": "data",
            "symmetric": False,
            "array": np.maximum(high - best, 0.0).tolist(),
            "arrayminus": np.maximum(best - low, 0.0).tolist(),
            "color": color,
            "thickness": 1.5,
            "width": 3,
        },
        "marker": {"color": color, "symbol": symbol, "size": 9},
        "hovertemplate": (
            f"{name}: %{{x:.0%}}<br>95 % interval "
            "%{customdata[0]:.0%} to %{customdata[1]:.0%}<extra></extra>"
        ),
    }
