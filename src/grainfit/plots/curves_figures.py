"""Measured and simulated curves with their bands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from grainfit.analysis.analysis import Analysis
from grainfit.arrays import Array
from grainfit.bulk_tests.registry import curve_info
from grainfit.formatting import plain, unit_for_people
from grainfit.plots import messages
from grainfit.plots.arrange import arrange
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.style import BLUE, GREEN, PURPLE, QUIET
from grainfit.problem import CurveTarget
from grainfit.student import NORMAL_QUANTILE
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure


_BLUE_BAND = "rgba(31, 131, 196, 0.25)"
#: Most simulated curves of each kind: more hide each other.
_MOST_DRAWN = 30
#: Points of the posterior whose expected curves make the band.
_MOST_SAMPLES = 500


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
    expected = saved.result.curves.get(target.name) if saved.result else None
    band = _band(analysis, target)
    traces = [
        *_simulated(saved, target, verified=False),
        *([] if band is None else _band_traces(target, *band)),
        *_simulated(saved, target, verified=True),
    ]
    if expected is not None:
        traces.append(_line(target, expected.expected, "expected at the answer"))
    traces.append(_measured(target))
    high = max(map(max, (target.values, *([band[1].tolist()] if band else []))))
    low = min(map(min, (target.values, *([band[0].tolist()] if band else []))))
    room = 0.15 * (high - low)
    margin = 0.04 * (target.coordinates[-1] - target.coordinates[0])
    return Figure(
        data=tuple(traces),
        layout={
            "xaxis": {
                "title": {"text": _axis(target.coordinate or "coordinate", target.coordinate_unit)},
                "range": [
                    target.coordinates[0] - margin,
                    target.coordinates[-1] + margin,
                ],
                "zeroline": False,
            },
            "yaxis": {
                "title": {"text": _axis(_title(target.name), target.unit)},
                "range": [low - room, high + room],
                "zeroline": False,
            },
            "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
            "hovermode": "closest",
        },
        description=(
            f"{plain(target.name)}: measured points with their 95 % intervals, curves of "
            "single runs, and the band of expected curves that agree with all measurements."
        ),
        height=440,
        title=plain(target.name),
    )


def _title(name: str) -> str:
    info = curve_info(name.rpartition(".")[2])
    return plain(name) if info is None else info.description.partition(":")[0]


def _axis(words: str, unit: str) -> str:
    shown = unit_for_people(unit)
    return f"{plain(words)} ({shown})" if shown else plain(words)


def _band(analysis: Analysis, target: CurveTarget) -> tuple[Array, Array] | None:
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
    drawn = np.array([bases[0].expected(one, np.zeros(len(one)))[0] for one in scores])
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    return low, high


def _band_traces(target: CurveTarget, low: Array, high: Array) -> list[Mapping[str, Any]]:
    places = list(target.coordinates)
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "name": "expected curves that agree with the measurements (95 %)",
            "x": [*places, *reversed(places)],
            "y": [*high.tolist(), *reversed(low.tolist())],
            "fill": "toself",
            "fillcolor": _BLUE_BAND,
            "line": {"width": 0},
            "hoverinfo": "skip",
        }
    ]


def _line(target: CurveTarget, values: Sequence[float], name: str) -> Mapping[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": list(target.coordinates),
        "y": list(values),
        "line": {"color": BLUE, "width": 2.5},
    }


def _measured(target: CurveTarget) -> Mapping[str, Any]:
    half = NORMAL_QUANTILE * target.standard_uncertainties
    return {
        "type": "scatter",
        "mode": "markers",
        "name": "measured, with 95 % intervals",
        "x": list(target.coordinates),
        "y": list(target.values),
        "error_y": {
            "type": "data",
            "array": half.tolist(),
            "thickness": 1,
            "width": 3,
            "color": GREEN,
        },
        "marker": {"color": GREEN, "symbol": "circle", "size": 7},
    }


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
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "x": list(_joined(curve.coordinates for curve in found[:_MOST_DRAWN])),
            "y": list(_joined(curve.values for curve in found[:_MOST_DRAWN])),
            "line": {"color": color, "width": width},
            "opacity": 0.8,
            "hoverinfo": "skip",
        }
    ]


def _joined(parts: Iterable[Sequence[float]]) -> Iterable[float | None]:
    """Yield the numbers of all parts, with a gap after each."""
    for part in parts:
        yield from part
        yield None
