"""Targets: measured values that simulated responses have to meet."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, get_args

from grainfit.errors import Fault, InputError
from grainfit.formatting import short_repr
from grainfit.problem import messages
from grainfit.problem.quantities import (
    make_floats,
    read_quantities,
    require_units,
    share_of,
    shown,
)
from grainfit.student import NORMAL_QUANTILE, student_factor
from grainfit.units import percentage
from grainfit.validation import NOT_COMPUTABLE, SMALLEST_SHARE, as_number, is_computable, plain

#: Relative tolerance of a target for which neither an uncertainty nor a tolerance is given.
DEFAULT_RELATIVE_TOLERANCE = 0.02
#: Largest weight of a target; the smallest is its inverse.
LARGEST_WEIGHT = 1e6

Statistic = Literal["mean", "median"]
_TARGET_WIDTHS = ("uncertainty", "tolerance")
#: Finest tolerances that repeats alone can give: they do not show what is wrong in all of them.
FINEST_SHARE = 0.01
FINEST_ANGLE = 0.5


@dataclass(frozen=True)
class Target:
    """A measured value that the simulated response of the same name has to meet.

    Parameters
    ----------
    name : str
        Name of the response.
    value : float or str
        Measured value, of any sign: a number in SI units, angles in degrees, or a quantity such as
        ``"22 deg"``.
    uncertainty : float or str, optional
        Standard uncertainty of the measured value, same unit; ``"1 %"`` is a share of the value,
        unless that is zero.
    tolerance : float or str, optional
        Largest accepted deviation of the expected response, same unit; by default the uncertainty,
        or 2 % of the value if that is not given either. A value of zero needs one of them.
    weight : float
        Factor on this target's deviation in the misfit (equation 1 of the method has equal
        weights).
    unit : str
        SI unit, for display; by default that of the quantities.
    statistic : {"mean", "median"}
        Expected response: the mean over seeds, with jams and other outlying runs, or the median,
        which these do not move.

    Examples
    --------
    >>> Target("angle_of_repose", "22 deg", uncertainty="2 %").tolerance
    0.44
    >>> Target("dilatancy", "-0.1 mm", tolerance="0.2 mm").is_relative
    False
    """

    name: str
    value: float
    uncertainty: float | None = None
    # None until `__post_init__` computes the default: the attribute is always a float.
    tolerance: float = None  # type: ignore[assignment]
    weight: float = 1.0
    unit: str = ""
    statistic: Statistic = "mean"

    if TYPE_CHECKING:
        # Quantities are read: attributes are numbers.
        def __init__(
            self,
            name: str,
            value: float | str,
            uncertainty: float | str | None = None,
            tolerance: float | str | None = None,
            weight: float = 1.0,
            unit: str = "",
            statistic: Statistic = "mean",
        ) -> None: ...

    def __post_init__(self) -> None:
        require_units(self, "unit")
        read_quantities(self, {"value": "value"})
        _require_shares(self)
        shares = {key: share_of(getattr(self, key), self.value) for key in _TARGET_WIDTHS}
        for key, share in shares.items():
            object.__setattr__(self, key, share)
        read_quantities(self, {key: key for key in _TARGET_WIDTHS})
        InputError.raise_for(list(_target_faults(self)) or self._faults_of_size())
        if self.tolerance is None:
            object.__setattr__(self, "tolerance", self._usual_tolerance)
        make_floats(self, "value", "uncertainty", "tolerance", "weight")

    @classmethod
    def of_measurements(
        cls,
        name: str,
        measurements: Iterable[float | str],
        *,
        systematic: float | str | None = None,
        tolerance: float | str | None = None,
        weight: float = 1.0,
        unit: str = "",
        statistic: Statistic = "mean",
    ) -> Target:
        """Return the target of repeated measurements.

        The value is their mean. The uncertainty combines its standard error, with Student's factor
        for few measurements, and the systematic part.

        Parameters
        ----------
        name, weight, unit, statistic
            As of a `Target`.
        measurements : iterable of float or str
            At least two numbers or quantities.
        systematic : float or str, optional
            Standard uncertainty that all measurements share, such as that of a scale or a
            protractor; ``"1 %"`` is a share of their mean.
        tolerance : float or str, optional
            Largest accepted deviation of the expected response: what is good enough. By default
            the uncertainty; without a systematic part at least 1 % of the value, or 0.5 degrees.

        Examples
        --------
        >>> Target.of_measurements("angle_of_repose", ["22 deg", "22.1 deg"]).tolerance
        0.5
        """
        repeats = read_measurements(name, measurements, systematic, unit)
        return cls(
            name,
            repeats.value,
            uncertainty=repeats.uncertainty,
            tolerance=repeats.tolerance if tolerance is None else tolerance,
            weight=weight,
            unit=repeats.unit,
            statistic=statistic,
        )

    def _faults_of_size(self) -> list[Fault]:
        return _faults_of_size(self)

    @property
    def _usual_tolerance(self) -> float:
        if self.uncertainty is not None:
            return self.uncertainty
        return DEFAULT_RELATIVE_TOLERANCE * abs(self.value)

    def __repr__(self) -> str:
        return short_repr(self, "name", "value")

    def to_json(self) -> dict[str, Any]:
        """Return plain data of the target, without a tolerance that equals the default.

        So the identity of a calibration does not depend on whether the default was given.
        """
        data = asdict(self)
        if self.statistic == "mean":
            del data["statistic"]
        return {**data, "tolerance": None} if self.tolerance == self._usual_tolerance else data

    def measures_same(self, other: object) -> bool:
        """Return True if another target is the same measurement: its value and uncertainty are.

        Parameters
        ----------
        other : object
            The other target; anything else was measured in another way.
        """
        if not isinstance(other, Target):
            return False
        return (self.value, self.uncertainty) == (other.value, other.uncertainty)

    @property
    def is_relative(self) -> bool:
        """Whether deviations relative to the value make sense.

        They do not if zero is within the tolerance: responses that meet the target may then have
        either sign, and be any multiple of the value.
        """
        return abs(self.value) > self.tolerance

    @property
    def misfit_unit(self) -> float:
        """Deviation that counts as 1 in the misfit, in the unit of the target.

        It is the absolute value where deviations are relative; elsewhere the value of which the
        tolerance would be 2 %, so that targets of both kinds have similar weights.
        """
        return abs(self.value) if self.is_relative else self.tolerance / DEFAULT_RELATIVE_TOLERANCE

    @property
    def standard_uncertainty(self) -> float:
        """Standard uncertainty of the measured value, in its unit.

        If none is given, the tolerance is read as a 95 % interval.
        """
        return self.tolerance / NORMAL_QUANTILE if self.uncertainty is None else self.uncertainty

    def misfit(self, response: float) -> float:
        """Return the deviation of a response from the target in units of `misfit_unit`.

        References
        ----------
        Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), equation 1, for relative deviations.
        """
        return (response - self.value) / self.misfit_unit

    def relative_deviation(self, response: float) -> float | None:
        """Return the deviation of a response from the target as a share of the absolute value.

        None where that makes no sense, see `is_relative`.
        """
        return self.misfit(response) if self.is_relative else None

    def is_met_by(self, response: float) -> bool:
        """Return True if a response deviates from the target by at most its tolerance."""
        return abs(response - self.value) <= self.tolerance


def _require_shares(target: Target) -> None:
    """Raise `InputError` if an uncertainty or a tolerance is a percentage of zero."""
    given = {key: getattr(target, key) for key in _TARGET_WIDTHS}
    InputError.raise_for(
        messages.SHARE_OF_ZERO.fault(f"{target.name}.{key}", given=shown(text))
        for key, text in given.items()
        if isinstance(text, str) and percentage(text) is not None and as_number(target.value) == 0
    )


def _target_faults(target: Target) -> Iterator[Fault]:
    name = target.name
    if not isinstance(name, str) or not name:
        yield messages.NO_TARGET_NAME.fault("target")
        return
    known = get_args(Statistic)
    if target.statistic not in known:
        given = shown(target.statistic)
        yield messages.NO_STATISTIC.fault(f"{name}.statistic", given=given, known=", ".join(known))
    if not math.isfinite(as_number(target.value)):
        yield messages.NO_NUMBER.fault(f"{name}.value", given=shown(target.value))
    elif target.value == 0 and target.tolerance is None and target.uncertainty is None:
        yield messages.NO_DEFAULT_TOLERANCE.fault(f"{name}.tolerance")
    for key in (*_TARGET_WIDTHS, "weight"):
        number = getattr(target, key)
        left_out = number is None and key != "weight"
        if not left_out and not 0 < as_number(number) < math.inf:
            yield messages.NOT_ABOVE_ZERO.fault(f"{name}.{key}", given=shown(number))


def _faults_of_size(target: Target) -> list[Fault]:
    """Return the faults of numbers that are too large or too small, alone or beside others."""
    given = {key: getattr(target, key) for key in ("value", *_TARGET_WIDTHS)}
    sizes = {key: abs(float(number)) for key, number in given.items() if number is not None}
    faults = [
        messages.BAD_SIZE.fault(f"{target.name}.{key}", given=given[key], remedy=NOT_COMPUTABLE)
        for key, size in sizes.items()
        if not is_computable(size)
    ]
    if not 1 / LARGEST_WEIGHT <= target.weight <= LARGEST_WEIGHT:
        key = f"{target.name}.weight"
        least, most = 1 / LARGEST_WEIGHT, LARGEST_WEIGHT
        faults.append(messages.BAD_WEIGHT.fault(key, given=target.weight, least=least, most=most))
    other = max(sizes, key=lambda key: sizes[key])
    return faults or [
        messages.TOO_EXACT.fault(
            f"{target.name}.{key}",
            width=width,
            other=other,
            size=sizes[other],
            least=SMALLEST_SHARE,
        )
        for key, width in sizes.items()
        if key != "value" and width < SMALLEST_SHARE * sizes[other]
    ]


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
    measurements = plain(measurements)
    is_list = isinstance(measurements, Iterable) and not isinstance(measurements, str)
    given = list(measurements) if is_list else []
    keys = {str(number): "measurements" for number in range(len(given))}
    owner = SimpleNamespace(name=name, unit=unit, **dict(zip(keys, given, strict=True)))
    require_units(owner, "unit")
    read_quantities(owner, keys)
    values = [as_number(getattr(owner, key)) for key in keys]
    InputError.raise_for(_faults_of_values(name, given, values))
    mean = statistics.fmean(values)
    InputError.raise_for(_faults_of_share(name, mean, systematic))
    owner.systematic = share_of(systematic, mean)
    read_quantities(owner, {"systematic": "systematic"})
    InputError.raise_for(_faults_of_systematic(name, values, owner.systematic))
    width = None if systematic is None else float(owner.systematic)
    return RepeatedMeasurements(tuple(values), width, owner.unit)


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
