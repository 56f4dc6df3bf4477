"""Search of the sequential strategy: every run goes where it is expected to improve the answer.

After a small Latin hypercube, metamodels of all responses are fitted again whenever a run has
ended, and `next_run` chooses the next run with the pending ones taken into account. The search ends
when `stopping` finds it decided: the answer agrees with all measurements with the demanded
probability, or no parameter set can.

The next proposal depends only on the known and the pending runs, not on their order. So an
interrupted calibration needs only its history to continue.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.evaluation import Evaluation, Proposal, Stage
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.problem import Problem
from grainfit.strategies.answer import Answer, make_answer
from grainfit.strategies.base import RESUMPTIONS, Search
from grainfit.strategies.budget import design_size
from grainfit.strategies.distinct_runs import distinct_runs
from grainfit.strategies.out_of_reach import widened, widenings
from grainfit.strategies.seeds import insertion_seed
from grainfit.strategies.sequential.belief import LIKELY, Belief
from grainfit.strategies.sequential.next_run import (
    next_point,
    pending_is_enough,
    space_filling_point,
)
from grainfit.strategies.sequential.options import SequentialOptions
from grainfit.strategies.sequential.stopping import StoppingRule

Array = NDArray[np.float64]

#: Runs of the design per coefficient of a linear trend: 50 % more than a fit of the trend needs.
DESIGN_RUNS = 1.5
#: Most runs after the design per free parameter, if the user gives no budget.
RUNS_PER_PARAMETER = 20
#: Runs after the design before a target can be called out of reach.
_RUNS_TO_CONFIRM = 2
_TRIES_OF_A_MACHINE = 3
#: Runs that usually follow the design where the scatter is small, verification included.
_USUAL_AFTER_DESIGN = 5
#: The same before the scatter is known.
_USUAL_BEFORE_ANY_RUN = 7
_MOST_WIDENINGS = 4


class SequentialSearch(Search):
    """Search that proposes one run at a time.

    Parameters
    ----------
    strategy : SequentialOptions
        Size of the design, preference, and demanded probability.
    problem : Problem
        Free parameters and targets.
    seed : int
        Decides the design and all insertion seeds.
    max_evaluations : int, optional
        Largest number of proposals; by default the design and 20 per free parameter.

    Raises
    ------
    InputError
        The design is too small to fit metamodels, or larger than the budget.
    """

    learns_beyond_intervals = True
    verify_from = LIKELY

    def __init__(
        self,
        strategy: SequentialOptions,
        problem: Problem,
        seed: int,
        max_evaluations: int | None = None,
    ) -> None:
        super().__init__(strategy, problem, seed, max_evaluations)
        self._options = strategy
        usual = max(problem.dimension + 3, math.ceil(DESIGN_RUNS * (problem.dimension + 1)))
        self._whole_design = self._design_size = design_size(
            problem.dimension, strategy.design_runs, usual, max_evaluations
        )
        self._usual_design = strategy.design_runs or usual
        self._allowed = max_evaluations or (
            self._design_size + RUNS_PER_PARAMETER * problem.dimension
        )
        self._asked: list[Proposal] = []
        self._indices: dict[int, int] = {}
        self._told: dict[int, Evaluation] = {}
        self._others: list[Evaluation] = []
        self._to_repeat: deque[Proposal] = deque()
        self._resumptions = 0
        self._latest: tuple[tuple[int, int], Belief] | None = None
        self._notices: list[str] = []

    @property
    def definition(self) -> dict[str, Any]:
        """All options; the budget only limits the number of proposals."""
        return asdict(self._options) | {"design_runs": self._usual_design}

    @property
    def design_runs(self) -> int:
        """Size of the Latin hypercube."""
        return self._design_size

    @property
    def confidence(self) -> float:
        """Demanded probability that every target is met, an option."""
        return self._options.confidence

    @property
    def notices(self) -> Sequence[str]:
        """Widened intervals, and why the search has ended."""
        return tuple(self._notices)

    @property
    def current_problem(self) -> Problem:
        """Problem with the intervals searched now."""
        return self.problem if self._belief is None else self._belief.problem

    @property
    def known(self) -> list[Evaluation]:
        """All evaluations, in the order of their proposals, those of a warm start last."""
        told = [self._told[index] for index in sorted(self._told)]
        return distinct_runs(told + self._others)

    @property
    def finished(self) -> bool:
        """Whether the search is decided, or the budget is used."""
        if self._to_repeat or not self._design_is_told:
            return False
        used = self._budget_is_used and not self._pending
        if used or (self._belief is not None and self._rule.is_decided(self._belief)):
            if self._belief is not None:
                self._note(self._rule.final_notices(self._belief))
            return True
        return False

    @property
    def expected_left(self) -> int:
        """Pending runs, or those that the answer still needs, with those of its verification."""
        done = len(self._told) + len(self._others)
        if not self._design_is_told or self._belief is None:
            usual = self._design_size + _USUAL_BEFORE_ANY_RUN
            return max(self._pending, min(self._allowed, usual) - len(self._told))
        belief = self._belief
        left = self._allowed - len(self._told)
        if belief.seems_missed:
            # Either it is soon established, or the budget is used.
            return max(self._pending, left // 2)
        usual = max(self._design_size + _USUAL_AFTER_DESIGN, belief.usual_runs) - done
        needed = min(belief.runs_needed(self.confidence_to_stop), usual)
        if not belief.is_likely:
            needed = max(needed, _USUAL_AFTER_DESIGN)
        return max(self._pending, min(left, needed))

    def warm_start(self, evaluations: Sequence[Evaluation]) -> None:
        """Use runs of other calibrations instead of a part of the design."""
        self._others += evaluations
        names = {target.name for target in self.problem.targets}
        places = {
            tuple(evaluation.proposal.parameters.values())
            for evaluation in evaluations
            if names <= evaluation.responses.keys()
        }
        self._design_size = max(0, self._whole_design - len(places))

    def replay(self, proposals: Sequence[Proposal]) -> None:
        """Repeat these proposals before any new one."""
        self._to_repeat.extend(proposals)

    def ask(self) -> Proposal | None:
        """Return the next proposal, or None when a pending run has to be told first."""
        if self._to_repeat:
            return self._note_asked(self._to_repeat.popleft())
        if self._budget_is_used:
            return None
        if len(self._asked) < self._design_size:
            return self._propose(self.problem.from_unit(self._design[len(self._asked)]), "design")
        if again := self._failed_by_machine():
            return self._propose(again.parameters, again.stage)
        if self.finished:
            return None
        if self._belief is None:
            return None if self._pending else self._propose_space_filling()
        return self._propose_most_useful(self._belief)

    def note(self, evaluation: Evaluation) -> None:
        """Record a run, proposed by this search or not."""
        index = self._indices.get(evaluation.proposal.seed)
        if index is not None and self._asked[index] == evaluation.proposal:
            self._told[index] = evaluation
        else:
            self._others.append(evaluation)

    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        """Return the best parameter set by expected responses."""
        belief = self._belief
        if belief is None:
            # Says what is missing.
            Metamodels.fit(self.problem, self.known)
            raise AssertionError("metamodels that can be fitted make a belief")
        misses = belief.misses if self._rule.is_out_of_reach(belief) else ()
        chosen = parameters or belief.problem.from_unit(belief.answer)
        closest = belief.answers.closest[0]
        return make_answer(
            belief.metamodels,
            chosen,
            misses,
            closest,
            spread=False,
            confidence=self.confidence_to_stop,
        )

    def resume_after_verification(self, affordable: int | None = None) -> bool:
        """Continue with the verification runs added, if doubt and budget are left."""
        if affordable is not None:
            self._allowed = min(self._allowed, len(self._asked) + max(0, affordable))
        possible = (
            self._belief is not None
            and (affordable is None or affordable >= 0)
            and not self._rule.is_out_of_reach(self._belief)
            and self._resumptions < RESUMPTIONS
        )
        self._resumptions += possible
        return possible

    # Known runs ------------------------------------------------------------------------------

    @cached_property
    def _design(self) -> Array:
        return maximin_latin_hypercube(self._design_size, self.problem.dimension, self.seed)

    @property
    def _pending(self) -> int:
        return len(self._asked) - len(self._told)

    @property
    def _budget_is_used(self) -> bool:
        return len(self._asked) >= self._allowed

    @property
    def _design_is_told(self) -> bool:
        return all(index in self._told for index in range(self._design_size))

    @property
    def _rule(self) -> StoppingRule:
        has_budget = self.max_evaluations is not None
        return StoppingRule(
            confidence=self.confidence_to_stop,
            demanded=self.confidence,
            is_confirmed=len(self._told) >= self._design_size + _RUNS_TO_CONFIRM,
            runs_left=None if has_budget else self._allowed - len(self._told),
        )

    @property
    def _belief(self) -> Belief | None:
        """Belief from the runs so far; None when they are too few for metamodels."""
        state = (len(self._told), len(self._others))
        if self._latest is None or self._latest[0] != state:
            known = self.known
            if not can_be_fitted(self.problem, known):
                return None
            self._latest = (state, self._form_belief(known))
        return self._latest[1]

    def _form_belief(self, known: Sequence[Evaluation]) -> Belief:
        problem, belief = self.problem, self._belief_in(self.problem, known)
        for _ in range(_MOST_WIDENINGS if self._options.extend_intervals else 0):
            if not self._rule.is_out_of_reach(belief):
                break
            wider = widened(problem, belief.misses)
            if wider == problem:
                break
            problem, belief = wider, self._belief_in(wider, known)
        self._note(widenings(self.problem, problem))
        return belief

    def _belief_in(self, problem: Problem, known: Sequence[Evaluation]) -> Belief:
        return Belief(problem, known, self.seed, self._options, self.confidence_to_stop)

    def _note(self, notices: Iterable[str]) -> None:
        self._notices += [notice for notice in notices if notice not in self._notices]

    # Proposals -------------------------------------------------------------------------------

    def _propose(self, parameters: Mapping[str, float], stage: Stage) -> Proposal:
        number = len(self._asked) + 1
        seed = insertion_seed(self.seed, stage, number)
        return self._note_asked(Proposal(dict(parameters), seed, stage))

    def _note_asked(self, proposal: Proposal) -> Proposal:
        self._indices[proposal.seed] = len(self._asked)
        self._asked.append(proposal)
        return proposal

    def _failed_by_machine(self) -> Proposal | None:
        """Proposal to try again: its run failed by the machine, not by its parameters."""
        for index in sorted(self._told):
            proposal = self._told[index].proposal
            if not self._told[index].failed_by_machine:
                continue
            tries = [i for i, p in enumerate(self._asked) if p.parameters == proposal.parameters]
            if tries[-1] == index and len(tries) < _TRIES_OF_A_MACHINE:
                return proposal
        return None

    def _random(self) -> np.random.Generator:
        return np.random.default_rng([self.seed, len(self._asked)])

    def _propose_space_filling(self) -> Proposal:
        tried = np.array([self.problem.to_unit(p.parameters) for p in self._asked])
        point = space_filling_point(self.problem, self.known, tried, self._random())
        return self._propose(self.problem.from_unit(point), "optimisation")

    def _propose_most_useful(self, belief: Belief) -> Proposal | None:
        pending = self._pending_points(belief.problem)
        conditioned = belief.metamodels.condition_on_pending(pending)
        confidence = self.confidence_to_stop
        if len(pending) and pending_is_enough(belief, conditioned, len(pending), confidence):
            return None
        point = next_point(belief, conditioned, self._random())
        return self._propose(belief.problem.from_unit(point), "optimisation")

    def _pending_points(self, problem: Problem) -> Array:
        points = [
            problem.to_unit(proposal.parameters)
            for index, proposal in enumerate(self._asked)
            if index not in self._told
        ]
        return np.array(points).reshape(-1, problem.dimension)
