"""Repeated measurements of one curve: their mean, and how it scatters."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grainfit.errors import InputError
from grainfit.problem import messages
from grainfit.student import student_factor

Array = NDArray[np.float64]

#: Share of the points over which variances are averaged along the curve.
_WINDOW = 0.25
#: Share of the typical standard deviation below which that of no point falls.
_LEAST_DEVIATION = 0.1
#: Largest share of the variance that counts as common: points never agree to all digits.
_MOST_COMMON = 0.99


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
    def of(cls, name: str, curves: Iterable[tuple[ArrayLike, ArrayLike]]) -> RepeatedCurves:
        """Interpolate curves at those coordinates of the first one that all of them span.

        Raises
        ------
        InputError
            There are fewer than two curves, they are all equal, share fewer than two coordinates,
            or have something else than as many finite numbers on both axes, in order.
        """
        key = f"{name}.measurements"
        read = [_pair(key, curve) for curve in curves] if isinstance(curves, Iterable) else []
        if len(read) < 2:
            raise InputError(messages.FEW_CURVES.fault(key))
        first, last = max(x[0] for x, _ in read), min(x[-1] for x, _ in read)
        at = read[0][0][(read[0][0] >= first) & (read[0][0] <= last)]
        if len(at) < 2:
            raise InputError(messages.NO_COMMON_RANGE.fault(key, first=first, last=last))
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
