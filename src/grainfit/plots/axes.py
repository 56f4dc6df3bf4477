"""Axes of parameters and of shares in figures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import count
from typing import Any

from grainfit.formatting import number
from grainfit.plots.labels import label_of_parameter
from grainfit.problem import Parameter
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Rounding error of logarithms, so that a bound that is a power of ten gets its tick.
_ROUNDING = 1e-9
#: Intervals between ticks of an axis that counts.
_MOST_TICKS = 8


def parameter_axis(
    saved: SavedCalibration, parameter: Parameter, shown: tuple[float, float] = (0.0, 1.0)
) -> Mapping[str, Any]:
    """Return the axis of a parameter over its interval, or a part of it, as a layout of Plotly.

    The part that is shown is given in the unit cube.
    """
    minimum, maximum = map(parameter.from_unit, shown)
    common = {
        "title": {"text": label_of_parameter(saved, parameter.name).axis},
        "zeroline": False,
        "ticklabeloverflow": "allow",
    }
    if parameter.scale == "linear":
        return {**common, "range": [minimum, maximum], "nticks": 5}
    return {**common, **log_axis(minimum, maximum)}


def whole_step(length: float) -> int:
    """Return the step of ticks on an axis that counts: 1, 2 or 5 times a power of ten.

    Examples
    --------
    >>> whole_step(3), whole_step(20), whole_step(150)
    (1, 5, 20)
    """
    steps = (factor * 10**power for power in count() for factor in (1, 2, 5))
    return int(next(step for step in steps if step * _MOST_TICKS >= length))


def log_axis(minimum: float, maximum: float) -> Mapping[str, Any]:
    """Return a logarithmic axis between two values, each tick with its whole number.

    Plotly writes the first digit alone between powers of ten: "2" above "10".

    Examples
    --------
    >>> log_axis(0.6, 30.0)["ticktext"]
    ['1', '2', '5', '10', '20']
    """
    low, high = math.log10(minimum), math.log10(maximum)
    powers = range(math.floor(low), math.floor(high + _ROUNDING) + 1)
    factors = (1, 2, 5) if high - low < 2 else (1,)
    ticks = [float(f"{factor}e{power}") for power in powers for factor in factors]
    ticks = [t for t in ticks if low - _ROUNDING <= math.log10(t) <= high + _ROUNDING]
    if len(ticks) < 2:
        ticks = [minimum, maximum]
    return {
        "type": "log",
        "range": [low, high],
        "tickvals": ticks,
        "ticktext": [number(tick, 3) for tick in ticks],
    }


#: Shares of a whole on an axis: few, for narrow figures.
SHARES: Mapping[str, Any] = {"tickvals": [0, 0.5, 1], "ticktext": ["0 %", "50 %", "100 %"]}
