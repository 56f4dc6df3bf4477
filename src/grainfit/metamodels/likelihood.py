"""Density of parameter sets, given the measurements and what the metamodels predict."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Problem

#: Whether runs are likely to succeed at points of the unit cube, shape (m, d) to (m,).
Succeeds = Callable[[Array], NDArray[np.bool_]]
#: Logarithm of the density where they fail, finite so that it can be sharpened from a constant.
_NOTHING_TO_MEASURE = -1e6


class Likelihood:
    """Likelihood of the measured values, which are normal about the expected responses.

    Their variance is that of the measurement plus that of the metamodel's mean, which includes the
    scatter from run to run; correlations of the targets are those of the measurement.

    Parameters
    ----------
    problem : Problem
        Has the targets.
    """

    def __init__(self, problem: Problem) -> None:
        targets = problem.targets
        self._measured = np.array([target.value for target in targets])
        deviations = np.array([target.standard_uncertainty for target in targets])
        self._variances = deviations**2
        self._covariance: Array | None = None
        if problem.correlations:
            self._covariance = problem.correlation_matrix * np.outer(deviations, deviations)

    def logarithms(self, means: Array, errors: Array, correlation: Array | None = None) -> Array:
        """Return logarithms of the likelihood, but for a constant, shape (m,).

        Parameters
        ----------
        means, errors : ndarray, shape (m, targets)
            Expected responses and the variances of their metamodels.
        correlation : ndarray, shape (targets, targets), optional
            Of the errors of the metamodels; without it they are independent.
        """
        if self._covariance is not None or correlation is not None:
            return self._correlated(means, errors, correlation)
        total = self._variances + errors
        # A point must not look good only because it is uncertain.
        off = (means - self._measured) ** 2 / total
        return np.asarray(-0.5 * (off + np.log(total)).sum(axis=1))

    def _correlated(self, means: Array, errors: Array, correlation: Array | None) -> Array:
        measured = np.diag(self._variances) if self._covariance is None else self._covariance
        # Metamodels that are fitted one by one have independent errors.
        between = np.eye(len(self._measured)) if correlation is None else correlation
        deviations = np.sqrt(errors)
        total = measured + between * deviations[:, :, None] * deviations[:, None, :]
        factors = np.linalg.cholesky(total)
        off = np.linalg.solve(factors, (means - self._measured)[..., None])[..., 0]
        logarithms = np.log(np.diagonal(factors, axis1=1, axis2=2))
        return np.asarray(-0.5 * (off**2).sum(axis=1) - logarithms.sum(axis=1))


def log_prior(problem: Problem, points: Array, succeeds: Succeeds | None = None) -> Array:
    """Return logarithms of the density before the tests at points of the unit cube, shape (m,).

    It is even over the cube; a parameter with a measurement of its own is normal about it. It is
    next to nothing where runs fail: there, nothing could have been measured.
    """
    found = np.asarray(-0.5 * (problem.standardised_residuals(points) ** 2).sum(axis=1))
    if succeeds is None:
        return found
    return np.where(succeeds(points), found, found + _NOTHING_TO_MEASURE)


def log_density(
    metamodels: Metamodels, succeeds: Succeeds | None = None
) -> Callable[[Array], Array]:
    """Return the logarithm of the posterior density over the unit cube, but for a constant.

    Parameters
    ----------
    metamodels : Metamodels
        Of all responses.
    succeeds : callable, optional
        Whether runs are likely to succeed at points; by default they are everywhere.

    Returns
    -------
    callable
        Of points, shape (m, d): logarithms, shape (m,).
    """
    likelihood = Likelihood(metamodels.problem)

    def logarithms(points: Array) -> Array:
        found = likelihood.logarithms(*metamodels.predict(points))
        return np.asarray(found + log_prior(metamodels.problem, points, succeeds))

    return logarithms
