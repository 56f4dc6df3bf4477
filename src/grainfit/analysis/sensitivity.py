"""Sensitivity: share of a response's variation over the intervals that each parameter explains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from threadpoolctl import threadpool_limits

from grainfit.errors import Fault, InputError
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import spread_points

Array = NDArray[np.float64]

_RESAMPLES = 300
#: A response that varies by less than this share of itself is constant except for rounding.
_CONSTANT = 1e-9
_PROBED = 256
#: Shares of the variance: the smallest that is named, and the smallest due to interactions.
_NAMED = 0.05
_INTERACTION = 0.1


@dataclass(frozen=True)
class Sensitivity:
    """Sobol' indices of all responses, with 95 % bootstrap intervals.

    All arrays have the shape (number of targets, d); all numbers are shares of the variance of
    the expected response over the intervals of the parameters, from 0 to 1, and 0 for a response
    that is constant.

    Attributes
    ----------
    names : tuple of str
        Free parameters.
    responses : tuple of str
        Names of the targets.
    first, first_low, first_high : ndarray
        First-order indices: effect of a parameter by itself.
    total, total_low, total_high : ndarray
        Total indices: its effect by itself and together with others.
    """

    names: tuple[str, ...]
    responses: tuple[str, ...]
    first: Array
    first_low: Array
    first_high: Array
    total: Array
    total_low: Array
    total_high: Array

    def in_words(self) -> tuple[str, ...]:
        """Return one sentence per response that names the parameters on which it depends."""
        return tuple(self._sentence(row, name) for row, name in enumerate(self.responses))

    def _sentence(self, row: int, response: str) -> str:
        total = self.total[row]
        if not total.any():
            return f"{response} depends on none of the free parameters within their intervals."
        order = np.argsort(-total, kind="stable")
        named = [
            f"{self.names[i]} ({100 * total[i]:.0f} % of its variance"
            + (", partly together with others)" if self._interacts(row, i) else ")")
            for i in order
            if total[i] >= _NAMED or i == order[0]
        ]
        hardly = [self.names[i] for i in order[1:] if total[i] < _NAMED]
        rest = f", hardly on {_listed(hardly)}" if hardly else ""
        return f"{response} depends on {_listed(named)}{rest}."

    def _interacts(self, row: int, column: int) -> bool:
        return bool(self.total[row, column] - self.first[row, column] >= _INTERACTION)


def estimate_sensitivity(
    metamodels: Metamodels, *, seed: int = 1, points: int = 1024
) -> Sensitivity:
    """Estimate Sobol' indices of the expected responses over the intervals of the parameters.

    Parameters
    ----------
    metamodels : Metamodels
        Of all responses.
    seed : int
        The same seed gives the same indices.
    points : int
        Power of two; each metamodel predicts (d + 2) times as many points.

    Returns
    -------
    Sensitivity

    Raises
    ------
    InputError
        The number of points is no power of two.

    References
    ----------
    Saltelli, Annoni, Azzini, Campolongo, Ratto & Tarantola (2010), Comput. Phys. Commun. 181,
    259-270.
    """
    if points < 2 or points & (points - 1):
        raise InputError(Fault("points", f"is {points}.", "Give a power of two, such as 1024."))
    problem = metamodels.problem
    with threadpool_limits(limits=1, user_api="blas"):
        varied = _varied(metamodels, np.random.default_rng(seed))
        found = np.zeros((6, len(problem.targets), problem.dimension))
        if varied.any():
            found[:, varied] = _indices(metamodels, varied, seed, points)
    return Sensitivity(
        tuple(parameter.name for parameter in problem.parameters),
        tuple(target.name for target in problem.targets),
        *found,
    )


def _varied(metamodels: Metamodels, random: np.random.Generator) -> NDArray[np.bool_]:
    """Return for each response True if it varies over the cube."""
    means, _ = metamodels.predict(spread_points(_PROBED, metamodels.problem.dimension, random))
    return np.asarray(np.ptp(means, axis=0) > _CONSTANT * np.abs(means).max(axis=0))


def _indices(metamodels: Metamodels, varied: NDArray[np.bool_], seed: int, points: int) -> Array:
    """First and total indices, each with the ends of its interval, of the responses that vary."""
    dimension = metamodels.problem.dimension
    shape = (int(varied.sum()), dimension)
    if dimension == 1:
        # By definition; an estimate from a sample could differ.
        return np.ones((6, *shape))
    random = np.random.default_rng(seed)
    base = spread_points(points, 2 * dimension, random)
    first, second = base[:, :dimension], base[:, dimension:]
    exchanged = np.tile(first, (dimension, 1, 1))
    for axis in range(dimension):
        exchanged[axis, :, axis] = second[:, axis]
    asked = np.vstack([first, second, exchanged.reshape(-1, dimension)])
    answers = metamodels.predict(asked)[0][:, varied].T.reshape(shape[0], dimension + 2, points)

    def estimates(chosen: NDArray[np.intp]) -> Array:
        drawn = answers[..., chosen]
        values = {
            "f_A": drawn[:, 0],
            "f_B": drawn[:, 1],
            "f_AB": np.moveaxis(drawn[:, 2:], 1, 0),
        }
        found = stats.sobol_indices(func=values, n=points)
        return np.array([found.first_order, found.total_order]).reshape(2, *shape)

    # SciPy's own bootstrap cannot be seeded.
    resampled = [estimates(random.integers(points, size=points)) for _ in range(_RESAMPLES)]
    low, high = np.quantile(resampled, [0.025, 0.975], axis=0)
    best = estimates(np.arange(points))
    # Estimates of shares near 0 or 1 can lie outside that range.
    found = np.stack([best, low, high], axis=1).reshape(6, *shape)
    return np.asarray(np.clip(found, 0.0, 1.0))


def _listed(words: list[str]) -> str:
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))
