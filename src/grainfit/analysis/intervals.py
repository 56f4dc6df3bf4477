"""95 % intervals of the parameters that hold the answer."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.analysis.posterior import Posterior
from grainfit.problem import Parameter, Problem
from grainfit.result import ParameterInterval
from grainfit.which_test.determination import interval_of

_LEVEL = 0.95


def parameter_intervals(
    posterior: Posterior,
    problem: Problem,
    answer: Mapping[str, float] | None = None,
    biases: Mapping[str, str] | None = None,
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
    biases : mapping of str to str, optional
        Reasons why parameters are biased, by name.

    Returns
    -------
    dict of str to ParameterInterval
    """
    return {
        parameter.name: _interval(
            posterior,
            parameter,
            (answer or {}).get(parameter.name),
            (biases or {}).get(parameter.name, ""),
        )
        for parameter in problem.parameters
    }


def _interval(
    posterior: Posterior, parameter: Parameter, answer: float | None, bias: str
) -> ParameterInterval:
    low, high = posterior.interval(parameter.name, _LEVEL)
    if answer is not None:
        low, high = min(low, answer), max(high, answer)
    return interval_of(parameter, low, high, bias)
