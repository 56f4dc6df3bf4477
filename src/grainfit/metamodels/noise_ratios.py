"""Ratios of the runs' noise variances, from their stated standard errors.

A stated standard error is a claim. It may be several times too large or too small, it may leave out
the scatter from seed to seed, and one that is itself estimated from few values says little about
which run is the better measured one. So the size of the noise is always estimated from the runs;
the stated errors may only say how it differs between them, mixed with a share that is common to
all, and they are followed only as far as the runs bear them out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grainfit.metamodels.predictor import FloatArray

#: Shares of the noise that may follow the stated errors. Never all of it: a run is not free of
#: scatter because it states no error.
_SHARES = (0.5, 0.95)
#: How much more probable the runs must be, logarithm, for stated errors to be followed.
_EVIDENCE = 1.0
#: Errors that differ by less are equal.
_SMALLEST_DIFFERENCE = 0.01


def noise_ratios(standard_errors: FloatArray) -> list[FloatArray | None]:
    """Return the ratios of noise variances that are possible, of mean 1; first None: all equal.

    Parameters
    ----------
    standard_errors : ndarray, shape (n,)
        As stated with the runs. A run that states none, 0, counts as one of average error.
    """
    stated = standard_errors > 0
    if not stated.any():
        return [None]
    variances = (standard_errors / standard_errors.max()) ** 2
    variances[~stated] = variances[stated].mean()
    ratios = variances / variances.mean()
    if np.ptp(ratios) < _SMALLEST_DIFFERENCE:
        return [None]
    return [None, *(1.0 + share * (ratios - 1.0) for share in _SHARES)]


def most_probable(log_densities: Sequence[float]) -> int:
    """Return which of the candidates to take: the first, unless another is clearly better."""
    handicap = np.array([0.0, *[_EVIDENCE] * (len(log_densities) - 1)])
    return int(np.argmax(np.array(log_densities) - handicap))
