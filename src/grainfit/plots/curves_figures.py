"""Measured and simulated curves with their bands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from grainfit.analysis.analysis import Analysis
from grainfit.arrays import Array
from grainfit.formatting import plain
from grainfit.plots import messages
from grainfit.plots.arrange import arrange
from grainfit.plots.curve_traces import (
    axis_of,
    band,
    coordinate_axis,
    line,
    measured_points,
    single_runs,
    title_of_curve,
)
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.style import LEGEND_ABOVE, PURPLE, QUIET
from grainfit.problem import CurveTarget
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure


#: Most simulated curves of each kind: more hide each other.
_MOST_DRAWN = 30
#: Points of the posterior whose expected curves make the band.
_MOST_SAMPLES = 500
#: Room above and below, over the height of what is shown.
_ROOM = 0.15


def curves(saved: SavedCalibration, analysis: Analysis | None = None) -> PlotlyFigure:
    """Draw every measured curve with the simulated ones and the band of those that agree.

    Takes a calibration and its analysis, by default ``saved.analyse()``; returns a Plotly figure.

    Raises
    ------
    InputError
        No curve was measured.
    """
    analysis = analysis or saved.analyse()
    figures = curve_figures(saved, analysis)
    if not figures:
        raise no_figure(messages.NO_CURVE())
    return arrange([[figure] for figure in figures.values()], "Measured and simulated curves")


def curve_figures(saved: SavedCalibration, analysis: Analysis) -> dict[str, Figure]:
    """Return one figure for each measured curve, by its name."""
    return {target.name: _figure(saved, analysis, target) for target in saved.problem.curves}


def _figure(saved: SavedCalibration, analysis: Analysis, target: CurveTarget) -> Figure:
    places = target.coordinates
    expected = saved.result.curves.get(target.name) if saved.result else None
    agreeing = _agreeing(analysis, target)
    traces = _simulated(saved, target, verified=False)
    shown = [*target.values]
    if agreeing is not None:
        low, high = (ends.tolist() for ends in agreeing)
        name = "95 % of the expected curves"
        traces.append(band(places, low, high, name))
        shown += low + high
    traces += _simulated(saved, target, verified=True)
    if expected is not None:
        traces.append(line(places, expected.expected, "expected at the answer"))
    traces.append(measured_points(places, target.values, target.standard_uncertainties.tolist()))
    room = _ROOM * (max(shown) - min(shown))
    return Figure(
        data=tuple(traces),
        layout={
            "xaxis": coordinate_axis(target.coordinate, target.coordinate_unit, places),
            "yaxis": {
                **axis_of(title_of_curve(target.name), target.unit),
                "range": [min(shown) - room, max(shown) + room],
            },
            "legend": LEGEND_ABOVE,
            "hovermode": "closest",
        },
        description=(
            f"{plain(target.name)}: measured points with their 95 % intervals, curves of "
            "single runs, and the band of expected curves that agree with all measurements."
        ),
        height=440,
        title=plain(target.name),
    )


def _agreeing(analysis: Analysis, target: CurveTarget) -> tuple[Array, Array] | None:
    """Return 95 % of the expected curves of the posterior; None without one."""
    posterior, metamodels = analysis.posterior, analysis.metamodels
    if posterior is None or metamodels is None:
        return None
    bases = [b for b in metamodels.reduction.bases if b.target.name == target.name]
    if not bases:
        return None
    names = [found.name for found in metamodels.problem.targets]
    columns = [names.index(name) for name in bases[0].names]
    step = max(1, len(posterior.points) // _MOST_SAMPLES)
    scores = posterior.responses[::step][:, columns]
    drawn = bases[0].curves(scores @ bases[0].components)
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    return low, high


def _simulated(
    saved: SavedCalibration, target: CurveTarget, *, verified: bool
) -> list[Mapping[str, Any]]:
    """Return single runs as one trace: those with fresh seeds, or the others."""
    found = [
        evaluation.curves[target.name]
        for evaluation in saved.known
        if target.name in evaluation.curves
        and (evaluation.proposal.stage == "verification") == verified
    ]
    if not found:
        return []
    color, width, name = (PURPLE, 1.2, "fresh seeds") if verified else (QUIET, 0.7, "other runs")
    runs = ((curve.coordinates, curve.values) for curve in found[:_MOST_DRAWN])
    return [single_runs(runs, name, color, width)]
