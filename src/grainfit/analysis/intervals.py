"""95 % intervals of the parameters that hold the answer, and whether the runs determine it."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.analysis.posterior import Posterior
from grainfit.materials.card import Determination
from grainfit.metamodels.likelihood import NORMAL_QUANTILE
from grainfit.problem import Parameter, Problem
from grainfit.result import ParameterInterval

#: Width of a 95 % interval over that before the tests: up to the first determined, from the second
#: on not determined.
DETERMINED = 0.25
OPEN = 0.9
_LEVEL = 0.95


def parameter_intervals(
    posterior: Posterior, problem: Problem, answer: Mapping[str, float] | None = None
) -> dict[str, ParameterInterval]:
    """Return the 95 % interval of each parameter, which holds the answer.

    It is the equal-tailed credible interval, extended to the answer where that lies outside. That
    happens although the answer agrees with the measurements: on a ridge, the largest time step is
    at an end, and an answer on a bound of its interval is always in a tail. An extended interval
    leaves out only the other tail, so it holds the true value with a probability of 95 to 97.5 %,
    and no value of the equal-tailed interval is lost.

    Parameters
    ----------
    posterior : Posterior
        A sample of the parameter sets that agree with the measurements.
    problem : Problem
        Has the intervals before the tests.
    answer : mapping of str to float, optional
        The calibrated values; without them, the intervals are equal-tailed.

    Returns
    -------
    dict of str to ParameterInterval
    """
    return {
        parameter.name: _interval(posterior, parameter, (answer or {}).get(parameter.name))
        for parameter in problem.parameters
    }


def _interval(
    posterior: Posterior, parameter: Parameter, answer: float | None
) -> ParameterInterval:
    low, high = posterior.interval(parameter.name, _LEVEL)
    if answer is not None:
        low, high = min(low, answer), max(high, answer)
    return interval_of(parameter, low, high)


def interval_of(parameter: Parameter, low: float, high: float) -> ParameterInterval:
    """Return a 95 % interval with the word for its width.

    A parameter with a measurement of its own is determined by it.
    """
    if parameter.measured is not None:
        return ParameterInterval(low, high, "determined")
    return ParameterInterval(low, high, determination(narrowing(parameter, low, high)))


def narrowing(parameter: Parameter, low: float, high: float) -> float:
    """Return the width of a 95 % interval over that before the tests, 0 to 1.

    The width of logarithms for a parameter with ``scale="log"``.
    """
    if parameter.uncertainty is not None:
        return min(max(high - low, 0.0) / (2 * NORMAL_QUANTILE * parameter.uncertainty), 1.0)
    width = parameter.to_unit(high) - parameter.to_unit(low)
    return min(max(width, 0.0) / _LEVEL, 1.0)


def determination(narrowing: float) -> Determination:
    """Return the word for a parameter whose interval was narrowed to a share of its width."""
    if narrowing <= DETERMINED:
        return "determined"
    return "narrowed" if narrowing <= OPEN else "not determined"
