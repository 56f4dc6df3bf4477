"""Knowledge of the parameters, and what measurements add to it: linear, with normal errors.

Parameters are counted in relative units: 0.1 is 10 % of a value, or 0.1 in its logarithm. So a
standard deviation is a share of the value, and a slope says by how many percent a response changes
when a parameter changes by 1 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array
from grainfit.problem import Parameter
from grainfit.student import NORMAL_QUANTILE

#: Standard deviation of an even spread over an interval of the length 1.
_EVEN = math.sqrt(1.0 / 12.0)


@dataclass(frozen=True)
class Knowledge:
    """Parameters with their uncertainties, in relative units.

    Parameters
    ----------
    names : tuple of str
        The parameters.
    covariance : ndarray, shape (d, d)
        Of the parameters.
    """

    names: tuple[str, ...]
    covariance: Array

    @classmethod
    def of_intervals(cls, parameters: Sequence[Parameter]) -> Knowledge:
        """Return what is known before any test: an even spread over each interval.

        A parameter that was measured on its own has the uncertainty of that measurement.
        """
        variances = [_deviation_before(parameter) ** 2 for parameter in parameters]
        return cls(tuple(p.name for p in parameters), np.diag(np.array(variances, dtype=float)))

    def after(self, slopes: Sequence[Mapping[str, float]], errors: ArrayLike) -> Knowledge:
        """Return what is known when responses have been measured.

        The covariance P becomes (P⁻¹ + Jᵀ S⁻¹ J)⁻¹, with J the slopes and S the covariance of the
        errors.

        Parameters
        ----------
        slopes : sequence of mapping of str to float
            d ln y / d ln p of each response by name of the parameter; 0 for those not named.
        errors : array_like, shape (n, n)
            Covariance of the relative differences between measured and simulated responses at the
            true parameters.

        Examples
        --------
        >>> before = Knowledge(("friction",), np.array([[0.04]]))
        >>> round(before.after([{"friction": 0.5}], [[0.01]]).deviation("friction"), 3)
        0.141
        """
        if not slopes or not self.names:
            return self
        jacobian = np.array([[slope.get(name, 0.0) for name in self.names] for slope in slopes])
        seen = jacobian @ self.covariance
        change = seen.T @ np.linalg.solve(seen @ jacobian.T + errors, seen)
        return Knowledge(self.names, self.covariance - (change + change.T) / 2)

    def without(self, names: Sequence[str]) -> Knowledge:
        """Return it without some parameters, as if they were not free."""
        kept = [i for i, name in enumerate(self.names) if name not in names]
        return Knowledge(tuple(self.names[i] for i in kept), self.covariance[np.ix_(kept, kept)])

    def variance_along(self, slopes: Mapping[str, float]) -> float:
        """Return the variance of a response with these slopes."""
        row = np.array([slopes.get(name, 0.0) for name in self.names])
        return max(float(row @ self.covariance @ row), 0.0)

    def deviation(self, name: str) -> float:
        """Return the standard deviation of a parameter, a share of its value."""
        position = self.names.index(name)
        return math.sqrt(max(float(self.covariance[position, position]), 0.0))

    def half_width(self, name: str) -> float:
        """Return half the width of the 95 % interval of a parameter, a share of its value."""
        return NORMAL_QUANTILE * self.deviation(name)


def even_deviation(parameter: Parameter) -> float:
    """Return the standard deviation of an even spread over an interval, in relative units."""
    low, high = parameter.minimum, parameter.maximum
    is_log = parameter.scale == "log"
    return _EVEN * (math.log(high / low) if is_log else (high - low) / _middle(parameter))


def _deviation_before(parameter: Parameter) -> float:
    """Return the standard deviation of a parameter before any test, in relative units."""
    spread = even_deviation(parameter)
    if parameter.measured is None or parameter.uncertainty is None:
        return spread
    return min(spread, parameter.uncertainty / _middle(parameter))


def _middle(parameter: Parameter) -> float:
    """Return the value to which relative units of a parameter refer, above zero."""
    low, high = parameter.minimum, parameter.maximum
    # An interval about zero has no middle to refer to.
    return abs(low + high) / 2 or high - low


def in_relative_units(parameter: Parameter, values: Array) -> Array:
    """Return values of a parameter in relative units: ln p, or p over its middle.

    The logarithm where the interval is above zero.
    """
    return np.log(values) if parameter.minimum > 0 else values / _middle(parameter)


def in_si_units(parameter: Parameter, values: Array) -> Array:
    """Return values of a parameter from relative units, see `in_relative_units`."""
    return np.asarray(np.exp(values) if parameter.minimum > 0 else values * _middle(parameter))
