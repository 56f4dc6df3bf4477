"""Information that measurements give about parameters: linear, with normal errors.

Parameters are counted in relative units: 0.1 is 10 % of a value, or 0.1 in its logarithm. So a
standard deviation is a share of the value, and a slope says by how many percent a response changes
when a parameter changes by 1 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.base import ResponseInfo
from grainfit.problem import Parameter

Array = NDArray[np.float64]

#: Half the width of a 95 % interval in standard deviations.
NORMAL_QUANTILE = 1.96
#: Runs whose mean scatters as the expected response at the end of a calibration does.
RUNS = 5
#: Variance of an even spread over an interval of the length 1.
_EVEN = 1.0 / 12.0


@dataclass(frozen=True)
class Observation:
    """A response that is measured, as far as it tells about parameters.

    Parameters
    ----------
    name : str
        Name of the response, with that of its test.
    slopes : mapping of str to float
        d ln y / d ln p by name of the parameter; 0 for those that are not named.
    variance : float
        Of the relative difference between measured and simulated response at the true parameters.
    """

    name: str
    slopes: Mapping[str, float]
    variance: float


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

    def after(self, observations: Sequence[Observation], covariances: ArrayLike = 0.0) -> Knowledge:
        """Return what is known when responses have been measured.

        Parameters
        ----------
        observations : sequence of Observation
            The responses.
        covariances : array_like, shape (n, n)
            Covariances of the errors of different observations, relative, with zeros on the
            diagonal; by default they are not correlated.

        Examples
        --------
        >>> before = Knowledge(("friction",), np.array([[0.04]]))
        >>> after = before.after([Observation("angle", {"friction": 0.5}, 0.01)])
        >>> round(after.deviation("friction"), 3)
        0.141
        """
        if not observations or not self.names:
            return self
        slopes = np.array([[o.slopes.get(name, 0.0) for name in self.names] for o in observations])
        seen = slopes @ self.covariance
        total = seen @ slopes.T + np.diag([o.variance for o in observations]) + covariances
        change = seen.T @ np.linalg.solve(total, seen)
        return Knowledge(self.names, self.covariance - (change + change.T) / 2)

    def without(self, names: Sequence[str]) -> Knowledge:
        """Return it without some parameters, as if they were not free."""
        kept = [i for i, name in enumerate(self.names) if name not in names]
        return Knowledge(tuple(self.names[i] for i in kept), self.covariance[np.ix_(kept, kept)])

    def deviation(self, name: str) -> float:
        """Return the standard deviation of a parameter, a share of its value."""
        position = self.names.index(name)
        return math.sqrt(max(float(self.covariance[position, position]), 0.0))

    def half_width(self, name: str) -> float:
        """Return half the width of the 95 % interval of a parameter, a share of its value."""
        return NORMAL_QUANTILE * self.deviation(name)


def even_deviation(parameter: Parameter) -> float:
    """Return the standard deviation of an even spread over an interval, in relative units."""
    return math.sqrt(_EVEN) * extent(parameter)


def _deviation_before(parameter: Parameter) -> float:
    """Standard deviation of a parameter before any test, in relative units."""
    spread = even_deviation(parameter)
    if parameter.measured is None or parameter.uncertainty is None:
        return spread
    return min(spread, parameter.uncertainty / middle(parameter))


def extent(parameter: Parameter) -> float:
    """Return the length of an interval in relative units, in its middle."""
    low, high = parameter.minimum, parameter.maximum
    if parameter.scale == "log":
        return log(high / low)
    return (high - low) / middle(parameter)


def middle(parameter: Parameter) -> float:
    """Return the value to which relative units of a parameter refer, above zero."""
    low, high = parameter.minimum, parameter.maximum
    # An interval about zero has no middle to refer to.
    return abs(low + high) / 2 or high - low


def in_relative_units(parameter: Parameter, values: Array) -> Array:
    """Return values of a parameter in relative units: ln p, or p over its middle.

    The logarithm where the interval is above zero.
    """
    return np.log(values) if parameter.minimum > 0 else values / middle(parameter)


def in_si_units(parameter: Parameter, values: Array) -> Array:
    """Return values of a parameter from relative units, see `in_relative_units`."""
    return np.asarray(np.exp(values) if parameter.minimum > 0 else values * middle(parameter))


@dataclass(frozen=True)
class Measurable:
    """A response that a laboratory can measure.

    Parameters
    ----------
    name : str
        Name of the response, with that of its test.
    value : float
        Expected value, in its unit.
    accuracy : Accuracy
        Of its measurement.
    slopes : mapping of str to float
        d ln y / d ln p by name of the parameter; 0 for those that are not named.
    scatter : float
        Relative standard deviation from run to run; a calibration averages it over `RUNS` runs.
    slope_variance : float
        Relative variance that the uncertainty of the slopes adds.
    unit : str
        Its unit.
    """

    name: str
    value: float
    accuracy: Accuracy
    slopes: Mapping[str, float]
    scatter: float
    slope_variance: float = 0.0
    unit: str = ""

    def observation(self, coarser: float = 1.0) -> Observation:
        """Return what its measurement tells, with an accuracy that is coarser by a factor."""
        uncertainty = coarser * self.accuracy.of(self.value) / abs(self.value)
        variance = uncertainty**2 + self.scatter**2 / RUNS + self.slope_variance
        return Observation(self.name, self.slopes, variance)

    def signal(self, before: Knowledge) -> float:
        """Return by how much it differs over what is known of the parameters, over its error."""
        seen = self.observation()
        slopes = np.array([seen.slopes.get(name, 0.0) for name in before.names])
        return math.sqrt(max(float(slopes @ before.covariance @ slopes), 0.0) / seen.variance)


def recorded_measurable(
    name: str,
    info: ResponseInfo,
    material: Mapping[str, float],
    value: float,
    accuracy: Accuracy,
) -> Measurable | None:
    """Return a response with its recorded sensitivities; None without them.

    None as well for a value of zero: the sensitivities are relative to it.

    Parameters
    ----------
    name : str
        Name of the response, with that of its test.
    info : ResponseInfo
        Has the sensitivities.
    material : mapping of str to float
        Where the slopes are taken.
    value : float
        Expected value.
    accuracy : Accuracy
        Of the measurement.
    """
    known = info.sensitivities
    if known is None or value == 0:
        return None
    return Measurable(name, value, accuracy, known.at(material), known.scatter, unit=info.unit)
