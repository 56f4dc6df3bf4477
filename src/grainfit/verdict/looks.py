"""Doubt that a search may stop with: the less, the more often it has looked at its answer."""

from __future__ import annotations

from bisect import bisect_right
from math import log1p

#: Looks after the first one, and the share of the accepted doubt that is left then. Simulated: of
#: answers up to a quarter of a tolerance beyond the edge, 5 % pass at any of the looks, with a
#: demanded probability of 95 % (`benchmarks/stopping.py`).
LOOKS = (0, 1, 2, 3, 5, 8, 12, 20, 30, 45, 70)
SHARES = (1.0, 1.0, 1.0, 0.87, 0.71, 0.60, 0.53, 0.45, 0.40, 0.37, 0.35)


def confidence_after(looks: int, confidence: float) -> float:
    """Return the probability at which a search stops that has looked so many times more than once.

    Parameters
    ----------
    looks : int
        Looks after the first one.
    confidence : float
        Demanded probability.

    Examples
    --------
    >>> confidence_after(0, 0.95)
    0.95
    """
    return 1 - _share_after(looks) * (1 - confidence)


def _share_after(looks: int) -> float:
    """Interpolate between the logarithms of the looks."""
    above = bisect_right(LOOKS, looks)
    if above == len(LOOKS):
        return SHARES[-1]
    low, high = LOOKS[above - 1], LOOKS[above]
    part = (log1p(looks) - log1p(low)) / (log1p(high) - log1p(low))
    return SHARES[above - 1] + part * (SHARES[above] - SHARES[above - 1])
