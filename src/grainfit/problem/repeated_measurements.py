"""Repeated measurements of one quantity: their mean, its uncertainty, and a usual tolerance."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from grainfit.errors import Fault, InputError
from grainfit.problem import messages
from grainfit.problem.quantities import read_quantities, share_of, shown
from grainfit.student import student_factor
from grainfit.units import percentage
from grainfit.validation import as_number

#: Finest tolerances that repeats alone can give: they do not show what is wrong in all of them.
FINEST_SHARE = 0.01
FINEST_ANGLE = 0.5


@dataclass(frozen=True)
class RepeatedMeasurements:
    """Measurements of one quantity, in its unit.

    Parameters
    ----------
    values : sequence of float
        At least two; not all equal, unless the systematic part is given.
    systematic : float, optional
        Standard uncertainty that all of them share, such as that of a scale or a protractor.
    unit : str
        Their unit.

    Examples
    --------
    >>> repeats = RepeatedMeasurements((528.0, 534.0, 531.0), None, "kg/m^3")
    >>> repeats.value, round(repeats.uncertainty, 2), round(repeats.tolerance, 2)
    (531.0, 3.8, 5.31)
    """

    values: Sequence[float]
    systematic: float | None
    unit: str

    @property
    def value(self) -> float:
        """Mean of the measurements."""
        return statistics.fmean(self.values)

    @property
    def random(self) -> float:
        """Standard error of the mean, with Student's factor for few measurements.

        The factor makes 1.96 of these half the width of the 95 % interval of the mean.
        """
        count = len(self.values)
        return student_factor(count) * statistics.stdev(self.values) / math.sqrt(count)

    @property
    def uncertainty(self) -> float:
        """Combined standard uncertainty of the mean."""
        return math.hypot(self.random, self.systematic or 0.0)

    @property
    def tolerance(self) -> float:
        """Tolerance where none is given: the uncertainty, with a lower limit for repeats alone."""
        if self.systematic is not None:
            return self.uncertainty
        finest = FINEST_ANGLE if self.unit == "deg" else FINEST_SHARE * abs(self.value)
        return max(self.uncertainty, finest)


def read_measurements(
    name: str, measurements: Iterable[Any], systematic: Any, unit: str
) -> RepeatedMeasurements:
    """Read measurements that are numbers or quantities such as ``"22 deg"``.

    Parameters
    ----------
    name : str
        Name of the response, for faults.
    measurements : iterable of float or str
        The measurements.
    systematic : float or str, optional
        Their systematic part; ``"1 %"`` is a share of the mean.
    unit : str
        Their unit; by default that of the first quantity.
    """
    is_list = isinstance(measurements, Iterable) and not isinstance(measurements, str)
    given = list(measurements) if is_list else []
    keys = {str(number): "measurements" for number in range(len(given))}
    owner = SimpleNamespace(name=name, unit=unit, **dict(zip(keys, given, strict=True)))
    read_quantities(owner, keys)
    values = [as_number(getattr(owner, key)) for key in keys]
    _refuse(_faults_of_values(name, given, values))
    mean = statistics.fmean(values)
    _refuse(_faults_of_share(name, mean, systematic))
    owner.systematic = share_of(systematic, mean)
    read_quantities(owner, {"systematic": "systematic"})
    _refuse(_faults_of_systematic(name, values, owner.systematic))
    width = None if systematic is None else float(owner.systematic)
    return RepeatedMeasurements(tuple(values), width, owner.unit)


def _refuse(faults: Iterator[Fault]) -> None:
    found = list(faults)
    if found:
        raise InputError(found)


def _faults_of_values(name: str, given: list[Any], values: list[float]) -> Iterator[Fault]:
    key = f"{name}.measurements"
    if len(values) < 2:
        yield messages.FEW_MEASUREMENTS.fault(key)
    for one, value in zip(given, values, strict=True):
        if not math.isfinite(value):
            yield messages.NO_NUMBER.fault(key, given=shown(one))


def _faults_of_share(name: str, mean: float, systematic: Any) -> Iterator[Fault]:
    if mean == 0 and isinstance(systematic, str) and percentage(systematic) is not None:
        yield messages.SHARE_OF_ZERO.fault(f"{name}.systematic", given=shown(systematic))


def _faults_of_systematic(name: str, values: list[float], systematic: Any) -> Iterator[Fault]:
    if systematic is None:
        if len(set(values)) == 1:
            yield messages.EQUAL_MEASUREMENTS.fault(f"{name}.measurements", value=values[0])
    elif not 0 < as_number(systematic) < math.inf:
        yield messages.NOT_ABOVE_ZERO.fault(f"{name}.systematic", given=shown(systematic))
