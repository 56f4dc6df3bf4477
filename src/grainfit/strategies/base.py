"""What a strategy is: the side of the conversation that asks for DEM runs.

The life of a strategy:

1. It is made with a problem, a seed and a budget. Everything it does follows from these and from
   what it is told, never from a clock: told the same, it asks the same. A calibration that was
   interrupted is therefore simply started again: `Strategy.remember` hands the strategy what it
   asked for before, and the runs that are known already are answered from the store.
   Runs that others made before it are handed over by `Strategy.learn`.
2. `Strategy.ask` is called whenever a worker is free. It returns the next proposal, or None: then
   either a run under way has to come back first, or the strategy has `finished`.
3. `Strategy.tell` hands it what came of a proposal, in any order; failed runs too.
4. Once it has finished, `Strategy.answer` is the parameter set it believes in.
5. The answer is verified with fresh seeds, outside the strategy. If it does not stand that, the
   strategy is told those runs as well, and `Strategy.reconsider` asks whether it can do better: if
   so it is unfinished again and life goes on at 2.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Generator, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from grainfit.campaign.evaluation import Evaluation, Proposal, Stage
from grainfit.problem import Problem
from grainfit.strategies.answer import Answer

#: How often a verification that the answer does not stand may lead back to the search.
RECONSIDERATIONS = 2

_STAGE_CODES: Mapping[Stage, int] = {"design": 0, "optimisation": 1, "verification": 2}


def insertion_seed(seed: int, stage: Stage, number: int) -> int:
    """Insertion seed of the numbered run of a stage: the same for the same calibration seed."""
    state = np.random.SeedSequence([seed, _STAGE_CODES[stage], number]).generate_state(1)
    # Some generators, such as that of LAMMPS, take no seed above 900,000,000.
    return 1 + int(state[0]) % 899_999_999


def without_repeats(evaluations: Iterable[Evaluation]) -> list[Evaluation]:
    """Return evaluations without those of a run that is there already.

    A run that was learnt of and is asked for as well is one run: to count it twice would make its
    scatter look small.
    """
    seen: dict[tuple[float, ...], Evaluation] = {}
    for evaluation in evaluations:
        proposal = evaluation.proposal
        seen.setdefault((*proposal.parameters.values(), proposal.seed), evaluation)
    return list(seen.values())


class Strategy(ABC):
    """Asks for runs until it knows the answer.

    Parameters
    ----------
    problem : Problem
        What is calibrated.
    seed : int
        Decides the design and all insertion seeds.
    max_evaluations : int, optional
        Largest number of proposals.
    """

    #: Name in the calibration file.
    name: str

    def __init__(self, problem: Problem, seed: int, max_evaluations: int | None = None) -> None:
        self.problem = problem
        self.seed = seed
        self.max_evaluations = max_evaluations

    @property
    @abstractmethod
    def design_runs(self) -> int:
        """Proposals of the design, before anything is known."""

    @property
    @abstractmethod
    def finished(self) -> bool:
        """Whether there is nothing more to ask."""

    @property
    @abstractmethod
    def expected_left(self) -> int:
        """About how many proposals are still to come, for the time left."""

    @property
    @abstractmethod
    def notices(self) -> Sequence[str]:
        """What the user should know by now, oldest first."""

    @property
    @abstractmethod
    def definition(self) -> dict[str, Any]:
        """The options that decide what is asked, as plain data."""

    @property
    def searched(self) -> Problem:
        """The problem with the intervals that are searched, should they have been widened."""
        return self.problem

    def remember(self, proposals: Sequence[Proposal]) -> None:
        """Take up the thread of an earlier start.

        Called before the first `ask`, and again before the first one after each verification.
        By default nothing is done, which suits a strategy that asks for the same proposals again
        in whatever order runs come back. Any other one asks for these proposals again, in their
        order, before it goes on.

        Parameters
        ----------
        proposals : sequence of Proposal
            What was asked for then, in order.
        """

    @abstractmethod
    def learn(self, evaluations: Sequence[Evaluation]) -> None:
        """Take note of runs that were there before, made for whatever purpose.

        Called at most once, before anything else. They are no part of the budget.

        Parameters
        ----------
        evaluations : sequence of Evaluation
            Within the intervals of the problem.
        """

    @abstractmethod
    def ask(self) -> Proposal | None:
        """Return the next proposal, or None when there is none at this moment."""

    @abstractmethod
    def tell(self, evaluation: Evaluation) -> None:
        """Take note of what came of a proposal."""

    @abstractmethod
    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        """Return the best parameter set by expected response.

        Parameters
        ----------
        parameters : mapping of str to float, optional
            Those of an earlier start, which are then the answer whatever would be now.
        """

    @abstractmethod
    def reconsider(self, affordable: int | None = None) -> bool:
        """Go on when the answer did not stand its verification; False when it cannot do better.

        Parameters
        ----------
        affordable : int, optional
            Largest number of further proposals that leaves room for another verification.
        """


#: A plan yields batches of proposals and is sent what came of each, in the same order.
Plan = Generator[list[Proposal], list[Evaluation], None]


class BatchStrategy(Strategy):
    """A strategy that is written down as a plan: batches of proposals, one after the other.

    What is known is kept in the order of the plan, whatever the order in which runs come back.
    """

    def __init__(self, problem: Problem, seed: int, max_evaluations: int | None = None) -> None:
        super().__init__(problem, seed, max_evaluations)
        self.evaluations: list[Evaluation] = []
        self._plan: Plan | None = None
        self._batch: list[Proposal] = []
        self._asked: deque[Proposal] = deque()
        self._told: dict[int, Evaluation] = {}
        self._results: list[Evaluation] = []
        self._begun = False

    @abstractmethod
    def plan(self) -> Plan:
        """Make the batches of the calibration."""

    @property
    def finished(self) -> bool:
        """Whether the plan has come to its end."""
        self._advance()
        return self._plan is None

    def ask(self) -> Proposal | None:
        """Return the next proposal of the batch."""
        self._advance()
        return self._asked.popleft() if self._asked else None

    def tell(self, evaluation: Evaluation) -> None:
        """Take note of a member of the batch, or of a run that somebody else asked for."""
        for position, proposal in enumerate(self._batch):
            if position not in self._told and proposal == evaluation.proposal:
                self._told[position] = evaluation
                self._close_batch()
                return
        self.evaluations.append(evaluation)

    def _close_batch(self) -> None:
        """Keep a batch that is complete, whether or not the plan is going to ask what came of it.

        After a restart during the verification it does not, and another plan may follow.
        """
        if self._asked or len(self._told) < len(self._batch):
            return
        self._results = [self._told[position] for position in range(len(self._batch))]
        self.evaluations += self._results
        self._batch, self._told = [], {}

    def learn(self, evaluations: Sequence[Evaluation]) -> None:
        """Fit metamodels to these runs too."""
        self.evaluations += evaluations

    @property
    def known(self) -> list[Evaluation]:
        """All that has come back, that of an unfinished batch last."""
        told = [self._told[position] for position in sorted(self._told)]
        return without_repeats(self.evaluations + told)

    def follow(self, plan: Plan) -> None:
        """Take up another plan after the last one has ended."""
        self._plan, self._begun = plan, True
        self._receive(next(self._plan, None))

    def _advance(self) -> None:
        if not self._begun:
            self.follow(self.plan())
        while self._plan is not None and not self._batch:
            try:
                batch = self._plan.send(self._results)
            except StopIteration:
                batch = None
            self._receive(batch)

    def _receive(self, batch: list[Proposal] | None) -> None:
        if batch is None:
            self._plan = None
        self._batch = batch or []
        self._asked = deque(self._batch)
        self._told, self._results = {}, []
