"""Cost of an evaluation of each test over the free parameters, estimated from the runs so far."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grainfit.arrays import Array
from grainfit.evaluation import Evaluation
from grainfit.problem import Problem, TestScope

#: Time that the choice and the start of a run take beside its simulation, s.
_OVERHEAD = 1.0
#: Costs are rounded to this many steps per factor of two: wall times differ a little from one start
#: of the same calibration to the next, and its proposals should not.
_STEPS_PER_OCTAVE = 2
#: Standard deviation of the logarithm of the wall times of equal runs, and of its change over an
#: interval before any run.
_SCATTER, _PRIOR_SLOPE = 0.3, 1.0


class RunCosts:
    """Computing time of an evaluation of each test at points of the unit cube.

    The logarithm of the wall time of a run is linear in the parameters that the test depends on, as
    with Young's modulus, from which the time step follows (ridge regression). A test without timed
    runs has its estimated time, and a relative of a test its share of that of the test.

    Parameters
    ----------
    problem : Problem
        Problem with its tests.
    evaluations : sequence of Evaluation
        The runs so far; failed ones do not count.
    """

    def __init__(self, problem: Problem, evaluations: Sequence[Evaluation]) -> None:
        self._problem = problem
        self._scopes = {scope.name: scope for scope in problem.scopes}
        timed = {scope.name: _timed_runs(evaluations, scope.name) for scope in problem.scopes}
        known = [runs or scope.seconds for scope in problem.scopes for runs in [timed[scope.name]]]
        self._trends = {
            scope.name: self._trend(scope, timed[scope.name]) if all(known) else None
            for scope in problem.scopes
        }

    def _trend(self, scope: TestScope, runs: Sequence[tuple[Evaluation, float]]) -> Array:
        """Return the logarithm at the centre and its slopes along the axes of the test."""
        axes = self._problem.axes_of(scope)
        if not runs:
            assert scope.seconds is not None
            return np.array([np.log(scope.seconds), *np.zeros(len(axes))])
        points = [self._problem.to_unit(e.proposal.parameters)[axes] for e, _ in runs]
        logarithms = np.log([seconds for _, seconds in runs])
        middle = float(np.median(logarithms))
        matrix = np.column_stack([np.ones(len(runs)), np.array(points) - 0.5])
        ridge = np.diag([0.0, *np.full(len(axes), (_SCATTER / _PRIOR_SLOPE) ** 2)])
        found = np.linalg.lstsq(matrix.T @ matrix + ridge, matrix.T @ (logarithms - middle))[0]
        return np.asarray(found + np.array([middle, *np.zeros(len(axes))]))

    def seconds(self, scope: TestScope, points: Array) -> Array:
        """Cost of an evaluation of a test at points of the unit cube, s, shape (m,).

        Runs count alike while the time of some test is not known at all.
        """
        for relative in self._problem.relatives:
            if relative.name == scope.name and relative.cost is not None:
                return relative.cost * self.seconds(self._scopes[relative.of], points)
        trend = self._trends[scope.name]
        if trend is None:
            return np.full(len(points), float(scope.repeats))
        axes = self._problem.axes_of(scope)
        # Beyond the fitted runs a trend means little; a factor of 1,000 is more than any test has.
        change = np.clip((points[:, axes] - 0.5) @ trend[1:], -np.log(1e3), np.log(1e3))
        cost = scope.repeats * (_OVERHEAD + np.exp(trend[0] + change))
        return np.asarray(2 ** (np.round(_STEPS_PER_OCTAVE * np.log2(cost)) / _STEPS_PER_OCTAVE))


def _timed_runs(evaluations: Sequence[Evaluation], test: str) -> list[tuple[Evaluation, float]]:
    return [
        (evaluation, seconds)
        for evaluation in evaluations
        if test not in evaluation.failures
        and (seconds := evaluation.test_seconds.get(test, 0.0)) > 0.0
    ]
