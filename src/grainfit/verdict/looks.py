"""Doubt that a search may stop with: the less, the more often it has looked at its answer."""

from __future__ import annotations

import numpy as np

#: Looks after the first one, and the share of the accepted doubt that is left then. Simulated: of
#: answers exactly on the edge of a tolerance, as many pass after all looks as after a single one
#: with all of the doubt (`benchmarks/stopping.py`).
LOOKS = (0, 1, 2, 3, 5, 8, 12, 20, 30, 45, 70)
SHARES = (1.0, 0.65, 0.50, 0.41, 0.32, 0.26, 0.21, 0.16, 0.14, 0.11, 0.10)


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
    share = float(np.interp(np.log1p(looks), np.log1p(LOOKS), SHARES))
    return 1 - share * (1 - confidence)
