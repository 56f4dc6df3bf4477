"""Rule of the verdict on predictions for an apparatus that was not simulated, or once."""

from __future__ import annotations

import math
from collections.abc import Iterable

from grainfit.verdict.rule import Status, Verdict


def probability_within(expected: float, error: float, value: float, tolerance: float) -> float:
    """Return the probability that an expected response is within a tolerance of a value.

    Parameters
    ----------
    expected, error : float
        The response and its standard error, normally distributed.
    value, tolerance : float
        The measured value, and the largest accepted deviation.
    """
    if error <= 0:
        return float(abs(expected - value) <= tolerance)

    def below(limit: float) -> float:
        return 0.5 * (1 + math.erf((limit - expected) / (error * math.sqrt(2))))

    return below(value + tolerance) - below(value - tolerance)


def verdict_of(probability: float, confidence: float) -> Verdict:
    """Return the verdict on a response with a probability to be within its tolerance."""
    if probability >= confidence:
        return "met"
    return "missed" if probability <= 1 - confidence else "in doubt"


def status_at_full_size(probabilities: Iterable[float], confidence: float) -> Status:
    """Return the verdict on an answer of which runs at full size were made.

    Parameters
    ----------
    probabilities : iterable of float
        Of each target to be within its tolerance, of independent errors.
    confidence : float
        Demanded probability that all are.
    """
    every = math.prod(probabilities)
    if every >= confidence:
        return "calibrated"
    return "out_of_tolerance" if every <= 1 - confidence else "undecided"
