"""Belief of the sequential strategy: metamodels and answer that follow from the runs so far."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from grainfit.arrays import Array
from grainfit.evaluation import Evaluation
from grainfit.metamodels.blow_ups import without_blow_ups
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.metamodels.time_steps import handicaps, log_time_steps
from grainfit.problem import Problem
from grainfit.strategies.feasibility import FeasibilityModel
from grainfit.strategies.out_of_reach import out_of_reach
from grainfit.strategies.sequential.answer_search import AnswerSearch
from grainfit.strategies.sequential.options import SequentialOptions
from grainfit.strategies.sequential.parameter_knowledge import ParameterKnowledge
from grainfit.verdict.edge import is_at_edge
from grainfit.verdict.options import VERDICT
from grainfit.verdict.out_of_reach import OutOfReach

#: Smallest probability at which fresh seeds at an answer are worth their runs.
LIKELY = 0.5
#: The closest point counts as no answer when it misses a target by as many standard errors.
_SEEMS_MISSED = 1.65
#: A target must be missed by this many standard errors, because it is checked after every run.
STANDARD_ERRORS = 3.0


class Belief:
    """Metamodels, feasibility, and the answer that follow from the runs known so far.

    Parameters
    ----------
    problem : Problem
        Problem with the intervals searched now. The attribute of that name has components instead
        of curves.
    known : sequence of Evaluation
        The runs.
    seed : int
        Decides the searches of the metamodels.
    options : SequentialOptions
        Preference and demanded probability.
    confidence_to_stop : float
        Probability at which the search stops. A larger time step is not bought with less.
    """

    def __init__(
        self,
        problem: Problem,
        known: Sequence[Evaluation],
        seed: int,
        options: SequentialOptions,
        confidence_to_stop: float,
    ) -> None:
        known = without_blow_ups(problem, known)
        self._given, self._known = problem, known
        self.metamodels = Metamodels.fit(problem, known)
        self.problem = problem = self.metamodels.problem
        self.feasibility = FeasibilityModel(problem, known)
        self._seed = seed
        self._options = options
        self._confidence_to_stop = confidence_to_stop
        runs = np.array([problem.to_unit(e.proposal.parameters) for e in known])
        self._seeds = (seed, len(known))
        self._needed: dict[float, int] = {}
        self.answers = AnswerSearch(self.metamodels, self.feasibility, runs, self._seeds)

    @cached_property
    def misses(self) -> tuple[OutOfReach, ...]:
        """Targets that are out of reach."""
        if self._may_meet_all(self.answers.closest[0]) or self._may_meet_all(self.hopeful):
            return ()
        if self.problem.relatives:
            return self._misses_without_relatives
        return out_of_reach(
            self.metamodels, self.hopeful, self.feasibility, self._seed, STANDARD_ERRORS
        )

    @property
    def _misses_without_relatives(self) -> tuple[OutOfReach, ...]:
        """Targets that are out of reach by the runs of the tests alone, as verdicts are."""
        own = replace(self._given, relatives=())
        if not can_be_fitted(own, self._known):
            return ()
        alone = Belief(own, self._known, self._seed, self._options, self._confidence_to_stop)
        return alone.misses

    def _may_meet_all(self, point: Array) -> bool:
        return bool(self.metamodels.shortfall(point, STANDARD_ERRORS)[0] == 0)

    @cached_property
    def hopeful(self) -> Array:
        """Point at which the targets are missed least, if at all, by an optimistic estimate."""
        return self.answers.most_hopeful(STANDARD_ERRORS)

    @cached_property
    def seems_missed(self) -> bool:
        """Whether some target is missed at the closest point, and the standard errors are small."""
        return bool(self.metamodels.shortfall(self.answers.closest[0], _SEEMS_MISSED)[0] > 0)

    @property
    def is_likely(self) -> bool:
        """Whether the answer agrees more likely than not."""
        return self.probability >= LIKELY

    @cached_property
    def answer(self) -> Array:
        """Point of the current answer."""
        if self._options.prefer == "accuracy":
            return np.asarray(self.answers.closest[0])
        return self.answers.fastest(self._confidence_to_stop)

    @cached_property
    def probability(self) -> float:
        """Probability that the answer agrees with all measurements."""
        return float(self.metamodels.probability_all_met(self.answer)[0])

    @property
    def agrees(self) -> bool:
        """Whether it agrees with the demanded probability."""
        return self.probability >= self._options.confidence

    @cached_property
    def is_proven(self) -> bool:
        """Whether runs at the answer can be expected to succeed."""
        return self.feasibility.is_proven(self.answer)

    @cached_property
    def _gain(self) -> tuple[Array, float]:
        if self._options.prefer == "accuracy":
            return self.answer, 0.0
        return self.answers.time_step_to_gain(self.answer)

    @property
    def gain_point(self) -> Array:
        """Point with the largest expected gain of the time step."""
        return self._gain[0]

    @property
    def gain(self) -> float:
        """Largest expected gain of the time step, as a share of it."""
        return self._gain[1]

    def handicaps(self, points: Array) -> Array:
        """Penalties of possible answers: a small time step, and what was measured otherwise."""
        own = (self.problem.standardised_residuals(points) ** 2).sum(axis=1)
        if self._options.prefer == "accuracy":
            return np.asarray(own)
        return np.asarray(handicaps(self.problem, points) + own)

    def runs_needed(self, confidence: float) -> int:
        """Estimated number of further runs at the answer that would decide it."""
        # A display asks several times a second.
        if confidence not in self._needed:
            point = self.answers.closest[0]
            self._needed[confidence] = self.metamodels.runs_needed(point, confidence)
        return self._needed[confidence]

    @property
    def is_at_edge(self) -> bool:
        """Whether the closest point is known to lie on the edge of a tolerance."""
        targets = self.problem.targets
        means, variances = (one[0] for one in self.metamodels.predict(self.answers.closest[:1]))
        tolerances = np.array([target.tolerance for target in targets])
        off = np.abs(means - [target.value for target in targets]) / tolerances
        worst = int(off.argmax())
        farthest, error = float(off[worst]), float(np.sqrt(variances[worst]) / tolerances[worst])
        return farthest <= VERDICT.beyond_edge and is_at_edge(farthest, error)

    @property
    def scatter(self) -> float:
        """Largest standard deviation of single evaluations, in tolerances."""
        tolerances = np.array([target.tolerance for target in self.problem.targets])
        return float((self.metamodels.noise_at(self.answers.closest[0]) / tolerances).max())

    @cached_property
    def knowledge(self) -> ParameterKnowledge | None:
        """Knowledge of the parameters; None when no half-width of their intervals is wanted."""
        wanted = self._options.wanted_half_width
        if wanted is None:
            return None
        return ParameterKnowledge(
            self.metamodels, self.feasibility, self.answer, wanted, self._seeds
        )

    def narrowing(self, runs: int) -> float:
        """Share by which further runs at the answer would narrow its standard errors."""
        _, variances = self.metamodels.deviations(self.answer)
        scatter = self.metamodels.scatter_at(self.answer)[0]
        return float((1 - 1 / np.sqrt(1 + runs * variances[0] / scatter)).max())

    @property
    def time_step_gained(self) -> float:
        """Share by which the time step of the answer exceeds that of the closest point."""
        both = np.array([self.answer, self.answers.closest[0]])
        chosen, closest = np.exp(log_time_steps(self.problem, both))
        return float(chosen / closest - 1)
