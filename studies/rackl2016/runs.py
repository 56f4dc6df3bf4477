"""Runs of the heap test for given parameters and seeds, several at a time, never made twice."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import recover
from grainfit.evaluation import Evaluation, Proposal
from grainfit.solvers.base import Solver

#: Longest wall time of a run, s; such a run takes about 8.
_TIMEOUT = 1800.0
#: Responses by name; None where the run failed.
Responses = dict[str, float] | None
Order = tuple[Mapping[str, float], int]


class Runs:
    """Runs of a solver in a folder of their own.

    Parameters
    ----------
    solver : Solver
        What is run.
    folder : Path
        Where they are kept.
    workers : int
        How many happen at a time.
    """

    def __init__(self, solver: Solver, folder: Path, workers: int) -> None:
        self._solver = solver
        self._folder = folder.absolute()
        self._workers = workers
        self._stack = ExitStack()

    def __enter__(self) -> Runs:
        with ExitStack() as stack:
            stack.enter_context(hold(self._folder))
            store = RunStore.in_folder(self._folder)
            stack.callback(store.close)
            recover(self._folder, store)
            options = CampaignOptions(self._workers, {"heap": _TIMEOUT}, keep="results")
            self._campaign = Campaign({"heap": self._solver}, store, self._folder, options)
            stack.callback(self._campaign.close)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is not None:
            self._campaign.cancel()
        self._stack.close()

    def make(
        self, orders: Sequence[Order], on_end: Callable[[int, int], None] | None = None
    ) -> list[Responses]:
        """Make the runs that are not known yet; return the responses of all, in order.

        Parameters
        ----------
        orders : sequence of (parameters, seed)
            What is to be run.
        on_end : callable, optional
            Told how many of how many have ended.
        """
        waiting = [Proposal(dict(parameters), seed, "design") for parameters, seed in orders]
        proposals = list(waiting)
        ended: list[Evaluation] = []
        while waiting or self._campaign.has_pending:
            while waiting and self._campaign.has_free_worker:
                self._campaign.start(waiting.pop(0))
            ended += self._campaign.wait()
            if on_end is not None:
                on_end(len(ended), len(orders))
        return [_responses(proposal, ended) for proposal in proposals]


def _responses(proposal: Proposal, ended: Sequence[Evaluation]) -> Responses:
    evaluation = next(e for e in ended if e.proposal == proposal)
    if evaluation.failures:
        return None
    return {name: response.value for name, response in evaluation.responses.items()}


def fresh_seeds(name: str, count: int) -> list[int]:
    """Insertion seeds that belong to a name: the same every time, others for every name."""
    first = 1 + zlib.crc32(name.encode()) % 800_000_000
    return [first + number for number in range(count)]
