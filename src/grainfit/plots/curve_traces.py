"""Parts of figures of curves: lines, bands and measured points over a coordinate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from grainfit.bulk_tests.registry import curve_info
from grainfit.formatting import plain, unit_for_people
from grainfit.plots.axes import whole_step
from grainfit.plots.style import BLUE, GREEN
from grainfit.student import NORMAL_QUANTILE

_BLUE_BAND = "rgba(31, 131, 196, 0.25)"
#: Room beside the measured points, over the length of the axis.
_MARGIN = 0.04


def title_of_curve(name: str) -> str:
    """Return what a curve is in words, or else its name."""
    info = curve_info(name.rpartition(".")[2])
    return plain(name) if info is None else info.description.partition(":")[0]


def axis_of(words: str, unit: str) -> Mapping[str, Any]:
    """Return an axis with its title and unit."""
    shown = unit_for_people(unit)
    text = f"{plain(words)} ({shown})" if shown else plain(words)
    return {"title": {"text": text}, "zeroline": False}


def coordinate_axis(coordinate: str, unit: str, coordinates: Sequence[float]) -> Mapping[str, Any]:
    """Return the axis of a coordinate, with a little room beside the measured points.

    Where it counts (it has no unit, and all points are at whole numbers), all ticks are whole.

    Examples
    --------
    >>> [coordinate_axis("taps", "", (0, last))["dtick"] for last in (2, 30)]
    [1, 5]
    >>> "dtick" in coordinate_axis("strain", "", (0, 0.5))
    False
    """
    length = coordinates[-1] - coordinates[0]
    ends = [coordinates[0] - _MARGIN * length, coordinates[-1] + _MARGIN * length]
    axis = {**axis_of(coordinate or "coordinate", unit), "range": ends}
    if unit or not all(float(one).is_integer() for one in coordinates):
        return axis
    return {**axis, "tick0": 0, "dtick": whole_step(length)}


def band(
    coordinates: Sequence[float],
    low: Sequence[float],
    high: Sequence[float],
    name: str,
    colour: str = _BLUE_BAND,
) -> Mapping[str, Any]:
    """Return the area between two curves."""
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": [*coordinates, *reversed(coordinates)],
        "y": [*high, *reversed(low)],
        "fill": "toself",
        "fillcolor": colour,
        "line": {"width": 0},
        "hoverinfo": "skip",
    }


def line(coordinates: Sequence[float], values: Sequence[float], name: str) -> Mapping[str, Any]:
    """Return a curve that is expected."""
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": list(coordinates),
        "y": list(values),
        "line": {"color": BLUE, "width": 2.5},
    }


def single_runs(
    curves: Iterable[tuple[Sequence[float], Sequence[float]]], name: str, colour: str, width: float
) -> Mapping[str, Any]:
    """Return coordinates and values of some runs as one trace."""
    x: list[float | None] = []
    y: list[float | None] = []
    for coordinates, values in curves:
        # With a gap after each.
        x += [*coordinates, None]
        y += [*values, None]
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": x,
        "y": y,
        "line": {"color": colour, "width": width},
        "opacity": 0.8,
        "hoverinfo": "skip",
    }


def measured_points(
    coordinates: Sequence[float], values: Sequence[float], uncertainties: Sequence[float]
) -> Mapping[str, Any]:
    """Return measured points with their 95 % intervals."""
    return {
        "type": "scatter",
        "mode": "markers",
        "name": "measured, with 95 % intervals",
        "x": list(coordinates),
        "y": list(values),
        "error_y": {
            "type": "data",
            "array": [NORMAL_QUANTILE * one for one in uncertainties],
            "thickness": 1,
            "width": 3,
            "color": GREEN,
        },
        "marker": {"color": GREEN, "symbol": "circle", "size": 7},
    }
