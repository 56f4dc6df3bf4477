"""95 % intervals of the parameters that hold the answer."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.analysis.posterior import Posterior
from grainfit.problem import Parameter, Problem
from grainfit.result import ParameterInterval
from grainfit.student import LEVEL
from grainfit.which_test.determination import interval_of


def parameter_intervals(
    posterior: Posterior,
    problem: Problem,
    answer: Mapping[str, float] | None = None,
    biases: Mapping[str, str] | None = None,
) -> dict[str, ParameterInterval]:
    """Return the 95 % interval of each parameter, which holds the answer.

    It is the credible interval of the posterior, which contains a bound that it can hardly exclude
    (see `extended_to_bounds`), extended to the answer where that lies outside: on a ridge, the
    answer with the largest time step is at an end. So it holds the true value with a probability
    of 95 to 97.5 %, and a parameter that is not determined has its whole interval.

    Parameters
    ----------
    posterior : Posterior
        A sample of the parameter sets that agree with the measurements.
    problem : Problem
        Has the intervals before the tests.
    answer : mapping of str to float, optional
        The calibrated values; without them, the intervals hold none.
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
    low, high = posterior.interval(parameter.name, LEVEL)
    if answer is not None:
        low, high = min(low, answer), max(high, answer)
    return interval_of(parameter, low, high, bias)
