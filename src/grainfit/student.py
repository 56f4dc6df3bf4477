"""Intervals of means: the normal quantile, and Student's factor for few values."""

from __future__ import annotations

#: Probability of every interval that is shown.
LEVEL = 0.95
#: Half the width of a 95 % interval in standard deviations.
NORMAL_QUANTILE = 1.96


def student_factor(count: int) -> float:
    """Return Student's factor on the standard error of the mean of few values.

    `NORMAL_QUANTILE` times it is Student's quantile, so that both together give the 95 % interval.

    Parameters
    ----------
    count : int
        Number of values, at least 2.

    Examples
    --------
    >>> round(student_factor(3), 2)
    2.2
    """
    # Those who need the quantile alone do not wait for SciPy.
    from scipy.special import stdtrit

    return float(stdtrit(count - 1, (1 + LEVEL) / 2)) / NORMAL_QUANTILE
