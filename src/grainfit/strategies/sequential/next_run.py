"""Choice of the next run of the sequential strategy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from scipy.spatial.distance import cdist

from grainfit.arrays import Array
from grainfit.evaluation import Evaluation
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import points_about, shrinking_search, spread_points
from grainfit.problem import Problem, TestScope
from grainfit.strategies.feasibility import LIKELY_TO_SUCCEED, FeasibilityModel
from grainfit.strategies.run_costs import RunCosts
from grainfit.strategies.sequential.belief import Belief
from grainfit.strategies.sequential.knowledge_gradient import KnowledgeGradient

#: If the doubt expected after the pending runs is below this share of the accepted doubt, they may
#: be enough: to wait for them is cheaper than one run too many.
_SMALL_DOUBT = 1.2
#: Where nothing improves the answer, the next run goes where least is known.
_TIE = 1e-6
_GLOBAL_CANDIDATES = 96
_NEAR_CANDIDATES = 32
_SPACE_FILLING_CANDIDATES = 512


def pending_is_enough(
    belief: Belief, conditioned: Metamodels, pending: int, confidence: float
) -> bool:
    """Whether the pending runs will probably be enough for the next decision.

    Parameters
    ----------
    belief : Belief
        Belief from the runs known so far.
    conditioned : Metamodels
        Conditioned on the pending runs.
    pending : int
        Number of pending runs.
    confidence : float
        Demanded probability that all expected responses are within their tolerances.
    """
    if not belief.agrees:
        doubt = 1.0 - float(conditioned.probability_all_met(belief.answer)[0])
        return doubt <= _SMALL_DOUBT * (1.0 - confidence)
    if not belief.is_proven:
        return True
    return pending >= belief.metamodels.runs_needed(belief.gain_point, confidence)


@dataclass(frozen=True)
class NextRun:
    """Place of a run in the unit cube, and the test, or its relative, that is run there."""

    point: Array
    scope: TestScope


def next_run(
    belief: Belief, conditioned: Metamodels, costs: RunCosts, random: np.random.Generator
) -> NextRun:
    """Return the next run: point of the unit cube and test.

    Parameters
    ----------
    belief : Belief
        Belief from the runs known so far.
    conditioned : Metamodels
        Conditioned on the pending runs.
    costs : RunCosts
        Cost of a run of each test.
    random : numpy.random.Generator
        Draws the candidates.
    """
    scopes = belief.problem.scopes
    if belief.seems_missed:
        # The best point that the metamodels know is no answer: another basin, or none, has one.
        relatives = _relatives_that_succeed(belief, belief.hopeful)
        return _most_telling(belief.hopeful, conditioned, costs, scopes, relatives)
    if not belief.agrees:
        return _most_improving(belief, conditioned, costs, random)
    if belief.is_proven:
        relatives = _relatives_that_succeed(belief, belief.gain_point)
        return _most_telling(belief.gain_point, conditioned, costs, scopes, relatives)
    unproven = belief.feasibility.unproven(belief.answer)
    return _most_telling(
        belief.answer, conditioned, costs, [s for s in scopes if s.name in unproven]
    )


def _relatives_that_succeed(belief: Belief, point: Array) -> list[TestScope]:
    """Return the relatives of tests of which a run at a point is likely to succeed."""
    chances = belief.feasibility.success_of_run
    relatives = belief.problem.relative_scopes
    return [one for one in relatives if chances(one.name, point[None])[0] > LIKELY_TO_SUCCEED]


def _most_telling(
    point: Array,
    conditioned: Metamodels,
    costs: RunCosts,
    scopes: Sequence[TestScope],
    relatives: Sequence[TestScope] = (),
) -> NextRun:
    """Choose the test that narrows the expected deviations at a point most per second.

    Or one of some relatives.
    """
    variances = conditioned.deviations(point)[1][0]
    narrowed = variances**2 / (variances + conditioned.scatter_at(point)[0])
    narrowed = narrowed * conditioned.precisions
    by_relatives = np.zeros_like(narrowed)
    if relatives:
        at = point[None]
        covariance, unknown = conditioned.covariance_with_relatives(at)(at)
        of_run = unknown[:, 0] + conditioned.scatter_of_relatives_at(at)[0]
        by_relatives = covariance[:, 0, 0] ** 2 / of_run * conditioned.precisions

    def worth(scope: TestScope) -> float:
        if scope in relatives:
            gain = float(by_relatives[conditioned.told_by(scope.name)].sum())
        else:
            gain = float(narrowed[conditioned.yielded_by([scope.name])].sum())
        return gain / float(costs.seconds(scope, point[None])[0])

    possible = [*scopes, *relatives]
    return NextRun(point, max(possible, key=worth) if len(possible) > 1 else possible[0])


def _most_improving(
    belief: Belief, conditioned: Metamodels, costs: RunCosts, random: np.random.Generator
) -> NextRun:
    possible = belief.answers.candidates
    handicaps = belief.handicaps(possible)
    improvement = KnowledgeGradient(conditioned, possible, handicaps)
    relatives = belief.problem.relative_scopes
    by_relatives = (
        KnowledgeGradient(conditioned, possible, handicaps, of_relatives=True)
        if relatives
        else improvement
    )
    near = points_about(belief.answers.closest[:1], _NEAR_CANDIDATES, 0.25, random)
    everywhere = spread_points(_GLOBAL_CANDIDATES, belief.problem.dimension, random)
    starts = np.vstack([possible, near, everywhere])
    several = len(belief.problem.scopes) + len(relatives) > 1

    def best_of(scope: TestScope) -> tuple[float, NextRun]:
        is_relative = scope in relatives
        of_runs = by_relatives if is_relative else improvement
        yields = conditioned.yielded_by([scope.name]) if several else None
        if is_relative:
            yields = conditioned.told_by(scope.name)

        def lack(points: Array) -> Array:
            improved, unknown = of_runs.with_unknown(points, yields)
            success = belief.feasibility.success_of_run(scope.name, points)
            # What is unknown of a relative is no reason for a run of it.
            worth = (improved + (0.0 if is_relative else _TIE) * unknown) * success**2
            return np.asarray(-worth / costs.seconds(scope, points) if several else -worth)

        points, values = shrinking_search(lack, starts, random, rounds=2, width=0.08)
        return float(values[0]), NextRun(np.asarray(points[0]), scope)

    told = [one for one in relatives if conditioned.told_by(one.name).any()]
    return min(map(best_of, [*belief.problem.scopes, *told]), key=itemgetter(0))[1]


def space_filling_point(
    problem: Problem, known: Sequence[Evaluation], tried: Array, random: np.random.Generator
) -> Array:
    """Return a point far from all others where runs may succeed.

    Parameters
    ----------
    problem : Problem
        Defines the unit cube.
    known : sequence of Evaluation
        Known runs; too few of them have succeeded for metamodels.
    tried : ndarray, shape (n, d)
        Points of all proposals.
    random : numpy.random.Generator
        Draws the candidates.
    """
    points = spread_points(_SPACE_FILLING_CANDIDATES, problem.dimension, random)
    likely = FeasibilityModel(problem, known).success_probability(points)
    return np.asarray(points[np.argmax(cdist(points, tried).min(axis=1) * likely)])
