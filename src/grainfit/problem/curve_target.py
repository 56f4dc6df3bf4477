"""Measured curves: targets over a coordinate, such as stress over strain."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array
from grainfit.errors import Fault, InputError
from grainfit.formatting import in_usual_unit
from grainfit.messages import Message
from grainfit.problem import messages
from grainfit.problem.correlations import symmetric_matrix
from grainfit.problem.quantities import require_units
from grainfit.student import student_factor
from grainfit.units import percentage
from grainfit.validation import NOT_COMPUTABLE, SMALLEST_SHARE, as_number, is_computable, plain

#: Most points of a measured curve: the effort grows with their cube, and more say hardly more.
MOST_POINTS = 400
#: Share of a measured value below which the value that its percentages refer to never falls.
_LEAST_SHARE = 0.1
_ERRORS = ("uncertainty", "systematic")
#: Names in saved calibrations, where they are others: those of version 0.2.0.
_SAVED = {"systematic": "common_uncertainty"}
#: Smallest eigenvalue of a matrix of correlations that can be inverted.
_SMALLEST_EIGENVALUE = 1e-8
#: Smaller variances have lost digits.
_SMALLEST_VARIANCE = 1e-200
#: Share of the points over which variances are averaged along the curve.
_WINDOW = 0.25
#: Share of the typical standard deviation below which that of no point falls.
_LEAST_DEVIATION = 0.1
#: Largest share of the variance that counts as common: points never agree to all digits.
_MOST_COMMON = 0.99


@dataclass(frozen=True)
class CurveTarget:
    """A measured curve that the simulated curve of the same name has to meet.

    Its errors have two parts: one that is independent from point to point (noise of a sensor), and
    one that all points share (its calibration, the filling of the cell). With the second part, more
    points do not promise more than the measurement knows. The tolerance is apart from both.

    Parameters
    ----------
    name : str
        Name of the response.
    coordinates, values : sequence of float, shape (n,)
        The measured points in SI units, coordinates increasing.
    uncertainty : float, str or sequence of float, optional
        Standard uncertainty of the values that is independent from point to point, same unit;
        ``"2 %"`` is a share of each value.
    systematic : float, str or sequence of float
        Standard uncertainty that all points share: they are all too high, or all too low.
    tolerance : float, str or sequence of float, optional
        Largest accepted deviation of the expected curve at each point; ``"5 %"`` is a share of each
        value, and of a tenth of the largest where values are smaller. By default it follows from
        the uncertainties.
    covariance : array_like, shape (n, n), optional
        Covariance of the errors, instead of both.
    unit, coordinate_unit : str
        SI units, for display.
    coordinate : str
        Name of the coordinate, for display.

    Raises
    ------
    InputError
        The points are too few or too many, not finite or not in order, or the uncertainty is
        missing or not positive.

    Examples
    --------
    >>> stress = CurveTarget("stress", [0.01, 0.02], [2e3, 5e3], "2 %", systematic="1 %")
    >>> stress.covariance_about([2e3, 5e3]).round().tolist()
    [[2000.0, 1000.0], [1000.0, 12500.0]]
    """

    name: str
    coordinates: Sequence[float]
    values: Sequence[float]
    uncertainty: float | str | Sequence[float] | None = None
    systematic: float | str | Sequence[float] = 0.0
    tolerance: float | str | Sequence[float] | None = None
    covariance: ArrayLike | None = None
    unit: str = ""
    coordinate_unit: str = ""
    coordinate: str = ""

    if TYPE_CHECKING:
        # Arrays are read: attributes are sequences of numbers.
        def __init__(
            self,
            name: str,
            coordinates: Sequence[float] | Array,
            values: Sequence[float] | Array,
            uncertainty: float | str | Sequence[float] | Array | None = None,
            systematic: float | str | Sequence[float] | Array = 0.0,
            tolerance: float | str | Sequence[float] | Array | None = None,
            covariance: ArrayLike | None = None,
            unit: str = "",
            coordinate_unit: str = "",
            coordinate: str = "",
        ) -> None: ...

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(messages.NO_TARGET_NAME.fault("curve"))
        require_units(self, "unit", "coordinate_unit")
        for key in ("coordinates", "values"):
            object.__setattr__(self, key, self._numbers(key, getattr(self, key)))
        if fault := self._point_fault():
            raise InputError(fault)
        if self.tolerance is not None:
            self._read_tolerance()
        if self.covariance is not None:
            self._read_covariance(self.covariance)
            self._require_invertible("covariance")
            self._require_computable("covariance", self.standard_uncertainties)
            return
        for key in _ERRORS:
            object.__setattr__(self, key, self._read_error(key))
        if not (self._deviations("uncertainty", np.asarray(self.values)) > 0).all():
            self._refuse("uncertainty", messages.NOT_ABOVE_ZERO_EVERYWHERE)
        self._require_invertible("uncertainty")
        for key in _ERRORS:
            self._require_computable(key, self._deviations(key, np.asarray(self.values)))

    @classmethod
    def of_measurements(
        cls,
        name: str,
        curves: Iterable[tuple[ArrayLike, ArrayLike]],
        *,
        systematic: float | str = 0.0,
        **options: Any,
    ) -> CurveTarget:
        """Return the target of a curve that was measured several times.

        Its values are the means. What differs between the curves as a whole counts as an error that
        all points share, together with the systematic part; the rest is independent from point to
        point. Both are standard errors of the mean, with Student's factor for few curves.

        Parameters
        ----------
        name : str
            Name of the response.
        curves : iterable of (coordinates, values)
            At least two curves; the means are taken at those coordinates of the first one that all
            of them span.
        systematic : float or str, optional
            Standard uncertainty that all curves share, such as that of a load cell.
        **options
            Others of a `CurveTarget`, such as ``tolerance`` and ``unit``.

        Examples
        --------
        >>> presses = [([1, 2, 3], [10.0, 21.0, 29.0]), ([1, 2, 3], [11.0, 20.0, 33.0])]
        >>> CurveTarget.of_measurements("stress", presses, systematic="2 %").values
        (10.5, 20.5, 31.0)
        """
        repeats = RepeatedCurves.of(name, curves, options.get("coordinate_unit", ""))
        points = repeats.coordinates.tolist(), repeats.mean.tolist(), repeats.independent.tolist()
        instrument = cls(name, *points, systematic, **options)
        shared = instrument._deviations("systematic", repeats.mean)
        return replace(instrument, systematic=np.hypot(repeats.common, shared).tolist())

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> CurveTarget:
        """Return the curve of plain data that `to_json` made."""
        current = {saved: key for key, saved in _SAVED.items()}
        return cls(**{current.get(key, key): value for key, value in data.items()})

    def __repr__(self) -> str:
        return f"CurveTarget({self.name!r}, {len(self.values)} points, unit={self.unit!r})"

    def _refuse(self, key: str, message: Message, **values: Any) -> NoReturn:
        raise InputError(message.fault(f"{self.name}.{key}", **values))

    def _numbers(self, key: str, given: Any) -> tuple[float, ...]:
        try:
            numbers = tuple(as_number(number) for number in given)
        except TypeError:
            numbers = (math.nan,)
        if not all(map(math.isfinite, numbers)):
            self._refuse(key, messages.NOT_ALL_FINITE)
        for position, number in enumerate(numbers, 1):
            if not is_computable(number):
                given, remedy = repr(number), NOT_COMPUTABLE
                self._refuse(key, messages.BAD_POINT, given=given, position=position, remedy=remedy)
        return numbers

    def _point_fault(self) -> Fault | None:
        places, count, values = self.coordinates, len(self.coordinates), len(self.values)
        if count != values:
            return messages.UNEQUAL_NUMBERS.fault(self.name, count=count, values=values)
        if not 2 <= count <= MOST_POINTS:
            return messages.BAD_NUMBER_OF_POINTS.fault(self.name, count=count, most=MOST_POINTS)
        if any(later <= earlier for earlier, later in pairwise(places)):
            return messages.NOT_INCREASING.fault(f"{self.name}.coordinates")
        return None

    def _read_error(self, key: str) -> str | tuple[float, ...]:
        """Return an uncertainty as a percentage, or as one number for each point."""
        given = getattr(self, key)
        if given is None:
            self._refuse(key, messages.NO_UNCERTAINTY)
        if isinstance(given, str):
            if percentage(given) is None:
                self._refuse(key, messages.NO_PERCENTAGE, given=given)
            return given
        numbers = self._numbers(key, given if isinstance(given, Iterable) else [given])
        numbers = numbers * len(self.values) if len(numbers) == 1 else numbers
        if len(numbers) != len(self.values) or min(numbers) < 0:
            self._refuse(key, messages.DOES_NOT_FIT_POINTS)
        return numbers

    def _read_tolerance(self) -> None:
        object.__setattr__(self, "tolerance", self._read_error("tolerance"))
        if not (self.tolerances > 0).all():
            self._refuse("tolerance", messages.NOT_ABOVE_ZERO_EVERYWHERE)
        self._require_computable("tolerance", self.tolerances)

    @cached_property
    def tolerances(self) -> Array:
        """Largest accepted deviations at the points, shape (n,); infinite where none is given."""
        sizes = np.abs(np.asarray(self.values))
        if self.tolerance is None:
            return np.full(len(sizes), np.inf)
        return self._deviations("tolerance", np.maximum(sizes, _LEAST_SHARE * sizes.max()))

    def _deviations(self, key: str, values: Array) -> Array:
        """Return an uncertainty at every point; a percentage is a share of some values."""
        given = getattr(self, key)
        if isinstance(given, str):
            return np.asarray((percentage(given) or 0.0) * np.abs(values))
        return np.asarray(given, dtype=float)

    def _read_covariance(self, given: ArrayLike) -> None:
        key, points = f"{self.name}.covariance", range(1, len(self.values) + 1)
        if self.uncertainty is not None or np.any(np.asarray(self.systematic) != 0):
            self._refuse("covariance", messages.COVARIANCE_AND_UNCERTAINTIES)
        matrix = symmetric_matrix(given, [f"point {n}" for n in points], key, "point")
        object.__setattr__(self, "uncertainty", None)
        object.__setattr__(self, "systematic", 0.0)
        object.__setattr__(self, "covariance", tuple(map(tuple, matrix.tolist())))

    def _require_computable(self, key: str, errors: Array) -> None:
        """Raise `InputError` if standard uncertainties are of no size to compute with."""
        largest, size = float(np.max(errors)), float(np.max(np.abs(self.values)))
        if not all(map(is_computable, errors.tolist())):
            self._refuse(key, messages.BAD_LARGEST, largest=largest, remedy=NOT_COMPUTABLE)
        if 0 < largest < SMALLEST_SHARE * size:
            least = SMALLEST_SHARE
            self._refuse(key, messages.CURVE_TOO_EXACT, largest=largest, size=size, least=least)

    def _require_invertible(self, key: str) -> None:
        """Raise `InputError` unless the covariance of the errors can be inverted."""
        with np.errstate(over="ignore"):
            matrix = self.covariance_about(self.values)
        variances = np.diagonal(matrix)
        if np.isfinite(matrix).all() and (variances > _SMALLEST_VARIANCE).all():
            deviations = np.sqrt(variances)
            scaled = matrix / np.outer(deviations, deviations)
            if float(np.linalg.eigvalsh(scaled).min()) >= _SMALLEST_EIGENVALUE:
                return
        self._refuse(key, messages.NOT_POSITIVE_DEFINITE)

    def to_json(self) -> dict[str, Any]:
        """Return plain data, from which `from_json` makes the same curve."""
        errors = ("covariance",) if self.covariance is not None else _ERRORS
        keys = ["coordinates", "values", *errors, *(["tolerance"] if self.tolerance else [])]
        data = {_SAVED.get(key, key): _plain(getattr(self, key)) for key in keys}
        texts = ("name", "unit", "coordinate_unit", "coordinate")
        return {**{key: getattr(self, key) for key in texts}, **data}

    def measures_same(self, other: object) -> bool:
        """Return True if another curve is the same measurement: its points and errors are.

        Parameters
        ----------
        other : object
            The other curve; anything else was measured in another way.
        """
        if not isinstance(other, CurveTarget):
            return False
        mine, its = self.to_json(), other.to_json()
        keys = {"coordinates", "values", "covariance", *(_SAVED.get(key, key) for key in _ERRORS)}
        return all(mine.get(key) == its.get(key) for key in keys)

    def covariance_about(self, values: ArrayLike) -> Array:
        """Return the covariance of the errors if the true values are these, shape (n, n).

        Percentages are shares of the true values. Taken of the measured ones, a point that happens
        to be low counts as more certain than its neighbours, and drags the whole curve down as far
        as a common error allows: by n times its square, 1.2 % for 30 points and 2 %.

        Parameters
        ----------
        values : array_like, shape (n,)
            Smooth values, such as those of a simulated curve.

        References
        ----------
        D'Agostini (1994), Nucl. Instrum. Methods A 346, 306-311, on Peelle's puzzle.
        """
        if self.covariance is not None:
            return np.asarray(self.covariance, dtype=float)
        measured = np.abs(np.asarray(self.values))
        true = np.maximum(np.abs(np.asarray(values, dtype=float)), _LEAST_SHARE * measured)
        common = self._deviations("systematic", true)
        return np.diag(self._deviations("uncertainty", true) ** 2) + np.outer(common, common)

    @cached_property
    def standard_uncertainties(self) -> Array:
        """Standard uncertainty of each measured value, both parts together, shape (n,)."""
        return np.sqrt(np.diagonal(self.covariance_about(self.values)))


def _plain(value: Any) -> Any:
    return value if isinstance(value, str) else np.asarray(value).tolist()


@dataclass(frozen=True)
class RepeatedCurves:
    """Curves that were measured several times, at the same coordinates.

    Parameters
    ----------
    coordinates : ndarray, shape (n,)
        The coordinates.
    values : ndarray, shape (k, n)
        One row for each of at least two curves, not all equal.
    """

    coordinates: Array
    values: Array

    @classmethod
    def of(
        cls, name: str, curves: Iterable[tuple[ArrayLike, ArrayLike]], unit: str = ""
    ) -> RepeatedCurves:
        """Interpolate curves at those coordinates of the first one that all of them span.

        The unit is that of the coordinates, for messages.

        Raises
        ------
        InputError
            There are fewer than two curves, they are all equal, share fewer than two coordinates,
            or have something else than as many finite numbers on both axes, in order.
        """
        key = f"{name}.measurements"
        curves = plain(curves)
        read = [_pair(key, curve) for curve in curves] if isinstance(curves, Iterable) else []
        if len(read) < 2:
            raise InputError(messages.FEW_CURVES.fault(key))
        at = _common(key, [x for x, _ in read], unit)
        values = np.array([np.interp(at, x, y) for x, y in read])
        if np.ptp(values, axis=0).max() == 0:
            raise InputError(messages.EQUAL_CURVES.fault(key))
        return cls(at, values)

    @property
    def mean(self) -> Array:
        """Mean curve, shape (n,)."""
        return np.asarray(self.values.mean(axis=0))

    @property
    def independent(self) -> Array:
        """Standard error of the mean that differs from point to point, shape (n,)."""
        return self._of_mean(1 - self._common_share)

    @property
    def common(self) -> Array:
        """Standard error of the mean that all points share, shape (n,)."""
        return self._of_mean(self._common_share)

    def _of_mean(self, share: float) -> Array:
        count = len(self.values)
        factor = student_factor(count) * math.sqrt(share / count)
        return np.asarray(factor * self._deviations)

    @property
    def _deviations(self) -> Array:
        """Standard deviation at each point; few curves tell it of a stretch, not of a point."""
        variances = self.values.var(axis=0, ddof=1)
        reach = math.ceil(_WINDOW * len(variances) / 2)
        smooth = [
            variances[max(0, at - reach) : at + reach + 1].mean() for at in range(len(variances))
        ]
        least = _LEAST_DEVIATION**2 * variances.mean()
        return np.asarray(np.sqrt(np.maximum(smooth, least)))

    @property
    def _common_share(self) -> float:
        """Share of the variance by which whole curves differ, from the variance of their means."""
        count, points = self.values.shape
        scaled = (self.values - self.mean) / self._deviations
        total = float((scaled**2).sum()) / ((count - 1) * points)
        of_means = float((scaled.mean(axis=1) ** 2).sum()) / (count - 1) / total
        share = (points * of_means - 1) / (points - 1)
        return float(min(max(share, 0.0), _MOST_COMMON))


def _common(key: str, axes: Sequence[Array], unit: str) -> Array:
    """Return those coordinates of the first curve that all of them span; refuse fewer than two."""
    high = max(range(len(axes)), key=lambda at: axes[at][0])
    low = min(range(len(axes)), key=lambda at: axes[at][-1])
    first, last = axes[high][0], axes[low][-1]
    if first > last:
        ends = [_range(axes[at][0], axes[at][-1], unit) for at in (low, high)]
        named = {"low": low + 1, "low_range": ends[0], "high": high + 1, "high_range": ends[1]}
        raise InputError(messages.NO_OVERLAP.fault(key, **named))
    at = axes[0][(axes[0] >= first) & (axes[0] <= last)]
    if len(at) < 2:
        raise InputError(messages.NO_COMMON_RANGE.fault(key, span=_range(first, last, unit)))
    return np.asarray(at)


def _range(first: float, last: float, unit: str) -> str:
    return f"{in_usual_unit(float(first), unit)} to {in_usual_unit(float(last), unit)}"


def _pair(key: str, curve: Any) -> tuple[Array, Array]:
    """Return coordinates and values; raise `InputError` unless they make a curve."""
    try:
        x, y = (np.asarray(axis, dtype=float) for axis in curve)
    except (TypeError, ValueError):
        raise InputError(messages.NO_PAIR.fault(key)) from None
    fits = x.ndim == y.ndim == 1 and len(x) == len(y) >= 2
    if not fits or not (np.isfinite(x).all() and np.isfinite(y).all() and (np.diff(x) > 0).all()):
        raise InputError(messages.NO_PAIR.fault(key))
    return x, y
