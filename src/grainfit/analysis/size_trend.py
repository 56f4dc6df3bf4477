"""The trend of a response with the size of an apparatus, and what it predicts for another one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.student import NORMAL_QUANTILE

#: Fewest sizes that have a trend.
FEWEST_SIZES = 2


@dataclass(frozen=True)
class Prediction:
    """A response at a size that was not simulated.

    Parameters
    ----------
    value : float
        Of the trend.
    error : float
        Its standard error by the scatter of the runs.
    form : float
        What another form of the trend would change.
    """

    value: float
    error: float
    form: float

    @property
    def half_width(self) -> float:
        """Half of the 95 % interval: scatter, and the form of the trend."""
        return math.hypot(NORMAL_QUANTILE * self.error, self.form)

    def times(self, factor: float) -> Prediction:
        """Return the prediction of so many times the response."""
        return Prediction(self.value * factor, self.error * abs(factor), self.form * factor)


def predict(
    scales: Sequence[float], means: Sequence[float], errors: Sequence[float], scale: float
) -> Prediction:
    """Predict a response in an apparatus of another size.

    Layers of particles along walls take a share of the vessel that falls with 1 / scale: that is
    the trend. How a bed packs under its own depth does not; the difference from a trend in
    ln(scale) is counted as an error of the form.

    Parameters
    ----------
    scales, means, errors : sequence of float
        Sizes, and mean and standard error of the response at each.
    scale : float
        Size to predict.

    Examples
    --------
    >>> found = predict([1, 2, 4], [10.0, 11.0, 11.5], [0.1, 0.1, 0.1], 8.0)
    >>> round(found.value, 3)
    11.75
    """
    sizes = np.asarray(scales, dtype=float)
    value, error = _line(1 / sizes, means, errors, 1 / scale)
    other, _ = _line(np.log(sizes), means, errors, math.log(scale))
    return Prediction(value, error, other - value)


def together(found: Sequence[Prediction]) -> Prediction:
    """Return what predictions at several parameter sets tell of another one.

    They scatter by the errors of each, and by what the parameter sets change: a mean of random
    effects (DerSimonian & Laird, Control. Clin. Trials 7, 177, 1986). The form of the trend is
    the same error in each, and stays.

    Parameters
    ----------
    found : sequence of Prediction
        Ratios of a response at one size to that at another.

    Examples
    --------
    >>> one = Prediction(0.90, 0.04, 0.02)
    >>> found = together([one, Prediction(0.94, 0.04, 0.02)])
    >>> round(found.value, 3), round(found.error, 3), found.form
    (0.92, 0.028, 0.02)
    """
    values, errors, forms = np.array([(p.value, p.error, p.form) for p in found]).T
    weights = 1 / errors**2
    mean = np.average(values, weights=weights)
    excess = float(weights @ (values - mean) ** 2) - (len(found) - 1)
    room = float(weights.sum() - (weights @ weights) / weights.sum())
    between = max(0.0, excess / room) if len(found) > 1 else 0.0
    weights = 1 / (errors**2 + between)
    mean, form = (float(np.average(one, weights=weights)) for one in (values, forms))
    return Prediction(mean, math.sqrt(1 / float(weights.sum()) + between), form)


def _line(
    x: np.ndarray, means: Sequence[float], errors: Sequence[float], at: float
) -> tuple[float, float]:
    """Value and standard error of a straight line at a place, fitted with weights."""
    weights = 1 / np.asarray(errors, dtype=float)
    matrix = np.column_stack((np.ones(len(x)), x)) * weights[:, None]
    covariance = np.linalg.inv(matrix.T @ matrix)
    found = covariance @ matrix.T @ (np.asarray(means) * weights)
    freedom = len(x) - 2
    misfit = float(((matrix @ found - np.asarray(means) * weights) ** 2).sum())
    # Sizes that do not lie on the line make it less sure than scatter alone.
    inflation = max(1.0, misfit / freedom) if freedom else 1.0
    place = np.array([1.0, at])
    return float(place @ found), math.sqrt(float(place @ covariance @ place) * inflation)
