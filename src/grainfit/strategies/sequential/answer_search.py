"""Search the metamodels for the answer: the closest parameter set, or the fastest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from grainfit.arrays import Array
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.time_steps import (
    EQUAL_TIME_STEPS,
    log_time_steps,
    time_step_matters,
    with_long_steps,
)
from grainfit.metamodels.unit_cube import (
    gauss_newton,
    points_about,
    shrinking_search,
    smallest,
    spread_points,
)
from grainfit.problem import Problem
from grainfit.strategies.feasibility import FeasibilityModel

#: In squared tolerances, and larger than any misfit that matters.
_FORBIDDEN = 1e6
_STARTS = 64
#: Of the starts and the runs, so many are looked at closely.
_PROMISING = 96
_DESCENTS = 12
_CLOUD = 48
_CLOUD_WIDTH = 0.12


class AnswerSearch:
    """Find the parameter sets that metamodels propose as the answer.

    Parameters
    ----------
    metamodels : Metamodels
        Of all responses.
    feasibility : FeasibilityModel
        Runs must be able to succeed at an answer.
    runs : ndarray, shape (n, d)
        Points that have been simulated.
    seeds : sequence of int
        Seeds of every search: its result does not depend on earlier searches.
    """

    def __init__(
        self,
        metamodels: Metamodels,
        feasibility: FeasibilityModel,
        runs: Array,
        seeds: Sequence[int],
    ) -> None:
        self.metamodels = metamodels
        self._feasibility = feasibility
        self._seeds = tuple(seeds)
        random = self._random()
        dimension = metamodels.problem.dimension
        everywhere = np.vstack([spread_points(_STARTS, dimension, random), runs])
        starts, _ = smallest(self._misfit, self._promising(everywhere), _DESCENTS)
        found = np.vstack([gauss_newton(metamodels, starts), starts])
        #: Local minima of the expected misfit, best first, shape (m, d).
        self.closest, _ = shrinking_search(self._misfit, found, random, width=0.05)
        #: The best starts of the searches, shape (m, d).
        self.starts = starts

    @property
    def problem(self) -> Problem:
        """Problem whose answer is searched for."""
        return self.metamodels.problem

    def _random(self) -> np.random.Generator:
        return np.random.default_rng(self._seeds)

    def _misfit(self, points: Array) -> Array:
        return np.asarray(self.metamodels.misfit(points) + self._forbidden(points))

    def _forbidden(self, points: Array) -> Array:
        return np.where(self._feasibility.is_likely(points), 0.0, _FORBIDDEN)

    def _promising(self, points: Array) -> Array:
        """Leave out points whose expected deviations are large, without their variances."""
        points = np.clip(points, 0.0, 1.0)
        squares = (self.metamodels.residuals(points) ** 2).sum(axis=1)
        return points[np.argsort(squares, kind="stable")[:_PROMISING]]

    def most_hopeful(self, standard_errors: float) -> Array:
        """Point at which the targets are missed least, if at all, shape (d,).

        The estimate is optimistic: a large uncertainty favours a point.

        Parameters
        ----------
        standard_errors : float
            Number of standard errors by which a target must be missed beyond its tolerance to
            count.
        """

        def shortfall(points: Array) -> Array:
            missed = self.metamodels.shortfall(points, standard_errors)
            return np.asarray(missed + self._forbidden(points))

        starts = np.vstack([self.agreeing, self.closest, self.starts])
        return np.asarray(shrinking_search(shortfall, starts, self._random())[0][0])

    @cached_property
    def agreeing(self) -> Array:
        """Points all over the cube, moved to where they meet the targets, shape (m, d).

        Half of them have the largest time step before they are moved.
        """
        points = spread_points(_STARTS, self.problem.dimension, self._random())
        return gauss_newton(
            self.metamodels, np.vstack([points, with_long_steps(self.problem, points)])
        )

    @cached_property
    def candidates(self) -> Array:
        """Candidates for the answer, shape (m, d): around the best points, and elsewhere."""
        cloud = points_about(self.closest[:1], _CLOUD, _CLOUD_WIDTH, self._random())
        return np.vstack([self.closest, cloud, self.starts])

    def fastest(self, confidence: float) -> Array:
        """Point with the largest time step that agrees with the measurements, shape (d,).

        Of the points that agree with the demanded probability, those with the largest Rayleigh
        time step are kept (within `EQUAL_TIME_STEPS`), and the closest of them is returned. If no
        point agrees, or no free parameter changes the time step, it is the closest point of all.

        Parameters
        ----------
        confidence : float
            Demanded probability that all expected responses are within their tolerances.
        """
        closest = self.closest[0]
        if self._probability_all_met(closest[None])[0] < confidence or not time_step_matters(
            self.problem
        ):
            return np.asarray(closest)

        def lack(points: Array) -> Array:
            return _FORBIDDEN * np.maximum(confidence - self._probability_all_met(points), 0.0)

        def slowness(points: Array) -> Array:
            return lack(points) - log_time_steps(self.problem, points)

        random = self._random()
        starts = np.vstack([self.candidates, self.agreeing])
        fastest, _ = shrinking_search(slowness, starts, random, rounds=6, width=0.2)
        enough = log_time_steps(self.problem, fastest[:1])[0] + math.log1p(-EQUAL_TIME_STEPS)

        def remoteness(points: Array) -> Array:
            missing = np.maximum(enough - log_time_steps(self.problem, points), 0.0)
            return np.asarray(self._misfit(points) + lack(points) + _FORBIDDEN * missing)

        found, _ = shrinking_search(remoteness, np.vstack([fastest, starts]), random, rounds=6)
        return np.asarray(found[0])

    def time_step_to_gain(self, answer: Array) -> tuple[Array, float]:
        """Find the largest expected gain of the time step.

        Parameters
        ----------
        answer : ndarray, shape (d,)
            The answer so far.

        Returns
        -------
        point : ndarray, shape (d,)
            Point at which the gain of the logarithm of the time step, times the probability that
            the point agrees with the measurements, is largest.
        gain : float
            That product.

        References
        ----------
        Schonlau, Welch & Jones (1998): expected improvement times probability of feasibility.
        """
        if not time_step_matters(self.problem):
            return answer, 0.0
        now = log_time_steps(self.problem, answer[None])[0]

        def no_gain(points: Array) -> Array:
            gain = np.maximum(log_time_steps(self.problem, points) - now, 0.0)
            return np.asarray(-gain * self._probability_all_met(points))

        starts = np.vstack([self.candidates, self.agreeing, answer])
        points, values = shrinking_search(no_gain, starts, self._random(), width=0.2)
        return points[0], -float(values[0])

    def _probability_all_met(self, points: Array) -> Array:
        likely = self._feasibility.is_likely(points)
        # A larger time step is not bought with a value that a measurement rules out.
        likely &= (np.abs(self.problem.standardised_residuals(points)) <= 1.0).all(axis=1)
        return np.asarray(self.metamodels.probability_all_met(points) * likely)
