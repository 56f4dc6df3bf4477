"""Credible intervals of single parameters within the unit cube, which can contain its bounds."""

from __future__ import annotations

import numpy as np

from grainfit.arrays import Array

#: Share of the width of an interval within which a bound belongs to it. Beyond the ends of a 95 %
#: interval, the density is then a quarter of that inside, or more.
_NEAR = 0.1


def extended_to_bounds(low: Array, high: Array) -> tuple[Array, Array]:
    """Extend equal-tailed credible intervals to bounds that they can hardly exclude.

    An equal-tailed interval never contains a bound, however probable the values at it are. So an
    end goes to its bound, 0 or 1, when the tail between them is shorter than a tenth of the
    interval: a normal distribution is then cut off 2.35 standard deviations from its middle.
    No value is lost; an interval with one end on a bound contains 97.5 %, with both all.

    Parameters
    ----------
    low, high : ndarray
        Ends of equal-tailed intervals, 0 to 1, of any shape.

    Returns
    -------
    low, high : ndarray
    """
    near = _NEAR * (high - low)
    return np.where(low <= near, 0.0, low), np.where(1.0 - high <= near, 1.0, high)
