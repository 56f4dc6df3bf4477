"""Yield loci: shear stress over normal stress, measured and expected at the answer."""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

from grainfit.formatting import plain
from grainfit.plots import messages
from grainfit.plots.arrange import arrange
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.style import BLUE, GREEN, LEGEND_ABOVE
from grainfit.result import YieldLocus, YieldLocusResult
from grainfit.student import NORMAL_QUANTILE
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

#: Length of the normal stress axis over the largest normal stress.
_REACH = 1.1


def yield_locus(saved: SavedCalibration) -> PlotlyFigure:
    """Draw shear stress over normal stress, measured and expected at the answer, with their lines.

    Takes a calibration with shear tests; returns a Plotly figure.

    Raises
    ------
    InputError
        No material was sheared at two or more normal stresses.
    """
    figures = yield_locus_figures(saved)
    if not figures:
        raise no_figure(messages.NO_YIELD_LOCUS())
    return arrange([[figure] for figure in figures], "Yield locus")


def yield_locus_figures(saved: SavedCalibration) -> list[Figure]:
    """Return one figure for each yield locus of a calibration."""
    return [_figure(locus) for locus in saved.yield_loci]


def _figure(locus: YieldLocusResult) -> Figure:
    traces = _traces(locus.measured, "measured", GREEN, "circle", "dash")
    if locus.expected is not None:
        traces += _traces(locus.expected, "expected at the answer", BLUE, "diamond", "solid")
    tests = plain(", ".join(locus.tests))
    return Figure(
        data=tuple(traces),
        layout={
            "xaxis": {
                "title": {"text": "normal stress (Pa)"},
                "range": [0, _REACH * max(locus.measured.normal_stresses)],
            },
            "yaxis": {"title": {"text": "shear stress (Pa)"}, "rangemode": "tozero"},
            "legend": LEGEND_ABOVE,
            "hovermode": "closest",
        },
        description=f"Shear stress over normal stress of {tests}, with fitted lines: {locus}",
        height=440,
        title=escape(tests),
    )


def _traces(
    locus: YieldLocus, name: str, colour: str, symbol: str, dash: str
) -> list[Mapping[str, Any]]:
    """Return the points with their 95 % intervals, and the line."""
    ends = [0.0, _REACH * max(locus.normal_stresses)]
    slope = math.tan(math.radians(locus.internal_friction_angle.value))
    half = [NORMAL_QUANTILE * shear.standard_error for shear in locus.shear_stresses]
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "name": f"{name}, line",
            "showlegend": False,
            "x": ends,
            "y": [locus.cohesion.value + slope * stress for stress in ends],
            "line": {"color": colour, "width": 2, "dash": dash},
            "hoverinfo": "skip",
        },
        {
            "type": "scatter",
            "mode": "markers",
            "name": f"{name}, with 95 % intervals",
            "x": list(locus.normal_stresses),
            "y": [shear.value for shear in locus.shear_stresses],
            "error_y": {
                "type": "data",
                "array": half,
                "thickness": 1.5,
                "width": 5,
                "color": colour,
            },
            "marker": {"color": colour, "symbol": symbol, "size": 9},
        },
    ]
