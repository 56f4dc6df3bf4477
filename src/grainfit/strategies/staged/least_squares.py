"""Levenberg-Marquardt with bounds: a whole fit on metamodels, and single steps on the DEM."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from grainfit.arrays import Array
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.metamodels import Metamodels
from grainfit.strategies.staged.residuals import (
    decorrelated,
    expected_misfit_at,
    relative_uncertainty,
    residuals,
    residuals_at,
)

_STARTS = 12
_DIFFERENCE = 1e-6
# Far below the accuracy of the metamodels: a nearer point is no better.
_SMALL_MOVE, _SMALL_GAIN = 1e-5, 1e-6
_MOST_STEPS = 40


def fit_on_metamodels(metamodels: Metamodels, seed: int) -> Array:
    """Return the point of the unit cube at which the residuals of the metamodels are smallest.

    Levenberg-Marquardt in its trust-region form with bounds, from several starts (a Latin hypercube
    and the centre). Of several points that fit equally well, it returns the one with the smallest
    uncertainty.

    Returns
    -------
    ndarray, shape (d,)
        The optimum.
    """
    dimension = metamodels.problem.dimension
    starts = np.vstack([np.full(dimension, 0.5), maximin_latin_hypercube(_STARTS, dimension, seed)])
    ends = [
        least_squares(
            partial(residuals_at, metamodels),
            start,
            jac=lambda point: _jacobian(metamodels, point),
            bounds=(0.0, 1.0),
            method="trf",
            xtol=_SMALL_MOVE,
            ftol=_SMALL_GAIN,
            max_nfev=_MOST_STEPS,
        ).x
        for start in starts
    ]
    return min(ends, key=partial(expected_misfit_at, metamodels))


def _jacobian(metamodels: Metamodels, point: Array) -> Array:
    """Derivatives of the residuals at a point, shape (number of residuals, d)."""
    problem = metamodels.problem
    scale = np.array([target.weight / target.misfit_unit for target in problem.targets])
    criterion = [
        problem.rayleigh_weight * _criterion_slope(metamodels, point, axis)
        for axis in range(problem.dimension)
    ]
    shares = [relative_uncertainty(p) for p in problem.measured]
    own = problem.standardised_residual_slopes(point)[0] * np.reshape(shares, (-1, 1))
    slopes = decorrelated(problem, metamodels.gradients(point)[0] * scale[:, None])
    return np.vstack([slopes, criterion, own])


def _criterion_slope(metamodels: Metamodels, point: Array, axis: int) -> float:
    problem = metamodels.problem
    if problem.rayleigh is None or problem.rayleigh_weight == 0:
        return 0.0
    low, high = point.copy(), point.copy()
    low[axis] = max(0.0, point[axis] - _DIFFERENCE)
    high[axis] = min(1.0, point[axis] + _DIFFERENCE)
    rise = problem.rayleigh_criterion(problem.from_unit(high)) - problem.rayleigh_criterion(
        problem.from_unit(low)
    )
    return float(rise / (high[axis] - low[axis]))


def difference_points(metamodels: Metamodels, point: Array) -> Array:
    """Points for finite differences around a point, shape (d, d): row j is moved along axis j.

    A step is long enough that some response changes by three standard deviations of its noise, but
    between 5 and 25 % of the interval; it goes to the side with more room.
    """
    slopes = np.abs(metamodels.gradients(point)[0]) / np.maximum(metamodels.noise, 1e-300)[:, None]
    steepest = np.maximum(slopes.max(axis=0), 1e-12)
    steps = np.clip(3.0 / steepest, 0.05, 0.25)
    moved = np.tile(point, (len(point), 1))
    moved[np.diag_indices(len(point))] += np.where(point > 0.5, -steps, steps)
    return moved


def difference_jacobian(metamodels: Metamodels, point: Array, moved: Array) -> Array:
    """Jacobian of the residuals by differences of expected responses, given all runs so far."""
    problem = metamodels.problem
    means, _ = metamodels.predict(np.vstack([point, moved]))
    rows = [
        residuals(problem, problem.from_unit(u), mean)
        for u, mean in zip(np.vstack([point, moved]), means, strict=True)
    ]
    steps = np.diagonal(moved - point)
    return (np.array(rows[1:]) - rows[0]).T / steps


def damped_step(jacobian: Array, residual: Array, damping: float, point: Array) -> Array:
    """Levenberg-Marquardt step that stays within the unit cube.

    Parameters
    ----------
    jacobian : ndarray, shape (k, d)
    residual : ndarray, shape (k,)
    damping : float
        Levenberg-Marquardt parameter: 0 is Gauss-Newton, large is short steepest descent.
    point : ndarray, shape (d,)
        Start of the step.

    Returns
    -------
    ndarray, shape (d,)

    References
    ----------
    Marquardt (1963), SIAM J. 11(2), 431-441, with scaling by the diagonal.
    """
    scale = np.sqrt(np.maximum((jacobian**2).sum(axis=0), 1e-12))
    matrix = np.vstack([jacobian, np.sqrt(damping) * np.diag(scale)])
    target = np.concatenate([-residual, np.zeros(len(point))])
    room = 1e-12
    step = lsq_linear(matrix, target, bounds=(-point - room, 1 - point + room)).x
    return np.asarray(np.clip(point + step, 0.0, 1.0) - point)
