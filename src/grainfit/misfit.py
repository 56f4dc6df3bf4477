"""How far responses are from their targets."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from grainfit.problem import Problem, Target

Vector = NDArray[np.float64]


def relative_deviation(simulated: float, target: Target) -> float:
    """Deviation of a response from its target, relative to the target.

    References
    ----------
    Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016), equation 1.
    """
    return (simulated - target.value) / target.value


def residuals(problem: Problem, parameters: Mapping[str, float], responses: Vector) -> Vector:
    """Residuals of the least-squares fit.

    Parameters
    ----------
    problem : Problem
        Targets and weights.
    parameters : mapping of str to float
        Values of the free parameters, which decide the Rayleigh criterion.
    responses : ndarray, shape (number of targets,)
        Responses in the order of the targets.

    Returns
    -------
    ndarray, shape (number of targets + 1,)
        Weighted relative deviations (equation 1), then the weighted Rayleigh criterion
        (equation 2).
    """
    deviations = [
        target.weight * relative_deviation(float(response), target)
        for target, response in zip(problem.targets, responses, strict=True)
    ]
    criterion = problem.rayleigh_weight * problem.rayleigh_criterion(parameters)
    return np.array([*deviations, criterion])


def expected_misfit(
    problem: Problem, parameters: Mapping[str, float], means: Vector, variances: Vector
) -> float:
    """Expected sum of squared residuals when the responses are known with a variance.

    A parameter set that is only believed to be good counts less than one that is known to be.
    """
    values = np.array([target.value for target in problem.targets])
    weights = np.array([target.weight for target in problem.targets])
    spread = float(np.sum(variances * (weights / values) ** 2))
    return float(np.sum(residuals(problem, parameters, means) ** 2)) + spread


def within_tolerance(problem: Problem, responses: Vector) -> bool:
    """Whether every response deviates from its target by its tolerance at most."""
    return all(
        abs(float(response) - target.value) <= target.accepted_deviation
        for target, response in zip(problem.targets, responses, strict=True)
    )
