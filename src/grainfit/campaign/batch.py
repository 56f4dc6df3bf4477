"""Simulate a list of parameter sets outside a calibration; finished runs are kept."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.open_campaign import open_campaign
from grainfit.campaign.work_folder import run_folder
from grainfit.evaluation import Evaluation, Proposal, name_of_test
from grainfit.formatting import counted, duration
from grainfit.solvers.base import Solver


@dataclass(frozen=True)
class ExpectedWork:
    """Runs that are still to be made, and how long that takes.

    Parameters
    ----------
    runs, known : int
        Runs to make, and runs that are known already.
    seconds : float, optional
        Expected wall time, s; None if it is not known.
    """

    runs: int
    known: int
    seconds: float | None

    def __str__(self) -> str:
        if not self.runs:
            return "All runs are known already"
        counts = f"{counted(self.runs, 'run')} to make, {self.known} known already"
        if self.seconds is None or self.seconds < 1:
            return counts
        return f"{counts}; about {duration(self.seconds)}"


def simulate_batch(
    solvers: Mapping[str, Solver],
    proposals: Sequence[Proposal],
    folder: Path,
    options: CampaignOptions,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
    max_seconds: float | None = None,
) -> list[Evaluation]:
    """Simulate parameter sets in every test, or find the runs in the store of the folder.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    proposals : sequence of Proposal
        Parameter sets, each with its seed.
    folder : Path
        Work folder that keeps the runs; it may be that of a calibration. After Ctrl-C, another call
        continues.
    options : CampaignOptions
        Options for executing runs.
    on_start : callable, optional
        Called with the expected work before the first run.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.
    max_seconds : float, optional
        Wall time after which no more is simulated, s; finished runs are kept.

    Returns
    -------
    list of Evaluation
        In the order in which they ended.

    Raises
    ------
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used.
    """
    with open_campaign(solvers, folder, options) as campaign:
        if on_start is not None:
            on_start(_expected_work(campaign, proposals, options.workers))
        for proposal in proposals:
            campaign.start(proposal)
        evaluations = []
        for evaluation in _ended(campaign, max_seconds):
            evaluations.append(evaluation)
            if on_progress is not None:
                on_progress(len(evaluations), len(proposals))
    return evaluations


def _ended(campaign: Campaign, max_seconds: float | None) -> Iterator[Evaluation]:
    """Yield what has ended, until nothing is pending or the time is over."""
    end = None if max_seconds is None else time.monotonic() + max_seconds
    try:
        while campaign.has_pending:
            yield from campaign.wait(lambda: _stop_after(end))
            # Short runs leave the wait before it looks at the time.
            _stop_after(end)
    except _TimeIsOverError:
        campaign.cancel()


class _TimeIsOverError(Exception):
    """The batch has taken as long as it may."""


def _stop_after(end: float | None) -> None:
    if end is not None and time.monotonic() > end:
        raise _TimeIsOverError


def _expected_work(campaign: Campaign, proposals: Sequence[Proposal], workers: int) -> ExpectedWork:
    costs: dict[str, float | None] = {}
    known = set()
    for proposal in proposals:
        for run, identity in campaign.identities(proposal).items():
            if campaign.is_known(identity, name_of_test(run)):
                known.add(identity)
            else:
                cost = campaign.solvers[name_of_test(run)].estimate_cost(proposal.parameters)
                costs[identity] = None if cost is None else cost.wall_seconds
    seconds = [cost for cost in costs.values() if cost is not None]
    if len(seconds) < len(costs):
        return ExpectedWork(len(costs), len(known), None)
    # However many workers there are, the longest run takes its time.
    longest = max(seconds, default=0.0)
    return ExpectedWork(len(costs), len(known), max(longest, sum(seconds) / workers))


def run_folders(
    solvers: Mapping[str, Solver], evaluation: Evaluation, folder: Path
) -> dict[str, Path]:
    """Return the run folders of an evaluation by name of the test, for solvers that use one."""
    return {
        run: run_folder(folder.absolute(), identity)
        for run, identity in evaluation.runs.items()
        if solvers[name_of_test(run)].uses_folder
    }
