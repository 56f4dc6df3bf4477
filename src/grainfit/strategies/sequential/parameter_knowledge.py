"""Knowledge of the parameters by the runs so far, and whether further runs can narrow it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from grainfit.arrays import Array
from grainfit.metamodels.credible_interval import extended_to_bounds
from grainfit.metamodels.importance_sampling import (
    importance_sample,
    representatives,
    weighted_quantiles,
)
from grainfit.metamodels.likelihood import Likelihood, log_density, log_prior
from grainfit.metamodels.metamodels import Metamodels
from grainfit.one_thread import one_thread
from grainfit.strategies.feasibility import FeasibilityModel

#: Exact metamodels must narrow an interval by this share to justify further runs: then half of
#: the metamodels' variance is worth 7 %, and that takes as many runs again.
_GAIN_WORTH_RUNS = 0.15
#: Where exact metamodels leave less than this share of the wanted half-width, it is within reach.
_WITHIN_REACH = 0.95
#: Least weight of a response, as a share of the largest.
_LEAST_WORTH, _TIE = 0.02, 1e-6
_TINY = 1e-200
_TAILS = (0.025, 0.975)
_REPRESENTATIVES = 128
#: Shares of the metamodels' variance that are tried to estimate how many runs are needed.
_SHARES_LEFT = np.geomspace(0.8, 0.02, 12)


class ParameterKnowledge:
    """Half-widths of the 95 % intervals of the parameters, now and after further runs.

    Weighted points represent the posterior distribution, the same as that of the final intervals.
    With smaller variances of the metamodels and unchanged means, the same points have other
    weights: so it is known at once what pending runs will bring, or exact metamodels. Where a run
    rather fails than succeeds, the metamodels can learn only from runs elsewhere.

    Parameters
    ----------
    metamodels : Metamodels
        Of all responses.
    feasibility : FeasibilityModel
        Probability that a run succeeds.
    answer : ndarray, shape (d,)
        Point of the current answer, which the intervals hold and their half-widths refer to.
    wanted : float
        Wanted half-width, a share of the value.
    seeds : sequence of int
        Decide the points.
    """

    def __init__(
        self,
        metamodels: Metamodels,
        feasibility: FeasibilityModel,
        answer: Array,
        wanted: float,
        seeds: Sequence[int],
    ) -> None:
        self.wanted = wanted
        self._problem = metamodels.problem
        self._answer = answer
        self._metamodels = metamodels
        self._seeds = tuple(seeds)
        reduced = metamodels.reduced()
        density = log_density(reduced, feasibility.is_likely)
        with one_thread():
            self._sample = importance_sample(density, self._problem.dimension, self._random())
            self._means, self._errors = reduced.predict(self._sample.points)
        self._prior = log_prior(self._problem, self._sample.points, feasibility.is_likely)
        self._likelihood = Likelihood(self._problem)

    def _random(self) -> np.random.Generator:
        return np.random.default_rng(self._seeds)

    @cached_property
    def half_widths(self) -> Mapping[str, float]:
        """Half the width of the 95 % interval of each parameter, a share of its value."""
        return self._named(self._half_widths(self._errors))

    @cached_property
    def at_best(self) -> Mapping[str, float]:
        """The same if the metamodels were exact: no number of runs leaves less."""
        return self._named(self._half_widths(np.zeros_like(self._errors)))

    @property
    def too_wide(self) -> tuple[str, ...]:
        """Parameters whose half-width is above the wanted one."""
        return tuple(name for name, width in self.half_widths.items() if width > self.wanted)

    @property
    def is_worth_runs(self) -> bool:
        """Whether runs can noticeably narrow the interval of a parameter that is too wide."""
        return self._is_worth_runs(self.half_widths)

    def is_worth_runs_after(self, conditioned: Metamodels) -> bool:
        """Whether that is so after the pending runs, too.

        Parameters
        ----------
        conditioned : Metamodels
            Conditioned on the pending runs.
        """
        _, errors = conditioned.reduced().predict(self._sample.points)
        then = np.minimum(errors, self._errors)
        return self._is_worth_runs(self._named(self._half_widths(then)))

    def _is_worth_runs(self, half_widths: Mapping[str, float]) -> bool:
        within_reach = _WITHIN_REACH * self.wanted
        return any(
            width > self.wanted and best < max(within_reach, (1 - _GAIN_WORTH_RUNS) * width)
            for width, best in zip(half_widths.values(), self.at_best.values(), strict=True)
        )

    @cached_property
    def points(self) -> Array:
        """Points that represent the posterior equally, shape (m, d)."""
        weights = self._weights(self._errors)
        return representatives(self._sample.points, weights, _REPRESENTATIVES, self._random())

    @cached_property
    def worths(self) -> Array:
        """Narrowing by a smaller variance of each response's deviations, shape (targets,).

        The logarithm by which an exact metamodel of this response alone would narrow the intervals
        that are too wide, over its variance now.
        """
        narrowed = np.array([self._narrowing_by(column) for column in range(self._errors.shape[1])])
        # Sampled narrowings are rough, and the last response must not be forgotten.
        narrowed = np.maximum(narrowed, max(_LEAST_WORTH * float(narrowed.max()), _TIE))
        return np.asarray(narrowed / np.maximum(self._variances, _TINY))

    def _narrowing_by(self, response: int) -> float:
        exact = self._errors.copy()
        exact[:, response] = 0.0
        then = self._named(self._half_widths(exact))
        return sum(math.log(self.half_widths[name] / then[name]) for name in self.too_wide)

    @cached_property
    def _variances(self) -> Array:
        """Variances of the deviations, in the mean over the posterior, shape (targets,)."""
        return np.asarray(self._metamodels.deviations(self.points)[1].mean(axis=0))

    @cached_property
    def runs_needed(self) -> int:
        """Estimated number of further runs until no more are worth making."""
        if not self.is_worth_runs:
            return 0
        left = next((share for share in _SHARES_LEFT if self._is_enough(share)), _SHARES_LEFT[-1])
        scatter = self._metamodels.scatter_at(self.points).mean(axis=0)
        # Runs there whose mean scatters as the expected responses do.
        made = float((scatter / np.maximum(self._variances, _TINY)).max())
        return max(1, math.ceil(min(made * (1 / float(left) - 1), 1e6)))

    def _is_enough(self, share: float) -> bool:
        """Whether a share of the metamodels' variance leaves intervals that are not worth runs."""
        return not self._is_worth_runs(self._named(self._half_widths(share * self._errors)))

    def _weights(self, errors: Array) -> Array:
        return self._sample.weights(self._likelihood.logarithms(self._means, errors) + self._prior)

    def _half_widths(self, errors: Array) -> Array:
        weights = self._weights(errors)
        columns = self._sample.points.T
        ends = np.array([weighted_quantiles(column, weights, _TAILS) for column in columns])
        low, high = extended_to_bounds(*ends.T)
        low, high = np.minimum(low, self._answer), np.maximum(high, self._answer)
        lowest, highest, value = (
            np.array(list(self._problem.from_unit(point).values()))
            for point in (low, high, self._answer)
        )
        half = (highest - lowest) / 2
        return np.asarray(np.maximum(half, _TINY) / np.maximum(np.abs(value), _TINY))

    def _named(self, half_widths: Array) -> dict[str, float]:
        names = (parameter.name for parameter in self._problem.parameters)
        return dict(zip(names, half_widths.tolist(), strict=True))
