"""Rows of parameters and responses as texts: the report and the page of a watch show the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Literal

from grainfit.formatting import counted, ends, interval, number, rounded, telling, unit_for_people
from grainfit.materials.card import Determination
from grainfit.plots.labels import Label
from grainfit.problem import CurveTarget, Parameter, Target
from grainfit.result import CurveResult, ParameterInterval, ResponseResult


@dataclass(frozen=True)
class ParameterRow:
    """A parameter as it is shown; positions are percentages of its interval."""

    label: Label
    value: str
    interval: str
    determination: Determination | Literal[""]
    bias: str
    position: float | None
    credible: tuple[float, float] | None
    searched: str
    measured: str


@dataclass(frozen=True)
class ResponseRow:
    """A response, or a curve, as it is shown; empty texts for what is not known."""

    label: Label
    measured: str
    tolerance: str = ""
    expected: str = ""
    half_width: str = ""
    fresh: str = ""
    deviation: str = ""
    verdict: str = ""
    probability: float | None = None


def parameter_row(
    label: Label, parameter: Parameter, value: float | None, found: ParameterInterval | None
) -> ParameterRow:
    """Return the row of a free parameter.

    Parameters
    ----------
    label : Label
        Its label.
    parameter : Parameter
        The parameter.
    value : float, optional
        Its value so far.
    found : ParameterInterval, optional
        Its 95 % interval.
    """
    interval = (found.low, found.high) if found else None
    # On a logarithmic scale, the digits of one end mean nothing at the other.
    half_width = (found.high - found.low) / 2 if found and parameter.scale == "linear" else None
    return ParameterRow(
        label,
        value=_shown(value, half_width, 3 if found else 4) if value is not None else "",
        interval=ends(*interval) if interval else "",
        determination=found.determination if found else "",
        bias=found.bias if found else "",
        position=None if value is None else _position(parameter, value),
        credible=(_position(parameter, interval[0]), _position(parameter, interval[1]))
        if interval
        else None,
        searched=ends(parameter.minimum, parameter.maximum),
        measured=_measured(parameter),
    )


def _measured(parameter: Parameter) -> str:
    """Return the value that a measurement of its own gave; empty without one."""
    if parameter.measured is None or parameter.uncertainty is None:
        return ""
    return f"measured {number(parameter.measured)} ± {number(parameter.uncertainty, 3)}"


def _shown(value: float, half_width: float | None, digits: int) -> str:
    return number(value, digits) if half_width is None else rounded(value, half_width)


def _position(parameter: Parameter, value: float) -> float:
    """Position of a value in its interval, percent."""
    return round(100 * min(max(parameter.to_unit(value), 0.0), 1.0), 2)


def response_row(label: Label, target: Target, found: ResponseResult | None) -> ResponseRow:
    """Return the row of a response, with its result where there is one."""
    measured = rounded(target.value, target.tolerance)
    tolerance = rounded(target.tolerance, target.tolerance)
    if found is None:
        return ResponseRow(label, measured, tolerance)
    expected, half_width = found.expected
    half_width = telling(half_width, expected)
    return ResponseRow(
        label,
        measured,
        tolerance,
        expected=rounded(expected, half_width),
        half_width=rounded(half_width, half_width),
        fresh=_fresh(found),
        deviation=deviation(found),
        verdict=found.verdict,
        probability=found.probability,
    )


def _fresh(found: ResponseResult) -> str:
    mean, half_width = found.verified_mean, found.verified_interval
    if mean is None or half_width is None:
        return ""
    return interval(mean, half_width)


def deviation(found: ResponseResult) -> str:
    """Return the deviation of a response from its target, with a sign and in a unit."""
    return found.deviation_in_words(unit_for_people(found.unit)).replace("-", "−")


def curve_row(target: CurveTarget, found: CurveResult | None) -> ResponseRow:
    """Return the row of a curve, with its result where there is one."""
    label = Label(target.name, target.name, "", "")
    measured = counted(len(target.values), "point")
    if found is None:
        return ResponseRow(label, measured)
    return ResponseRow(
        label,
        measured,
        fresh=_root_mean_square(found.verified_deviations),
        deviation=f"{number(found.deviation, 2)} σ",
        verdict=found.verdict,
        probability=found.probability,
    )


def _root_mean_square(deviations: Sequence[float]) -> str:
    if not deviations:
        return ""
    return f"{number(math.sqrt(fmean(one**2 for one in deviations)), 2)} σ off"
