"""Common style of the figures of the report: marks, colours, and bands of tolerance.

All colours are those of Okabe and Ito, distinct in any kind of colour blindness; the blue is a
little lighter, to be visible on a dark page as well as on a light one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from typing import Any

from grainfit.evaluation import Evaluation
from grainfit.metamodels.curve_reduction import Reduction
from grainfit.problem import Target
from grainfit.work_folder.saved_calibration import SavedCalibration

BLUE, VERMILION, GREEN, PURPLE, ORANGE = "#1f83c4", "#d55e00", "#009e73", "#cc79a7", "#e69f00"
#: A transparent band.
GREEN_BAND = "rgba(0, 158, 115, 0.2)"
#: Colour of lines that only guide the eye.
QUIET = "#888888"
#: Place of a legend above a figure.
LEGEND_ABOVE: Mapping[str, Any] = {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0}
#: Marks of runs by stage: a colour, and a shape that identifies the stage without colour.
STAGES: Mapping[str, tuple[str, str]] = {
    "design": ("circle-open", BLUE),
    "optimisation": ("diamond", ORANGE),
    "verification": ("square", PURPLE),
}


def named_runs(reading: SavedCalibration, reduction: Reduction) -> Iterator[tuple[str, Evaluation]]:
    """Yield all known runs with their names: their numbers, as in the table of runs.

    Their responses include the components of curves.
    """
    for number, evaluation in enumerate(reduction.evaluations(reading.known), start=1):
        is_own = number <= len(reading.evaluations)
        yield f"run {number}" if is_own else "a run of another calibration", evaluation


def tolerance_band(target: Target, axis: str) -> list[dict[str, Any]]:
    """Return shapes of a target and its tolerance along an axis, across the whole figure."""
    other = {"x": "y", "y": "x"}[axis]
    across = {f"{other}ref": "paper", f"{other}0": 0, f"{other}1": 1, f"{axis}ref": axis}
    low, high = target.value - target.tolerance, target.value + target.tolerance
    band = {"type": "rect", "layer": "below", "fillcolor": GREEN_BAND, "line": {"width": 0}}
    line = {"type": "line", "layer": "below", "line": {"color": GREEN, "width": 1.5, "dash": "dot"}}
    return [
        {**band, **across, f"{axis}0": low, f"{axis}1": high},
        {**line, **across, f"{axis}0": target.value, f"{axis}1": target.value},
    ]


def value_range(target: Target, values: Iterable[float]) -> list[float]:
    """Return a range that shows values and tolerance, with some room."""
    shown = [value for value in values if isfinite(value)]
    shown += [target.value - target.tolerance, target.value + target.tolerance]
    low, high = min(shown), max(shown)
    room = 0.08 * (high - low)
    return [low - room, high + room]
