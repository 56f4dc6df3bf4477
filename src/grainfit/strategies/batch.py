"""Strategies written down as a plan: batches of proposals, one after the other"""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Generator, Sequence

from grainfit.evaluation import Evaluation, Proposal
from grainfit.problem import Problem
from grainfit.strategies.base import Strategy, without_repeats

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

    def warm_start(self, evaluations: Sequence[Evaluation]) -> None:
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
