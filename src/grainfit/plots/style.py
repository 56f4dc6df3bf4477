"""What the figures of the report have in common: marks, colours, and bands of tolerance.

All colours are those of Okabe and Ito, told apart in any kind of colour blindness; the blue is a
little lighter, to be seen on dark paper as well as on light.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from typing import Any

from grainfit.evaluation import Evaluation
from grainfit.problem import Target
from grainfit.work_folder.saved_calibration import SavedCalibration

BLUE, VERMILION, GREEN, PURPLE, ORANGE = "#1f83c4", "#d55e00", "#009e73", "#cc79a7", "#e69f00"
#: A band that is seen through.
GREEN_BAND = "rgba(0, 158, 115, 0.2)"
#: Of lines that only guide the eye.
QUIET = "#888888"
#: How runs are marked by what they were made for: colour, and a shape that tells without it.
STAGES: Mapping[str, tuple[str, str]] = {
    "design": ("circle-open", BLUE),
    "optimisation": ("diamond", ORANGE),
    "verification": ("square", PURPLE),
}


def named_runs(reading: SavedCalibration) -> Iterator[tuple[str, Evaluation]]:
    """Yield all that is known with what it is called: by its number, as in the table of runs."""
    for number, evaluation in enumerate(reading.known, start=1):
        is_own = number <= len(reading.evaluations)
        yield f"run {number}" if is_own else "a run of another calibration", evaluation


def tolerance_band(target: Target, axis: str) -> list[dict[str, Any]]:
    """Return shapes of a target and its tolerance, across the whole figure.

    Parameters
    ----------
    target : Target
        What was measured.
    axis : {"x", "y"}
        The axis that has its unit.
    """
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
