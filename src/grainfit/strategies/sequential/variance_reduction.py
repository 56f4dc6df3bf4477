"""Integrated variance reduction: run after which the metamodels know most about the posterior."""

from __future__ import annotations

from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import points_about, shrinking_search, spread_points
from grainfit.problem import TestScope
from grainfit.strategies.feasibility import LIKELY_TO_SUCCEED, FeasibilityModel
from grainfit.strategies.run_costs import RunCosts
from grainfit.strategies.sequential.next_run import NextRun
from grainfit.strategies.sequential.parameter_knowledge import ParameterKnowledge

_NEAR_CANDIDATES, _NEAR_WIDTH = 96, 0.2
_GLOBAL_CANDIDATES = 64


class VarianceReduction:
    """Expected reduction of the metamodels' variances over the posterior by one more run.

    The mean is over points of the posterior: what is unknown of parameter sets that do not agree
    with the measurements does not count. The sum over the responses is weighted by what a smaller
    variance of each narrows: a response that the measurement limits, or that tells nothing about
    the parameters in question, hardly counts.

    Parameters
    ----------
    metamodels : Metamodels
        Conditioned on the pending runs.
    points : ndarray, shape (m, d)
        Equally likely parameter sets that agree with the measurements.
    worths : ndarray, shape (targets,)
        Weights of the variances of the deviations, see `ParameterKnowledge.worths`.

    References
    ----------
    Sinsbeck & Nowak (2017), "Sequential design of computer experiments for the solution of
    Bayesian inverse problems", SIAM/ASA J. Uncertain. Quantif. 5, 640-664.
    Sacks, Welch, Mitchell & Wynn (1989), Stat. Sci. 4, 409-423: integrated mean squared error.
    """

    def __init__(self, metamodels: Metamodels, points: Array, worths: Array) -> None:
        self._covariance = metamodels.covariance_with(points)
        self._scatter_at = metamodels.scatter_at
        self._worths = worths

    def __call__(self, points: Array, yields: NDArray[np.bool_]) -> Array:
        """Expected reduction by a run at each of some points, shape (n,).

        ``yields`` says which targets the run yields, see `Metamodels.yielded_by`.
        """
        covariance, variance = self._covariance(points)
        reduction = (covariance**2).mean(axis=1) / (variance + self._scatter_at(points).T)
        return np.asarray((self._worths * yields) @ reduction)


def most_narrowing_run(
    conditioned: Metamodels,
    knowledge: ParameterKnowledge,
    feasibility: FeasibilityModel,
    costs: RunCosts,
    random: np.random.Generator,
) -> NextRun:
    """Return the run that reduces the weighted variances over the posterior most per second.

    Parameters
    ----------
    conditioned : Metamodels
        Conditioned on the pending runs.
    knowledge : ParameterKnowledge
        Posterior by the runs known so far.
    feasibility : FeasibilityModel
        The reduction counts with the probability that a run succeeds.
    costs : RunCosts
        Cost of a run of each test.
    random : numpy.random.Generator
        Draws the candidates.
    """
    points = knowledge.points
    reduction = VarianceReduction(conditioned, points, knowledge.worths)
    chosen = points[random.integers(len(points), size=_NEAR_CANDIDATES)]
    near = points_about(chosen, 1, _NEAR_WIDTH, random)
    everywhere = spread_points(_GLOBAL_CANDIDATES, conditioned.problem.dimension, random)
    starts = np.vstack([points, near, everywhere])

    def best_of(scope: TestScope) -> tuple[float, NextRun]:
        yields = conditioned.yielded_by([scope.name])

        def lack(points: Array) -> Array:
            success = feasibility.success_probability(points)
            success = np.where(success > LIKELY_TO_SUCCEED, success, 0.0)
            worth = reduction(points, yields) * success**2
            return np.asarray(-worth / costs.seconds(scope, points))

        found, values = shrinking_search(lack, starts, random, rounds=2, width=0.08)
        return float(values[0]), NextRun(np.asarray(found[0]), scope)

    return min(map(best_of, conditioned.problem.scopes), key=itemgetter(0))[1]
