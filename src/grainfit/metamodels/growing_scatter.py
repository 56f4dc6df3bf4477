"""Scatter that changes over the intervals: its test, and a model of it.

The logarithm of the variance is linear in the parameters. It is fitted to the squared leave-one-out
residuals, and only where their ranks show that it is needed: outliers do not move ranks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.arrays import Array
from grainfit.metamodels.predictor import RUNS_PER_COEFFICIENT

#: With a larger p value of the rank correlations, times their number, the scatter is taken as the
#: same everywhere.
_SUSPICIOUS = 0.2
#: Fewest runs that show a change.
_FEWEST_RUNS = 10
#: Prior standard deviation of the change of the log variance over an interval.
_PRIOR_SLOPE = 3.0
_LARGEST_RATIO = 100.0


@dataclass(frozen=True)
class GrowingScatter:
    """Variance of the scatter over the unit cube, relative to its mean over the runs.

    Parameters
    ----------
    slopes : ndarray, shape (d,)
        Slopes of the logarithm of the variance.
    level : float
        Logarithm of the ratio at the centre of the cube.
    """

    slopes: Array
    level: float

    def ratios(self, points: Array) -> Array:
        """Variances at points over their mean at the runs, shape (m,)."""
        logarithm = self.level + (points - 0.5) @ self.slopes
        limit = np.log(_LARGEST_RATIO)
        return np.asarray(np.exp(np.clip(logarithm, -limit, limit)))

    def embedded(self, axes: Sequence[int], dimension: int) -> GrowingScatter:
        """Return the same over a larger unit cube, see `Kriging.embedded`."""
        slopes = np.zeros(dimension)
        slopes[list(axes)] = self.slopes
        return GrowingScatter(slopes, self.level)


def find_growing_scatter(points: Array, residuals: Array) -> GrowingScatter | None:
    """Return the change of the scatter over the unit cube, or None when there is no sign of one.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Points of the runs.
    residuals : ndarray, shape (n,)
        Their leave-one-out residuals over their standard deviations.

    References
    ----------
    Spearman's rank correlation of the absolute residuals with each parameter, after Park (1966),
    Econometrica 34, 888; Harvey (1976), Econometrica 44, 461-465: multiplicative
    heteroscedasticity.
    """
    n, d = points.shape
    if n < max(_FEWEST_RUNS, RUNS_PER_COEFFICIENT * (d + 1)) or not _changes(points, residuals):
        return None
    # Loaded late: most scatters do not change.
    from scipy.optimize import minimize

    squares = np.maximum(residuals**2, 1e-4)

    def misfit(theta: Array) -> tuple[float, Array]:
        logarithm = np.clip(theta[0] + (points - 0.5) @ theta[1:], -20.0, 20.0)
        weighted = squares * np.exp(-logarithm)
        value = 0.5 * float((logarithm + weighted).sum())
        value += 0.5 * float((theta[1:] ** 2).sum()) / _PRIOR_SLOPE**2
        pull = 0.5 * (1.0 - weighted)
        slope = np.append(pull.sum(), (points - 0.5).T @ pull + theta[1:] / _PRIOR_SLOPE**2)
        return value, slope

    found = minimize(misfit, np.zeros(d + 1), jac=True, method="L-BFGS-B")
    unscaled = GrowingScatter(np.asarray(found.x[1:]), 0.0)
    return GrowingScatter(unscaled.slopes, -float(np.log(unscaled.ratios(points).mean())))


def _changes(points: Array, residuals: Array) -> bool:
    if np.ptp(np.abs(residuals)) == 0:
        return False
    # Loaded late, because it takes half a second.
    from scipy import stats

    axes = [axis for axis in points.T if np.ptp(axis) > 0]
    chances = [stats.spearmanr(np.abs(residuals), axis).pvalue for axis in axes]
    return bool(chances) and min(chances) < _SUSPICIOUS / len(chances)
