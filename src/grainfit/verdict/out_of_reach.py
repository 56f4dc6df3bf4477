"""Targets that cannot be met within the intervals, and what is in the way: plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from grainfit.formatting import (
    in_a_row,
    number,
    plain_interval,
    unit_for_people,
    value_with_unit,
    with_unit,
)
from grainfit.student import NORMAL_QUANTILE
from grainfit.verdict import messages

Bound = Literal["min", "max"]
#: A value nearer to a bound than this share of the interval counts as on it.
_ON_BOUND = 0.01


def bound_at(position: float) -> Bound | None:
    """Return the bound that a position (0 to 1) in an interval lies on, or None."""
    if _ON_BOUND <= position <= 1 - _ON_BOUND:
        return None
    return "min" if position < _ON_BOUND else "max"


@dataclass(frozen=True)
class CurveMiss:
    """Deviation of an expected curve from a measured one, or from another expected one.

    Parameters
    ----------
    coordinate, coordinate_unit : str
        Name and unit of the coordinate.
    deviation : float
        Root mean square deviation, in standard uncertainties of the measured points.
    points : tuple of (float, float, float)
        Points that deviate most, the worst one first: coordinate, the value that it should have,
        and the one that it has.
    has_other_shape : bool
        Whether no simulated curve has the shape of the measured one.
    """

    coordinate: str
    coordinate_unit: str
    deviation: float
    points: tuple[tuple[float, float, float], ...]
    has_other_shape: bool = False

    def __str__(self) -> str:
        unit = unit_for_people(self.coordinate_unit)
        worst = [
            f"{with_unit(number(place), unit)} ({number(found, 3)} instead of {number(wanted, 3)})"
            for place, wanted, found in self.points
        ]
        return messages.CURVE_MISS(
            deviation=number(self.deviation, 2),
            coordinate=self.coordinate or "coordinate",
            worst=in_a_row(worst),
        )


@dataclass(frozen=True)
class OutOfReach:
    """A target that cannot be met within the intervals.

    Parameters
    ----------
    target : str
        Name of the target.
    value : float
        Its value; of a curve at the point that deviates most, as the next two.
    nearest, standard_error : float
        Nearest expected response within the intervals, and its standard error.
    jointly : bool
        The target could be met alone, but not together with the others.
    parameter, bound, bound_value : str, {"min", "max"}, float, optional
        The bound that is in the way.
    suggestion : float, optional
        A bound that should be enough, by linear extrapolation; None when there is none.
    is_relative : bool
        Whether deviations relative to the value make sense.
    curve : CurveMiss, optional
        Of a target that is a curve.
    unit, parameter_unit : str
        Units of the target and of the parameter.
    runs_fail_nearer : bool
        Runs fail where a response nearer to the target is expected.
    ratio_error : float
        Standard error that the ratio of the real apparatus to a simulated one adds; else 0.
    """

    target: str
    value: float
    nearest: float
    standard_error: float
    jointly: bool = False
    parameter: str | None = None
    bound: Bound | None = None
    bound_value: float | None = None
    suggestion: float | None = None
    is_relative: bool = True
    curve: CurveMiss | None = None
    unit: str = ""
    parameter_unit: str = ""
    runs_fail_nearer: bool = False
    ratio_error: float = 0.0

    @property
    def shortfall_percent(self) -> float | None:
        """Deviation of the nearest response, in percent of the target; None if that is no use."""
        if not self.is_relative or not self.value:
            return None
        return 100 * (self.nearest - self.value) / abs(self.value)

    def __str__(self) -> str:
        if self.curve is not None and self.curve.has_other_shape:
            # Beyond any bound, curves of these shapes are to be expected.
            return f"{self._missed()} {messages.NO_SUCH_SHAPE()}"
        if self.runs_fail_nearer:
            return f"{self._missed()} {messages.RUNS_FAIL_NEARER()}"
        if self.parameter is None:
            return f"{self._missed()} {messages.NO_BOUND()}"
        bound = f"{self.parameter}.{self.bound} = {self._in_words(self.bound_value)}"
        if self.suggestion is None:
            return f"{self._missed()} {messages.NO_BOUND_BEYOND(bound=bound)}"
        suggestion = self._in_words(self.suggestion)
        return f"{self._missed()} {messages.BOUND(bound=bound, suggestion=suggestion)}"

    def _in_words(self, bound: float | None) -> str:
        assert bound is not None
        return value_with_unit(bound, self.parameter_unit)

    def _missed(self) -> str:
        together = " together with the other targets" if self.jointly else ""
        if self.curve is not None:
            return messages.CURVE_OUT_OF_REACH(
                target=self.target, together=together, miss=self.curve
            )
        share = "" if self.shortfall_percent is None else f" ({self.shortfall_percent:+.1f} %)"
        nearest = plain_interval(self.nearest, NORMAL_QUANTILE * self.standard_error)
        return messages.OUT_OF_REACH(
            target=self.target,
            value=value_with_unit(self.value, self.unit),
            together=together,
            nearest=with_unit(nearest, unit_for_people(self.unit)),
            share=share + self._with_ratio(),
        )

    def _with_ratio(self) -> str:
        """Return the interval with what the ratio to the real apparatus adds, if there is one."""
        if not self.ratio_error:
            return ""
        error = math.hypot(self.standard_error, self.ratio_error)
        nearest = plain_interval(self.nearest, NORMAL_QUANTILE * error)
        return messages.WITH_RATIO(nearest=with_unit(nearest, unit_for_people(self.unit)))
