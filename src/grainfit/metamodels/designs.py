"""Designs of computer experiments: the maximin Latin hypercube."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.errors import InputError
from grainfit.metamodels import messages

#: Exponent of the phi_p criterion as a power of two: repeated squaring is far cheaper than `**`.
_SQUARINGS = 4
_P = 2 * 2**_SQUARINGS
#: First temperature, times n d: a relative change of the criterion. The more elements there are,
#: the less a single swap changes. Found by trial, as was the ratio of first to last temperature.
_HOTTEST = 3.0
_COOLING = 400.0
_CANDIDATES = 64
_MOST_STEPS = 6_000
_MOST_WORK = 5e8
_MOST_POINTS = 3_000


def maximin_latin_hypercube(n: int, d: int, seed: int) -> Array:
    """Spread points evenly over the unit cube: a Latin hypercube with a large smallest distance.

    Every column cut into `n` strata holds one point in the middle of each (a *centred* Latin
    hypercube, as usual for deterministic coverage); the strata are paired so that the smallest
    Euclidean distance between any two points becomes as large as the search can make it. The
    search is simulated annealing on the phi_p criterion [1]_ over swaps of two elements of one
    column [2]_: at each step, one point, preferably of a close pair, is offered many swaps at
    once and takes one with its heat-bath probability.

    Parameters
    ----------
    n : int
        Number of points, at least 1. The search stores all pairs: beyond 3,000 points the Latin
        hypercube is left as it was drawn.
    d : int
        Dimension, at least 1.
    seed : int
        The same seed gives the same points; not negative.

    Returns
    -------
    ndarray, shape (n, d)
        Points in the open unit cube.

    Raises
    ------
    InputError
        An argument is not a whole number or is too small.

    References
    ----------
    .. [1] M. D. Morris, T. J. Mitchell: Exploratory designs for computational experiments.
       J. Statistical Planning and Inference 43 (1995) 381-402.
    .. [2] R. Jin, W. Chen, A. Sudjianto: An efficient algorithm for constructing optimal design
       of computer experiments. J. Statistical Planning and Inference 134 (2005) 268-287.

    Examples
    --------
    >>> points = maximin_latin_hypercube(26, 2, seed=1)
    >>> points.shape
    (26, 2)
    """
    _require_whole_numbers({"n": (n, 1), "d": (d, 1), "seed": (seed, 0)})
    random = np.random.default_rng(seed)
    levels = random.permuted(np.tile(np.arange(n, dtype=float), (d, 1)), axis=1)
    # In one dimension, or with two points, all Latin hypercubes are equally good.
    if 2 < n <= _MOST_POINTS and d > 1:
        levels = _anneal(levels, random)
    return np.ascontiguousarray((levels.T + 0.5) / n)


def _require_whole_numbers(arguments: dict[str, tuple[Any, int]]) -> None:
    InputError.raise_for(
        messages.NO_WHOLE_NUMBER.fault(name, given=value, least=lowest)
        for name, (value, lowest) in arguments.items()
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < lowest
    )


def _squared_distances(columns: Array) -> Array:
    squared = np.zeros((columns.shape[1], columns.shape[1]))
    for column in columns:
        squared += np.subtract.outer(column, column) ** 2
    np.fill_diagonal(squared, np.inf)
    return squared


def _weights(squared: Array) -> Array:
    """Terms of the phi_p criterion, distance**-p, from squared distances."""
    weights = np.reciprocal(squared)
    for _ in range(_SQUARINGS):
        np.multiply(weights, weights, out=weights)
    return weights


def _anneal(levels: Array, random: np.random.Generator) -> Array:
    """Best Latin hypercube met while annealing; `levels` are whole numbers, shape (d, n).

    Squared distances of whole numbers are whole numbers, so updates cause no rounding errors.
    """
    d, n = levels.shape
    squared = _squared_distances(levels)
    weights = _weights(squared)
    steps = int(min(max(200, 7 * n * d), _MOST_STEPS, _MOST_WORK / n**2))
    best, best_key = levels.copy(), (squared.min(), -weights.sum())
    hottest = _HOTTEST / (n * d)
    for temperature in np.geomspace(hottest, hottest / _COOLING, steps):
        if _swap(levels, squared, weights, temperature, random):
            closest = squared.min()
            if closest >= best_key[0]:
                key = (closest, -weights.sum())
                if key > best_key:
                    best, best_key = levels.copy(), key
    return best


def _swap(
    levels: Array,
    squared: Array,
    weights: Array,
    temperature: float,
    random: np.random.Generator,
) -> bool:
    """Make one heat-bath step in place; return True if anything changed."""
    d, n = levels.shape
    row_sums = weights.sum(axis=1)
    cumulated = row_sums.cumsum()
    point = min(int(cumulated.searchsorted(random.random() * cumulated[-1])), n - 1)
    columns, partners = _candidates(n, d, random)
    of_point, of_partner = _squared_distances_after(levels, squared, point, columns, partners)
    weights_of_point, weights_of_partner = _weights(of_point), _weights(of_partner)

    change = weights_of_point.sum(axis=1) + weights_of_partner.sum(axis=1)
    change -= row_sums[point] + row_sums[partners]
    change[partners == point] = 0.0
    # Every pair counts twice in the row sums, hence the factor; phi_p is the p-th root.
    logarithm = np.log(np.maximum(1.0 + 2.0 * change / cumulated[-1], 1e-12)) / _P
    # The smallest of exponential variates divided by probabilities is a draw from them.
    draw = logarithm / temperature + np.log(random.standard_exponential(len(partners)))
    chosen = int(draw.argmin())
    partner = int(partners[chosen])
    if partner == point:
        return False

    column = levels[columns[chosen]]
    column[point], column[partner] = column[partner], column[point]
    for row, new, new_weights in (
        (point, of_point[chosen], weights_of_point[chosen]),
        (partner, of_partner[chosen], weights_of_partner[chosen]),
    ):
        squared[row] = squared[:, row] = new
        weights[row] = weights[:, row] = new_weights
    return True


def _candidates(
    n: int, d: int, random: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns and partners of the candidate swaps: all of them when they are few."""
    few = n * d <= _CANDIDATES
    numbers = np.arange(n * d) if few else random.integers(n * d, size=_CANDIDATES)
    return np.divmod(numbers, n)


def _squared_distances_after(
    levels: Array,
    squared: Array,
    point: int,
    columns: NDArray[np.intp],
    partners: NDArray[np.intp],
) -> tuple[Array, Array]:
    """Squared distances of the point, and of each partner, to all points after each swap."""
    old, new = levels[columns, point], levels[columns, partners]
    change = (new + old)[:, None] - 2 * levels[columns]
    change *= (new - old)[:, None]
    # The two points that swap keep their distance.
    change[:, point] = 0.0
    change[np.arange(len(partners)), partners] = 0.0
    return squared[point] + change, squared[partners] - change
