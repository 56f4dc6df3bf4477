"""Where runs can be expected to succeed, from where they have failed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from grainfit.campaign.evaluation import Evaluation
from grainfit.problem import Problem

Array = NDArray[np.float64]

#: How far, per axis, a run tells about its neighbourhood.
_REACH = 0.15
#: What is believed of a place before any run: as if one run had succeeded there.
_PRIOR = 1.0


class Experience:
    """Probability that a run at a point succeeds: the share of successes among its neighbours.

    A kernel estimate with a friendly prior: one failure halves the probability at its place, each
    further one lowers it more. Runs that failed by a fault of the machine say nothing.

    Parameters
    ----------
    problem : Problem
        Whose unit cube is meant.
    evaluations : sequence of Evaluation
        What is known.
    """

    def __init__(self, problem: Problem, evaluations: Sequence[Evaluation]) -> None:
        telling = [e for e in evaluations if not e.failed_by_machine]
        self._failed = np.array([bool(e.failures) for e in telling], dtype=float)
        self._points = np.array([problem.to_unit(e.proposal.parameters) for e in telling])

    def success_probability(self, points: Array) -> Array:
        """Probability that a run at each of some points succeeds, shape (m,)."""
        if not self._failed.any():
            return np.ones(len(points))
        reach = _REACH * np.sqrt(points.shape[1])
        nearness = np.exp(-0.5 * (cdist(points, self._points) / reach) ** 2)
        return np.asarray(1.0 - nearness @ self._failed / (_PRIOR + nearness.sum(axis=1)))
