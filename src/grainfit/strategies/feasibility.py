"""Probability that a run succeeds, estimated from the runs nearby."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from grainfit.arrays import Array
from grainfit.evaluation import Evaluation
from grainfit.problem import Problem, TestScope

#: Probability of success above which a point may be an answer, or a run of its own.
LIKELY_TO_SUCCEED = 0.5
#: Length of the kernel per axis: the neighbourhood about which a run gives information.
_REACH = 0.15
#: Largest distance of a success that proves a point, as a share of that length.
_PROVEN = 0.25
#: Prior: every point counts as if one run had succeeded there.
_PRIOR = 1.0
#: What a run of the test is expected to do as its relative does: a part, so that it is tried.
_TRUST = 0.8


class FeasibilityModel:
    """Probability that a run at a point succeeds: the share of successes among its neighbours.

    A kernel estimate with an optimistic prior: one failure halves the probability at its point,
    each further one lowers it more. What is known beforehand of a relative of a test makes its
    prior less optimistic where that fails. Runs that failed by a fault of the machine do not
    count. With several tests, all have to succeed, each judged by its own runs and parameters.
    Relatives of tests are judged apart.

    Parameters
    ----------
    problem : Problem
        Defines the unit cube.
    evaluations : sequence of Evaluation
        The runs known so far.
    """

    def __init__(self, problem: Problem, evaluations: Sequence[Evaluation]) -> None:
        telling = [e for e in evaluations if not e.failed_by_machine]
        self._relatives = {
            one.name: _TestFeasibility(problem, one.scope(problem.scope_of_test(one.of)), telling)
            for one in problem.relatives
        }
        known = {one.of: self._relatives[one.name] for one in problem.relatives if one.cost is None}
        self._tests = [
            _TestFeasibility(problem, scope, telling, known.get(scope.name))
            for scope in problem.scopes
        ]

    def success_probability(self, points: Array) -> Array:
        """Probability that a run at each of some points succeeds, shape (m,)."""
        chances = [test.success_probability(points) for test in self._tests]
        return np.asarray(np.prod(chances, axis=0))

    def is_likely(self, points: Array) -> NDArray[np.bool_]:
        """Whether runs at points are likely to succeed, so that one may be the answer, shape (m,).

        The nearest run tells more than the share about it, where failures end at a border.
        """
        by_share = self.success_probability(points) > LIKELY_TO_SUCCEED
        nearer = [test.is_nearer_success(points) for test in self._tests]
        return np.asarray(by_share | np.all(nearer, axis=0))

    def success_of_run(self, test: str, points: Array) -> Array:
        """Probability that a run of a relative, or of all tests, succeeds at points, shape (m,)."""
        if test in self._relatives:
            return self._relatives[test].success_probability(points)
        return self.success_probability(points)

    def is_proven(self, point: Array) -> bool:
        """Whether a run has succeeded near a point, and nearer than any that failed.

        True everywhere as long as no run has failed.
        """
        return all(test.is_proven(point) for test in self._tests)

    def unproven(self, point: Array) -> list[str]:
        """Return the names of the tests that are not proven at a point."""
        return [test.name for test in self._tests if not test.is_proven(point)]


class _TestFeasibility:
    """The same of one test."""

    def __init__(
        self,
        problem: Problem,
        scope: TestScope,
        evaluations: Sequence[Evaluation],
        known: _TestFeasibility | None = None,
    ) -> None:
        self.name = scope.name
        self._axes = problem.axes_of(scope)
        own = [e for e in evaluations if e.proposal.asks_for(scope.name)]
        failed = [e.failed_in(scope.name) for e in own]
        self._failed = np.array(failed, dtype=float)
        points = [problem.to_unit(e.proposal.parameters)[self._axes] for e in own]
        self._points = np.array(points).reshape(-1, len(self._axes))
        self._known = known

    @property
    def _is_trusted(self) -> bool:
        """Whether nothing says that a run may fail."""
        return self._known is None and not self._failed.any()

    def success_probability(self, points: Array) -> Array:
        if self._is_trusted:
            return np.ones(len(points))
        doubt = np.zeros(len(points))
        if self._known is not None:
            doubt = _TRUST * (1.0 - self._known.success_probability(points))
        distances = cdist(points[:, self._axes], self._points)
        nearness = np.exp(-0.5 * (distances / self._reach) ** 2)
        failures = _PRIOR * doubt + nearness @ self._failed
        return np.asarray(1.0 - failures / (_PRIOR + nearness.sum(axis=1)))

    def is_nearer_success(self, points: Array) -> NDArray[np.bool_]:
        if self._is_trusted:
            return np.ones(len(points), dtype=bool)
        success, failure = self._distances(points)
        return np.asarray((success <= _PROVEN * self._reach) & (success < failure))

    def is_proven(self, point: Array) -> bool:
        if not self._failed.any():
            return True
        [success], [failure] = self._distances(point[None])
        return bool(success <= _PROVEN * self._reach and success <= failure)

    def _distances(self, points: Array) -> tuple[Array, Array]:
        """Distances to the nearest success and to the nearest failure, shape (m,)."""
        distances = cdist(points[:, self._axes], self._points)
        success, failure = (
            distances[:, chosen].min(axis=1, initial=np.inf)
            for chosen in (self._failed == 0, self._failed == 1)
        )
        return success, failure

    @property
    def _reach(self) -> float:
        return float(_REACH * np.sqrt(self._points.shape[1]))
