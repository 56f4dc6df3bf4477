"""Simulate a set of parameter sets outside a calibration: say the work, run it, keep it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.open_campaign import open_campaign
from grainfit.evaluation import Evaluation, Proposal
from grainfit.formatting import duration
from grainfit.solvers.base import Solver


@dataclass(frozen=True)
class ExpectedWork:
    """Runs that a study still has to make, and how long that takes.

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
        words = f"{self.runs} runs to make, {self.known} known already"
        if self.seconds is None or self.seconds < 1:
            return words
        return f"{words}; about {duration(self.seconds)}"


@dataclass(frozen=True)
class Study:
    """Parameter sets to simulate in one or more tests.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    proposals : sequence of Proposal
        In the order in which they are simulated.
    options : CampaignOptions
        Options for executing runs.
    max_seconds : float, optional
        Wall time after which no more is simulated, s.
    """

    solvers: Mapping[str, Solver]
    proposals: Sequence[Proposal]
    options: CampaignOptions = field(default_factory=CampaignOptions)
    max_seconds: float | None = None


class _TimeIsOverError(Exception):
    """The study has taken as long as it may."""


def simulate_study(
    study: Study,
    folder: Path,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> list[Evaluation]:
    """Simulate all parameter sets of a study, or find their runs in the store of the folder.

    Parameters
    ----------
    study : Study
        Tests and parameter sets.
    folder : Path
        Work folder that keeps the runs; it may be that of a calibration. After Ctrl-C, another call
        continues.
    on_start : callable, optional
        Called with the expected work before the first run.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

    Returns
    -------
    list of Evaluation
        Those that ended within ``max_seconds``.

    Raises
    ------
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used.
    """
    evaluations: list[Evaluation] = []
    with open_campaign(study.solvers, folder, study.options) as campaign:
        if on_start is not None:
            on_start(_expected_work(study, campaign))
        end = None if study.max_seconds is None else time.monotonic() + study.max_seconds
        for proposal in study.proposals:
            campaign.start(proposal)
        try:
            while campaign.has_pending:
                evaluations += campaign.wait(lambda: _stop_after(end))
                if on_progress is not None:
                    on_progress(len(evaluations), len(study.proposals))
        except _TimeIsOverError:
            campaign.cancel()
    return evaluations


def _stop_after(end: float | None) -> None:
    if end is not None and time.monotonic() > end:
        raise _TimeIsOverError


def _expected_work(study: Study, campaign: Campaign) -> ExpectedWork:
    costs: dict[str, float | None] = {}
    known = set()
    for proposal in study.proposals:
        for test, identity in campaign.identities(proposal).items():
            if campaign.is_known(identity, test):
                known.add(identity)
            else:
                cost = study.solvers[test].estimate_cost(proposal.parameters)
                costs[identity] = None if cost is None else cost.wall_seconds
    seconds = [cost for cost in costs.values() if cost is not None]
    is_estimated = len(seconds) == len(costs)
    workers = study.options.workers
    return ExpectedWork(len(costs), len(known), sum(seconds) / workers if is_estimated else None)
