"""Test whether runs scatter about two values rather than one, as a bulk solid with two states does.

The mean over seeds stays what is expected, and its standard error holds. But no single run looks
like it, which the user has to know.
"""

from __future__ import annotations

import numpy as np

from grainfit.arrays import Array

#: Probability that runs of normal scatter are found to have two states.
FALSE_ALARM = 0.005
#: Fewest runs for which the test holds.
_FEWEST_RUNS = 20


def has_two_states(residuals: Array) -> bool:
    """Whether residuals lie about two values rather than one: their kurtosis is far below normal.

    Parameters
    ----------
    residuals : ndarray, shape (n,)
        Standardised leave-one-out residuals.

    References
    ----------
    Anscombe & Glynn (1983), Biometrika 70, 227-234: test of the kurtosis.
    """
    if len(residuals) < _FEWEST_RUNS or np.ptp(residuals) == 0:
        return False
    # Loaded late, because it takes half a second.
    from scipy import stats

    return bool(stats.kurtosistest(residuals, alternative="less").pvalue < FALSE_ALARM)
