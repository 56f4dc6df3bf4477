"""Minimise functions over the unit cube that evaluate many points at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grainfit.arrays import Array
from grainfit.metamodels.metamodels import Metamodels

#: Values at points, shape (m, d) to (m,).
Objective = Callable[[Array], Array]

_GAUSS_NEWTON_STEPS = 8
_SHRINKAGE = 0.4
#: In many dimensions, moves along a few axes at a time find more than moves along all axes.
_MOVED_AXES = 3.0


def spread_points(count: int, dimension: int, random: np.random.Generator) -> Array:
    """Points spread evenly over the unit cube (scrambled Sobol sequence), shape (count, d)."""
    power = int(np.ceil(np.log2(count)))
    # Loaded late, because it takes half a second.
    from scipy.stats import qmc

    sequence = qmc.Sobol(dimension, rng=random)
    return np.asarray(sequence.random_base2(power)[:count], dtype=float)


def spread_subset(points: Array, count: int) -> set[int]:
    """Choose points far from each other, the first one nearest to their mean; return their places.

    Farthest-first traversal (Gonzalez 1985).
    """
    chosen: list[int] = []
    distances = -((points - points.mean(axis=0)) ** 2).sum(axis=1)
    for _ in range(min(count, len(points))):
        chosen.append(int(np.argmax(distances)))
        from_new = ((points - points[chosen[-1]]) ** 2).sum(axis=1)
        distances = from_new if len(chosen) == 1 else np.minimum(distances, from_new)
    return set(chosen)


def points_about(centres: Array, count: int, width: float, random: np.random.Generator) -> Array:
    """Normal moves of some coordinates of every centre, within the cube, shape (m * count, d)."""
    dimension = centres.shape[1]
    shape = (len(centres), count, dimension)
    moved = random.random(shape) < max(0.5, _MOVED_AXES / dimension)
    moves = width * random.standard_normal(shape) * moved
    return np.asarray(np.clip(centres[:, None] + moves, 0.0, 1.0).reshape(-1, dimension))


def smallest(objective: Objective, points: Array, count: int) -> tuple[Array, Array]:
    """Return the points with the smallest values, best first, and these values."""
    values = objective(points)
    order = np.argsort(values, kind="stable")[:count]
    return points[order], values[order]


def shrinking_search(
    objective: Objective,
    starts: Array,
    random: np.random.Generator,
    *,
    rounds: int = 4,
    kept: int = 4,
    tries: int = 16,
    width: float = 0.1,
) -> tuple[Array, Array]:
    """Minimise from several starts by random moves that become shorter.

    Needs no derivatives, and works with kinks and bounds.

    Parameters
    ----------
    objective : callable
        Values at points, shape (m, d) to (m,).
    starts : ndarray, shape (m, d)
        Possible starts; the best of them are used.
    random : numpy.random.Generator
        Decides the moves.
    rounds, kept, tries : int
        Number of rounds, of points kept after each, and of moves of each of them.
    width : float
        Standard deviation of the first moves.

    Returns
    -------
    points, values : ndarray, shape (kept, d) and (kept,)
        Best first.
    """
    points, values = smallest(objective, starts, kept)
    for _ in range(rounds):
        moved = points_about(points, tries, width, random)
        candidates = np.vstack([points, moved])
        found = np.concatenate([values, objective(moved)])
        order = np.argsort(found, kind="stable")[:kept]
        points, values = candidates[order], found[order]
        width *= _SHRINKAGE
    return points, values


def gauss_newton(metamodels: Metamodels, starts: Array) -> Array:
    """Minimise the sum of squared expected residuals from all starts at once, shape (m, d).

    Levenberg-Marquardt steps, each cut at the bounds of the cube; a start that finds no better
    point stays in place.
    """
    points = starts.copy()
    deviations = metamodels.residuals(points)
    squares = (deviations**2).sum(axis=1)
    damping = np.full(len(points), 1e-3)
    identity = np.eye(points.shape[1])
    for _ in range(_GAUSS_NEWTON_STEPS):
        slopes = metamodels.residual_slopes(points)
        normal = np.einsum("mki,mkj->mij", slopes, slopes)
        scale = 1e-12 + np.trace(normal, axis1=1, axis2=2)
        normal += (damping * scale)[:, None, None] * identity
        pull = np.einsum("mki,mk->mi", slopes, deviations)
        trials = np.clip(points - np.linalg.solve(normal, pull[..., None])[..., 0], 0.0, 1.0)
        trial_deviations = metamodels.residuals(trials)
        trial_squares = (trial_deviations**2).sum(axis=1)
        better = trial_squares < squares
        points[better], deviations[better] = trials[better], trial_deviations[better]
        squares = np.minimum(squares, trial_squares)
        damping = np.where(better, damping / 10, damping * 10)
    return points
