"""State of the sequential strategy: all that follows from the runs known so far"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from grainfit.evaluation import Evaluation
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.time_steps import handicaps, log_time_steps
from grainfit.problem import Problem
from grainfit.result import OutOfReach
from grainfit.strategies.out_of_reach import out_of_reach
from grainfit.strategies.sequential.answer_search import AnswerSearch
from grainfit.strategies.sequential.feasibility import FeasibilityModel
from grainfit.strategies.sequential.options import (
    CAUTION,
    CONFIDENCE_WITHOUT_ANY_RUN,
    DEGREES_OF_FREEDOM,
    STANDARD_ERRORS,
    Array,
    SequentialOptions,
)


class SearchState:
    """What follows from all that is known, for a problem with certain intervals."""

    def __init__(
        self,
        problem: Problem,
        known: Sequence[Evaluation],
        seed: int,
        options: SequentialOptions,
    ) -> None:
        self.problem = problem
        self.metamodels = Metamodels.fit(problem, known)
        self.feasibility = FeasibilityModel(problem, known)
        self._seed = seed
        self._options = options
        runs = np.array([problem.to_unit(e.proposal.parameters) for e in known])
        seeds = (seed, len(known))
        self.search = AnswerSearch(self.metamodels, self.feasibility, runs, seeds)

    @cached_property
    def misses(self) -> tuple[OutOfReach, ...]:
        """Targets that are out of reach."""
        hopeful = self.search.most_hopeful(STANDARD_ERRORS)
        if self.metamodels.shortfall(hopeful, STANDARD_ERRORS)[0] == 0:
            return ()
        return out_of_reach(self.metamodels, hopeful, self._seed, STANDARD_ERRORS)

    @cached_property
    def answer(self) -> Array:
        """The point that is the answer as things are."""
        if self._options.prefer == "accuracy":
            return np.asarray(self.search.closest[0])
        return self.search.fastest(self._options.confidence)

    @cached_property
    def probability(self) -> float:
        """Probability that the answer agrees with all measurements."""
        return float(self.metamodels.probability_all_met(self.answer)[0])

    @cached_property
    def agrees(self) -> bool:
        """Whether it agrees with the demanded probability, and not by luck."""
        confidence = self._options.confidence
        if self.probability < confidence:
            return False
        if self.metamodels.degrees_of_freedom < DEGREES_OF_FREEDOM:
            cautious = self.metamodels.probability_all_met(self.answer, CAUTION)[0]
            if cautious < confidence:
                return False
        return self.probability_without_any_run >= min(CONFIDENCE_WITHOUT_ANY_RUN, confidence)

    @cached_property
    def probability_without_any_run(self) -> float:
        """The same without the run whose absence would lower it most."""
        return float(self.metamodels.probability_all_met_without_each_run(self.answer).min())

    @cached_property
    def is_proven(self) -> bool:
        """Whether runs at the answer can be expected to succeed."""
        return self.feasibility.is_proven(self.answer)

    @cached_property
    def _gain(self) -> tuple[Array, float]:
        if self._options.prefer == "accuracy":
            return self.answer, 0.0
        return self.search.time_step_to_gain(self.answer)

    @property
    def gain_point(self) -> Array:
        """Where a larger time step could still be had."""
        return self._gain[0]

    @property
    def gain(self) -> float:
        """Expected gain of the time step there, as a share of it."""
        return self._gain[1]

    def handicaps(self, points: Array) -> Array:
        """What is added to the misfit of possible answers that compute slowly."""
        if self._options.prefer == "accuracy":
            return np.zeros(len(points))
        return handicaps(self.problem, points)

    def runs_needed(self, confidence: float) -> int:
        """About how many more runs at the answer would decide it."""
        return self.metamodels.runs_needed(self.search.closest[0], confidence)

    def narrowing(self, runs: int) -> float:
        """Share by which so many more runs at the answer would narrow its standard errors."""
        _, variances = self.metamodels.deviations(self.answer)
        return float((1 - 1 / np.sqrt(1 + runs * variances[0] / self.metamodels.scatter)).max())

    def why_undecided(self, confidence: float) -> str:
        """Say how sure the answer is, and what it would take to be surer."""
        inside = f"are all within their tolerances with a probability of {self.probability:.1%}"
        if self.probability >= confidence:
            return (
                f"The expected responses {inside}, but that rests on few runs (without one of "
                f"them it would be {self.probability_without_any_run:.1%}). More runs would tell."
            )
        needed = self.runs_needed(confidence)
        return (
            f"The expected responses {inside}, less than the {confidence:.0%} asked for. It would "
            f"take about {needed:,} more run{'s' * (needed > 1)}: one run scatters by "
            f"{self._scatter()}."
        )

    def _scatter(self) -> str:
        return ", ".join(
            f"{noise:.2g} in {target.name} (tolerance {target.tolerance:.2g})"
            for noise, target in zip(self.metamodels.noise, self.problem.targets, strict=True)
        )

    @property
    def time_step_gained(self) -> float:
        """Share by which the time step of the answer exceeds that of the closest point."""
        both = np.array([self.answer, self.search.closest[0]])
        chosen, closest = np.exp(log_time_steps(self.problem, both))
        return float(chosen / closest - 1)
