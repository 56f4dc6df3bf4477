"""Find runs that do not belong to the scatter of the others: jams, avalanches, blow-ups.

Runs are left out one after the other, always the one that the metamodel of the others predicts
worst, and each is judged by that metamodel (generalised extreme studentised deviates). A
calibration looks after every run, so each run has its part of the error of the whole calibration.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from grainfit.arrays import Array
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.predictor import RUNS_PER_COEFFICIENT
from grainfit.metamodels.share_of_jams import ShareOfJams

#: Probability that runs of normal scatter are found to have an outlier, once in a calibration of
#: so many runs.
FALSE_ALARM = 0.01
_RUNS_OF_CALIBRATION = 60
#: Largest share of runs that can be outliers: beyond it, they are the rule.
_LARGEST_SHARE = 0.25
#: With a smaller largest residual, no run needs to be looked at.
_SUSPICIOUS = 2.0
#: Scatter over the spread of the values below which residuals are errors of interpolation: any jam
#: would be seen as a larger scatter.
_SMOOTH = 1e-3
#: With more runs, metamodels are fitted again only where the runs left out deviate by this share of
#: the limit of outliers.
_ALL_TRIED = 60
_WORTH_A_FIT = 0.8
#: Distance in the unit cube of equal parameters.
_SAME = 1e-9
#: Distance per root of the dimension within which runs tell about the same place.
_NEAR = 0.02
#: Chance below which outlying runs at one place are no coincidence.
_TOGETHER_BY_CHANCE = 0.01


@dataclass(frozen=True)
class Outliers:
    """Outlying runs of one response: where they are, and what they give.

    Parameters
    ----------
    indices : tuple of int
        Their places among the runs.
    residuals : tuple of float
        Their deviations from what the metamodel of the others expects.
    points : tuple of tuple of float
        Points of all runs in the unit cube.
    seeds : tuple of int
        Seeds of the outlying runs, by which a user finds them.
    """

    indices: tuple[int, ...]
    residuals: tuple[float, ...]
    points: tuple[tuple[float, ...], ...]
    seeds: tuple[int, ...] = ()

    @property
    def runs(self) -> int:
        """Number of all runs."""
        return len(self.points)

    @property
    def alone(self) -> NDArray[np.bool_]:
        """Whether no other run has the parameters of an outlying one, shape (outliers,)."""
        return np.asarray(self._same_place.sum(axis=1) == 1)

    @property
    def repeated(self) -> int:
        """Number of outlying runs whose parameters were run again with another seed."""
        return int((~self.alone).sum())

    @property
    def came_again(self) -> int:
        """Number of those that all came out like that again."""
        others = np.delete(self._same_place, self.indices, axis=1)
        return int((~self.alone & ~others.any(axis=1)).sum())

    @property
    def _same_place(self) -> NDArray[np.bool_]:
        """Which runs have the parameters of each outlying one, shape (outliers, n)."""
        points = np.array(self.points)
        return np.asarray(cdist(points[list(self.indices)], points) < _SAME)

    def shift_at(self, points: Array) -> tuple[Array, Array]:
        """Return the change of the expected response by such runs, and its variance, shape (m,).

        The mean over seeds has them, too: with the share that they have at a point, times what
        they give.
        """
        if not self.indices:
            return np.zeros(len(points)), np.zeros(len(points))
        share, variance, _ = self.share.at(points)
        residuals = np.array(self.residuals)
        effect = float(residuals.mean())
        squares = float(((residuals - effect) ** 2).sum()) + effect**2
        of_effect = squares / len(residuals) ** 2
        return share * effect, variance * (effect**2 + of_effect) + share**2 * of_effect

    @cached_property
    def share(self) -> ShareOfJams:
        """Share of such runs."""
        is_jam = np.zeros(self.runs, dtype=bool)
        is_jam[list(self.indices)] = True
        return ShareOfJams(np.array(self.points), is_jam)

    def shrinking_at(self, point: Array, more: Array) -> Array:
        """Return by what factors more runs at a point shrink the variance of the shift there."""
        if not self.indices:
            return np.ones(len(more))
        runs = float(self.share.at(np.atleast_2d(point))[2][0]) + 1
        return np.asarray(runs / (runs + more))


NO_OUTLIERS = Outliers((), (), ())


def fit_without_outliers(
    points: Array,
    values: Array,
    standard_errors: Array,
    known_scatter: float = 0.0,
    relative: Kriging | None = None,
) -> tuple[Kriging, Outliers]:
    """Fit a metamodel to the runs that belong together.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Points of the runs in the unit cube.
    values, standard_errors : ndarray, shape (n,)
        Their responses, and the stated standard errors of these.
    known_scatter, relative
        As of `Kriging.fit`.

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
    everything = _fit(points, values, standard_errors, known_scatter, relative)
    most = _most_outliers(*points.shape)
    is_smooth = everything.noise_standard_deviation < _SMOOTH * values.std()
    if most == 0 or is_smooth or _largest_residual(everything)[1] < _SUSPICIOUS:
        return everything, NO_OUTLIERS
    runs = np.arange(len(values))
    kept, model = runs, everything
    best, outlying = everything, runs[:0]
    for _ in range(most if len(runs) <= _ALL_TRIED else _suspicious(everything, most)):
        kept = np.delete(kept, _largest_residual(model)[0])
        left_out = np.setdiff1d(runs, kept)
        model = _fit(points[kept], values[kept], standard_errors[kept], known_scatter, relative)
        if _all_outlying(model, points[left_out], values[left_out], len(values)):
            best, outlying = model, left_out
    together = _together(points, outlying)
    if together.all():
        return everything, NO_OUTLIERS
    if together.any():
        outlying = outlying[~together]
        kept = np.setdiff1d(runs, outlying)
        best = _fit(points[kept], values[kept], standard_errors[kept], known_scatter, relative)
    residuals = values[outlying] - best.predict(points[outlying]).mean
    everywhere = tuple(map(tuple, points.tolist()))
    return best, Outliers(tuple(outlying.tolist()), tuple(residuals.tolist()), everywhere)


def _fit(
    points: Array,
    values: Array,
    standard_errors: Array,
    known_scatter: float,
    relative: Kriging | None,
) -> Kriging:
    """Fit a metamodel, with a scatter that changes over the cube where the runs show it."""
    return Kriging.fit(
        points,
        values,
        standard_errors=standard_errors,
        scatter_may_vary=True,
        known_scatter=known_scatter,
        relative=relative,
    )


def _error_of_a_run(runs: int) -> float:
    return FALSE_ALARM / max(runs, _RUNS_OF_CALIBRATION)


def _most_outliers(runs: int, dimension: int) -> int:
    spare = runs - RUNS_PER_COEFFICIENT * (dimension + 1) - 1
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
    limit = _WORTH_A_FIT * model.quantile(_error_of_a_run(model.n))
    others, found = model.leaving_out(), 0
    for number in range(1, most + 1):
        others.leave_out_worst()
        if others.deviations_of_left_out().min() > limit:
            found = number
    return found


def _together(points: Array, left_out: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Which of these runs lie together at one place more often than chance explains.

    What comes again there is the response of that place, and belongs to the metamodel.
    """
    distances = cdist(points[left_out], points)
    is_out = np.isin(np.arange(len(points)), left_out)
    reaches = _SAME, _NEAR * np.sqrt(points.shape[1])
    return np.array(
        [any(_gather(row <= reach, is_out) for reach in reaches) for row in distances], dtype=bool
    )


def _gather(near: NDArray[np.bool_], is_out: NDArray[np.bool_]) -> bool:
    """Whether more of the runs near a place are outlying than chance explains."""
    # Loaded late, because it takes half a second.
    from scipy.stats import binom

    together, elsewhere = int((near & is_out).sum()), int((~near & is_out).sum())
    share = (elsewhere + 1) / ((~near).sum() + 2)
    by_chance = binom.sf(together - 1, near.sum(), share)
    return bool(together > 1 and by_chance < _TOGETHER_BY_CHANCE)


def _all_outlying(model: Kriging, points: Array, values: Array, runs: int) -> bool:
    found = model.predict(points)
    away = np.abs(values - found.mean) / np.sqrt(found.variance_of_new_run)
    return bool(away.min() > model.quantile(_error_of_a_run(runs)))
