"""Choice of the next run of the sequential strategy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from grainfit.evaluation import Evaluation
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import points_about, shrinking_search, spread_points
from grainfit.problem import Problem
from grainfit.strategies.sequential.belief import Belief
from grainfit.strategies.sequential.feasibility import FeasibilityModel
from grainfit.strategies.sequential.knowledge_gradient import KnowledgeGradient

Array = NDArray[np.float64]

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


def next_point(belief: Belief, conditioned: Metamodels, random: np.random.Generator) -> Array:
    """Return the point of the unit cube for the next run."""
    if belief.seems_missed:
        # The best point that the metamodels know is no answer: another basin, or none, has one.
        return belief.hopeful
    if not belief.agrees:
        return _most_improving_point(belief, conditioned, random)
    return belief.gain_point if belief.is_proven else belief.answer


def _most_improving_point(
    belief: Belief, conditioned: Metamodels, random: np.random.Generator
) -> Array:
    possible = belief.answers.candidates
    improvement = KnowledgeGradient(conditioned, possible, belief.handicaps(possible))

    def lack(points: Array) -> Array:
        unknown = conditioned.deviations(points)[1].sum(axis=1)
        success = belief.feasibility.success_probability(points)
        return np.asarray(-(improvement(points) + _TIE * unknown) * success**2)

    near = points_about(belief.answers.closest[:1], _NEAR_CANDIDATES, 0.25, random)
    everywhere = spread_points(_GLOBAL_CANDIDATES, belief.problem.dimension, random)
    starts = np.vstack([possible, near, everywhere])
    points, _ = shrinking_search(lack, starts, random, rounds=2, width=0.08)
    return np.asarray(points[0])


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
