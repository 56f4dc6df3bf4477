"""Hold-outs: what was expected before and after the calibration, and what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from grainfit.formatting import plain
from grainfit.plots import messages
from grainfit.plots.arrange import arrange
from grainfit.plots.figure import Figure, no_figure
from grainfit.plots.holdout_curve import holdout_curve
from grainfit.plots.labels import Label, response_label
from grainfit.plots.style import BLUE, GREEN, QUIET
from grainfit.result import HoldoutCurve, HoldoutResponse, Result
from grainfit.student import NORMAL_QUANTILE
from grainfit.work_folder.saved_calibration import SavedCalibration

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

#: Rows of a figure, from below.
_PRIOR, _EXPECTED, _MEASURED = "expected before the calibration", "expected after it", "measured"
#: Room at both ends of the axis, over its length.
_ROOM = 0.04


def holdout(saved: SavedCalibration) -> PlotlyFigure:
    """Draw what was expected of each hold-out, before and after the calibration, and measured.

    Takes a calibration with predicted hold-outs; returns a Plotly figure.

    Raises
    ------
    InputError
        No hold-out was predicted.
    """
    figures = list(holdout_figures(saved.result).values()) if saved.result else []
    if not figures:
        raise no_figure(messages.NO_HOLDOUT())
    return arrange([[figure] for figure in figures], "Tests that took no part in the fit")


def holdout_figures(result: Result) -> dict[tuple[str, str], Figure]:
    """Return one figure for each prediction, by test and name."""
    return {
        (one.test, name): _drawn(holdout_label(one.test, name, found), found)
        for one in result.holdouts
        for name, found in one.predictions.items()
    }


def _drawn(label: Label, found: HoldoutResponse | HoldoutCurve) -> Figure:
    return holdout_curve(label, found) if isinstance(found, HoldoutCurve) else _figure(label, found)


def holdout_label(test: str, name: str, found: HoldoutResponse | HoldoutCurve) -> Label:
    """Return the label of a response of a hold-out."""
    return response_label(f"{test}.{name}", found.unit)


def _figure(label: Label, found: HoldoutResponse) -> Figure:
    unit, rows = escape(label.unit), [_PRIOR, _EXPECTED]
    traces = [
        _bar(_PRIOR, found.prior, QUIET, unit),
        _bar(_EXPECTED, found.interval, BLUE, unit),
        _runs(_PRIOR, found.over_prior, "a run within the intervals", QUIET, "circle-open", unit),
        _runs(_EXPECTED, found.over_posterior, "a run that agrees", BLUE, "circle-open", unit),
        _runs(_EXPECTED, found.at_answer, "a run at the answer", BLUE, "diamond", unit),
    ]
    if found.measured is not None:
        rows.append(_MEASURED)
        traces.append(_measured(found.measured, found.uncertainty or 0.0, unit))
    return Figure(
        tuple(traces),
        {
            "xaxis": {"title": {"text": label.axis}, "zeroline": False, "range": _range(found)},
            "yaxis": {
                "type": "category",
                "categoryarray": rows,
                "range": [-0.6, len(rows) - 0.4],
                "automargin": True,
            },
            "shapes": _band(found.interval),
            "showlegend": False,
        },
        f"95 % intervals of {label.words} before the calibration and after it, runs as points, and "
        f"what was measured. {plain(found.in_words(label.name))}",
        height=240,
        title=escape(plain(label.name)),
    )


def _range(found: HoldoutResponse) -> list[float]:
    shown = [*found.prior, *found.interval, *found.over_prior, *found.over_posterior]
    shown += found.at_answer
    if found.measured is not None:
        half = NORMAL_QUANTILE * (found.uncertainty or 0.0)
        shown += [found.measured - half, found.measured + half]
    room = _ROOM * (max(shown) - min(shown))
    return [min(shown) - room, max(shown) + room]


def _bar(row: str, ends: tuple[float, float], colour: str, unit: str) -> Mapping[str, Any]:
    low, high = ends
    return {
        "type": "scatter",
        "mode": "lines",
        "name": f"{row}, 95 % interval",
        "x": [low, high],
        "y": [row, row],
        "line": {"color": colour, "width": 14},
        "opacity": 0.45,
        "hovertemplate": f"{low:.5g} to {high:.5g} {unit}<extra>{row}</extra>",
    }


def _runs(
    row: str, values: Sequence[float], name: str, colour: str, symbol: str, unit: str
) -> Mapping[str, Any]:
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": list(values),
        "y": [row] * len(values),
        "marker": {"symbol": symbol, "color": colour, "size": 7},
        "hovertemplate": f"%{{x:.5g}} {unit}<extra>{name}</extra>",
    }


def _measured(value: float, uncertainty: float, unit: str) -> Mapping[str, Any]:
    half = NORMAL_QUANTILE * uncertainty
    return {
        "type": "scatter",
        "mode": "markers",
        "name": "measured, with 95 % interval",
        "x": [value],
        "y": [_MEASURED],
        "error_x": {"type": "data", "array": [half], "color": GREEN, "width": 8},
        "marker": {"symbol": "circle", "color": GREEN, "size": 11},
        "hovertemplate": f"%{{x:.5g}} ± {half:.2g} {unit}<extra>measured</extra>",
    }


def _band(ends: tuple[float, float]) -> list[Mapping[str, Any]]:
    """Return the interval of a measurement across all rows."""
    line = {"color": BLUE, "width": 1, "dash": "dot"}
    across = {"type": "line", "layer": "below", "line": line, "yref": "paper", "y0": 0, "y1": 1}
    return [{**across, "xref": "x", "x0": end, "x1": end} for end in ends]
