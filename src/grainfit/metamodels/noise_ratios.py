"""Ratios of the runs' noise variances, from their stated standard errors.

A stated standard error is a claim. It may be several times too large or too small, it may leave out
the scatter from seed to seed, and if it is estimated from few values, it hardly shows which run is
measured better. So the size of the noise is always estimated from the runs. The stated errors only
determine its ratios between runs, mixed with a share that is common to all, and only as far as the
runs support them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtri

from grainfit.arrays import Array

#: Shares of the noise that may follow the stated errors. Never all of it: a run with a small stated
#: error is not free of scatter.
_SHARES = (0.5, 0.95)
#: Smallest gain of the log density of the runs at which stated errors are used.
_EVIDENCE = 1.0
#: Chance that slopes fitted to the runs themselves gain more where there are none. A few percent of
#: the trials with scatter that is the same everywhere are tested and then found to change.
_GAIN_BY_CHANCE = 0.05
#: Errors that differ by less are equal.
_SMALLEST_DIFFERENCE = 0.01


def noise_ratios(standard_errors: Array) -> list[Array | None]:
    """Return the candidate ratios of noise variances, of mean 1; None, for equal ones, is first.

    Parameters
    ----------
    standard_errors : ndarray, shape (n,)
        As stated with the runs. A run without one (0) counts as one with an average error.
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


def most_probable(log_densities: Sequence[float], fitted_slopes: int = 0) -> int:
    """Return the index of the best candidate: the first, unless another is clearly better.

    Parameters
    ----------
    log_densities : sequence of float
        Of the runs, with each candidate.
    fitted_slopes : int
        Number of slopes of the last candidate that were fitted to the same runs, so that it has to
        be better by more.

    References
    ----------
    Wilks (1938), Ann. Math. Stat. 9, 60-62: twice the gain by fitted slopes is chi-squared.
    """
    handicap = np.array([0.0, *[_EVIDENCE] * (len(log_densities) - 1)])
    if fitted_slopes:
        handicap[-1] = float(chdtri(fitted_slopes, _GAIN_BY_CHANCE)) / 2.0
    return int(np.argmax(np.array(log_densities) - handicap))
