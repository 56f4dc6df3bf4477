"""Predictions of a metamodel: plain data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from grainfit.arrays import Array

#: Half the width of a 95 % interval in standard deviations.
NORMAL_QUANTILE = float(ndtri(0.975))


@dataclass(frozen=True)
class Prediction:
    """Prediction of a metamodel at some points.

    ``mean`` plus or minus 1.96 times a standard deviation is a 95 % interval: the variances
    account for the uncertainty of the metamodel's own variance, ranges and noise.

    Attributes
    ----------
    mean : ndarray, shape (m,)
        Expected response.
    variance_of_mean : ndarray, shape (m,)
        Uncertainty of the expected response.
    variance_of_new_run : ndarray, shape (m,)
        Uncertainty of the response of one more run: the same plus the scatter of runs.
    """

    mean: Array
    variance_of_mean: Array
    variance_of_new_run: Array

    @property
    def standard_error(self) -> Array:
        """Square root of the variance of the mean, shape (m,)."""
        return np.asarray(np.sqrt(self.variance_of_mean))


@dataclass(frozen=True)
class LeaveOneOut:
    """Prediction of each run from the others, at the same hyperparameters.

    Attributes
    ----------
    predicted : ndarray, shape (n,)
        Response predicted from the other runs.
    standard_deviation : ndarray, shape (n,)
        Standard deviation of a run about that prediction.
    q2 : float
        Share of the variance of the runs that is predicted; NaN if the runs are all equal.
    coverage : float
        Share of the runs inside their 95 % interval.
    """

    predicted: Array
    standard_deviation: Array
    q2: float
    coverage: float
