"""Residuals of the least-squares fit, for responses and for metamodels."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from grainfit.arrays import Array
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Parameter, Problem


def residuals(problem: Problem, parameters: Mapping[str, float], responses: Array) -> Array:
    """Residuals of the least-squares fit.

    Parameters
    ----------
    problem : Problem
        Targets and weights.
    parameters : mapping of str to float
        Values of the free parameters, which determine the Rayleigh criterion.
    responses : ndarray, shape (number of targets,)
        Responses in the order of the targets.

    Returns
    -------
    ndarray, shape (number of targets + 1 + number of measured parameters,)
        Weighted deviations (equation 1), decorrelated where targets are correlated, then the
        weighted Rayleigh criterion (equation 2), then relative deviations of parameters from their
        own measurements.

    References
    ----------
    Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), equations 1 and 2.
    """
    deviations = np.array(
        [
            target.weight * target.misfit(float(response))
            for target, response in zip(problem.targets, responses, strict=True)
        ]
    )
    deviations = decorrelated(problem, deviations)
    criterion = problem.rayleigh_weight * problem.rayleigh_criterion(parameters)
    own = [
        p.standardised_residual(p.to_unit(parameters[p.name])) * relative_uncertainty(p)
        for p in problem.measured
    ]
    return np.array([*deviations, criterion, *own])


def relative_uncertainty(parameter: Parameter) -> float:
    """Return the uncertainty of a measured parameter over its value; 1 if that is zero."""
    if not parameter.measured or not parameter.uncertainty:
        return 1.0
    return parameter.uncertainty / abs(parameter.measured)


def decorrelated(problem: Problem, deviations: Array) -> Array:
    """Combine deviations, shape (targets, ...), so that their errors are not correlated."""
    if not problem.correlations:
        return deviations
    return np.asarray(problem.decorrelation @ deviations)


def expected_misfit(
    problem: Problem, parameters: Mapping[str, float], means: Array, variances: Array
) -> float:
    """Expected sum of squared residuals for responses that have a variance.

    Of two parameter sets that fit equally well, the less uncertain one has the smaller misfit.
    """
    units = np.array([target.misfit_unit for target in problem.targets])
    weights = np.array([target.weight for target in problem.targets])
    precisions = np.diagonal(problem.precision_matrix)
    spread = float(np.sum(variances * (weights / units) ** 2 * precisions))
    return float(np.sum(residuals(problem, parameters, means) ** 2)) + spread


def residuals_at(metamodels: Metamodels, point: Array) -> Array:
    """Residuals of the expected responses at a point of the unit cube, see `residuals`."""
    means, _ = metamodels.predict(point)
    return residuals(metamodels.problem, metamodels.problem.from_unit(point), means[0])


def expected_misfit_at(metamodels: Metamodels, point: Array) -> float:
    """Expected sum of squared residuals at a point of the unit cube."""
    means, variances = metamodels.predict(point)
    parameters = metamodels.problem.from_unit(point)
    return expected_misfit(metamodels.problem, parameters, means[0], variances[0])
