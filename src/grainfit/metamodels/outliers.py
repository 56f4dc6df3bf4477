"""Find runs that do not belong to the scatter of the others: jams, avalanches, blow-ups.

Runs are left out one after the other, always the one that the metamodel of the others predicts
worst, and each is judged by that metamodel (generalised extreme studentised deviates). Normal
scatter raises a false alarm in `FALSE_ALARM` of all responses that are checked once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.special import stdtrit

from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.prediction import NORMAL_QUANTILE
from grainfit.metamodels.predictor import FloatArray

#: Probability that runs of normal scatter are found to have an outlier.
FALSE_ALARM = 0.005
#: Largest share of runs that can be outliers: beyond it, they are the rule.
_LARGEST_SHARE = 0.25
#: With a smaller largest residual, no run needs to be looked at.
_SUSPICIOUS = 2.0
#: With more runs, metamodels are fitted again only where the runs left out deviate by this share of
#: the limit of outliers.
_ALL_TRIED = 60
_WORTH_A_FIT = 0.8
#: Fewest runs per coefficient of a linear trend with which a run can be told from the others.
_RUNS_PER_COEFFICIENT = 2
#: Distance per root of the dimension within which runs tell about the same place.
_NEAR = 0.02
#: Chance below which outlying runs at one place are no coincidence.
_TOGETHER_BY_CHANCE = 0.01


@dataclass(frozen=True)
class Outliers:
    """Outlying runs of one response.

    Parameters
    ----------
    indices : tuple of int
        Their places among the runs.
    residuals : ndarray
        Their deviations from what the metamodel of the others expects.
    runs : int
        Number of all runs.
    seeds : tuple of int
        Seeds of the outlying runs, by which a user finds them.
    """

    indices: tuple[int, ...]
    residuals: FloatArray
    runs: int
    seeds: tuple[int, ...] = ()

    @property
    def shift(self) -> float:
        """Change of the expected response by such runs: the mean over seeds has them, too."""
        return float(self.residuals.sum()) / self.runs

    @property
    def variance_of_shift(self) -> float:
        """Squared standard error of the shift, widened for the few runs that it rests on."""
        if not self.indices:
            return 0.0
        squares = float((self.residuals**2).sum()) - self.runs * self.shift**2
        widened = float(stdtrit(self.runs - 1, 0.975)) / NORMAL_QUANTILE
        return widened**2 * squares / (self.runs * (self.runs - 1))


NO_OUTLIERS = Outliers((), np.empty(0), 1)


def fit_without_outliers(
    points: FloatArray, values: FloatArray, standard_errors: FloatArray
) -> tuple[Kriging, Outliers]:
    """Fit a metamodel to the runs that belong together.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Points of the runs in the unit cube.
    values, standard_errors : ndarray, shape (n,)
        Their responses, and the stated standard errors of these.

    Returns
    -------
    Kriging
        Of the runs without outliers.
    Outliers
        The others.

    References
    ----------
    Rosner (1983), Technometrics 25, 165-172: generalised extreme studentised deviates.
    """
    everything = _fit(points, values, standard_errors)
    most = _most_outliers(*points.shape)
    if most == 0 or _largest_residual(everything)[1] < _SUSPICIOUS:
        return everything, NO_OUTLIERS
    runs = np.arange(len(values))
    kept, model = runs, everything
    best, outlying = everything, runs[:0]
    for _ in range(most if len(runs) <= _ALL_TRIED else _suspicious(everything, most)):
        kept = np.delete(kept, _largest_residual(model)[0])
        left_out = np.setdiff1d(runs, kept)
        model = _fit(points[kept], values[kept], standard_errors[kept])
        if _all_outlying(model, points[left_out], values[left_out], len(values)):
            best, outlying = model, left_out
    if not len(outlying) or not _are_alone(points, outlying):
        return everything, NO_OUTLIERS
    residuals = values[outlying] - best.predict(points[outlying]).mean
    return best, Outliers(tuple(outlying.tolist()), residuals, len(values))


def _fit(points: FloatArray, values: FloatArray, standard_errors: FloatArray) -> Kriging:
    """Fit a metamodel, with a scatter that changes over the cube where the runs show it."""
    return Kriging.fit(points, values, standard_errors=standard_errors, scatter_may_vary=True)


def _most_outliers(runs: int, dimension: int) -> int:
    spare = runs - _RUNS_PER_COEFFICIENT * (dimension + 1) - 1
    return max(0, min(int(_LARGEST_SHARE * runs), spare))


def _largest_residual(model: Kriging) -> tuple[int, float]:
    """Return the run that the others predict worst, and by how many standard deviations."""
    residuals = np.abs(model.standardised_residuals())
    worst = int(np.argmax(residuals))
    return worst, float(residuals[worst])


def _suspicious(model: Kriging, most: int) -> int:
    """Return the largest number of runs left out that may all be outliers.

    At the hyperparameters of all runs a run is left out by few operations, so that metamodels are
    fitted again only where something is suspicious.
    """
    limit = _WORTH_A_FIT * model.quantile(FALSE_ALARM / model.n)
    others, found = model.leaving_out(), 0
    for number in range(1, most + 1):
        others.leave_out_worst()
        if others.deviations_of_left_out().min() > limit:
            found = number
    return found


def _are_alone(points: FloatArray, left_out: NDArray[np.intp]) -> bool:
    """Whether these runs do not lie together at one place more often than chance explains.

    There they would show a response that the metamodel misses, and no outliers.
    """
    # Loaded late, because it takes half a second.
    from scipy.stats import binom

    distances = cdist(points[left_out], points)
    is_out = np.isin(np.arange(len(points)), left_out)
    for row in distances:
        near = row <= _NEAR * np.sqrt(points.shape[1])
        together, elsewhere = int((near & is_out).sum()), int((~near & is_out).sum())
        share = (elsewhere + 1) / ((~near).sum() + 2)
        by_chance = binom.sf(together - 1, near.sum(), share)
        if together > 1 and by_chance < _TOGETHER_BY_CHANCE:
            return False
    return True


def _all_outlying(model: Kriging, points: FloatArray, values: FloatArray, runs: int) -> bool:
    found = model.predict(points)
    away = np.abs(values - found.mean) / np.sqrt(found.variance_of_new_run)
    return bool(away.min() > model.quantile(FALSE_ALARM / runs))
