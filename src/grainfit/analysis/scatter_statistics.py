"""Statistics of responses that scatter from seed to seed, with a confidence of 95 %."""

from __future__ import annotations

import math

from scipy.special import gammaincinv, ndtri, stdtrit

from grainfit.student import LEVEL

#: Runs at one parameter set from which on a calibration becomes expensive, and something else helps
#: more: the budget of the sequential search is 20 runs per free parameter.
MANY_RUNS = 20


def half_interval_of_mean(count: int) -> float:
    """Return half of the interval of a mean of runs, in their standard deviations (Student's t).

    Examples
    --------
    >>> round(half_interval_of_mean(4), 3)
    1.591
    """
    return float(stdtrit(count - 1, (1 + LEVEL) / 2)) / math.sqrt(count)


def runs_within(deviation: float, tolerance: float) -> int:
    """Return how many runs have a mean within a tolerance of the expected value.

    Parameters
    ----------
    deviation : float
        Standard deviation of single runs.
    tolerance : float
        Above zero.

    Examples
    --------
    >>> runs_within(2.0, 1.0)
    16
    """
    quantile = float(ndtri((1 + LEVEL) / 2))
    return max(1, math.ceil((quantile * deviation / tolerance) ** 2))


def interval_of_deviation(deviation: float, count: int) -> tuple[float, float]:
    """Return the interval of the standard deviation of runs (chi-squared).

    Examples
    --------
    >>> tuple(round(end, 3) for end in interval_of_deviation(1.0, 10))
    (0.688, 1.826)
    """
    freedom = count - 1
    low, high = (2 * float(gammaincinv(freedom / 2, (1 + side * LEVEL) / 2)) for side in (-1, 1))
    squares = freedom * deviation**2
    return math.sqrt(squares / high), math.sqrt(squares / low)
