"""Searches that propose batch by batch."""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Generator

from grainfit.evaluation import Evaluation, Proposal
from grainfit.problem import Problem
from grainfit.strategies.base import Search, Strategy
from grainfit.strategies.distinct_runs import distinct_runs

#: Yields batches of proposals and receives their evaluations, in the same order.
Batches = Generator[list[Proposal], list[Evaluation], None]


class BatchSearch(Search):
    """Search written as a generator of batches: each batch ends before the next begins.

    Evaluations are kept in the order of the proposals, not in the order in which runs end.
    """

    def __init__(
        self, strategy: Strategy, problem: Problem, seed: int, max_evaluations: int | None = None
    ) -> None:
        super().__init__(strategy, problem, seed, max_evaluations)
        self.evaluations: list[Evaluation] = []
        self._batches: Batches | None = None
        self._batch: list[Proposal] = []
        self._asked: deque[Proposal] = deque()
        self._told: dict[int, Evaluation] = {}
        self._results: list[Evaluation] = []
        self._begun = False

    @abstractmethod
    def batches(self) -> Batches:
        """Yield the batches of the search."""

    @property
    def finished(self) -> bool:
        """Whether there is no further batch."""
        self._advance()
        return self._batches is None

    def ask(self) -> Proposal | None:
        """Return the next proposal of the batch."""
        self._advance()
        return self._asked.popleft() if self._asked else None

    def note(self, evaluation: Evaluation) -> None:
        """Record a run of the batch, or a run from elsewhere."""
        for position, proposal in enumerate(self._batch):
            if position not in self._told and proposal == evaluation.proposal:
                self._told[position] = evaluation
                self._close_batch()
                return
        self.evaluations.append(evaluation)

    def _close_batch(self) -> None:
        """Keep a complete batch, even if its generator never receives it.

        After a restart during the verification it does not, and another generator may follow.
        """
        if self._asked or len(self._told) < len(self._batch):
            return
        self._results = [self._told[position] for position in range(len(self._batch))]
        self.evaluations += self._results
        self._batch, self._told = [], {}

    @property
    def known(self) -> list[Evaluation]:
        """All evaluations, those of an unfinished batch last."""
        told = [self._told[position] for position in sorted(self._told)]
        return distinct_runs(self.evaluations + told)

    def follow(self, batches: Batches) -> None:
        """Continue with other batches once the current ones have ended."""
        self._batches, self._begun = batches, True
        self._receive(next(self._batches, None))

    def _advance(self) -> None:
        if not self._begun:
            self.follow(self.batches())
        while self._batches is not None and not self._batch:
            try:
                batch = self._batches.send(self._results)
            except StopIteration:
                batch = None
            self._receive(batch)

    def _receive(self, batch: list[Proposal] | None) -> None:
        if batch is None:
            self._batches = None
        self._batch = batch or []
        self._asked = deque(self._batch)
        self._told, self._results = {}, []
