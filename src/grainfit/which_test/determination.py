"""How far a 95 % interval is narrowed, and the word for it."""

from __future__ import annotations

from grainfit.materials.card import Determination
from grainfit.problem import Parameter
from grainfit.result import ParameterInterval
from grainfit.student import LEVEL, NORMAL_QUANTILE
from grainfit.verdict.out_of_reach import Bound

#: Width of a 95 % interval over that before the tests: up to the first determined, from the second
#: on not determined.
DETERMINED = 0.25
OPEN = 0.9


def interval_of(parameter: Parameter, low: float, high: float, bias: str = "") -> ParameterInterval:
    """Return a 95 % interval with the word for its width.

    A parameter with a measurement of its own is determined by it.

    Parameters
    ----------
    parameter : Parameter
        The parameter.
    low, high : float
        Ends.
    bias : str
        Reason why the value is biased; see `grainfit.analysis.soft_particles.known_biases`.
    """
    if parameter.measured is not None:
        return ParameterInterval(low, high, "determined")
    word = determination(narrowing(parameter, low, high))
    if bias and word == "determined":
        word = "determined, but biased"
    return ParameterInterval(low, high, word, bias)


def bound_reached(parameter: Parameter, found: ParameterInterval) -> Bound | None:
    """Return the only bound that an interval contains; None for both, which is all of it."""
    at_min, at_max = found.low <= parameter.minimum, found.high >= parameter.maximum
    if at_min == at_max:
        return None
    return "min" if at_min else "max"


def narrowing(parameter: Parameter, low: float, high: float) -> float:
    """Return the width of a 95 % interval over that before the tests, 0 to 1.

    The width of logarithms for a parameter with ``scale="log"``.
    """
    if parameter.uncertainty is not None:
        return min(max(high - low, 0.0) / (2 * NORMAL_QUANTILE * parameter.uncertainty), 1.0)
    width = parameter.to_unit(high) - parameter.to_unit(low)
    return min(max(width, 0.0) / LEVEL, 1.0)


def determination(narrowing: float) -> Determination:
    """Return the word for a parameter whose interval was narrowed to a share of its width."""
    if narrowing <= DETERMINED:
        return "determined"
    return "narrowed" if narrowing <= OPEN else "not determined"
