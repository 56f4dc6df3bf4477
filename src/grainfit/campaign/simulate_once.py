"""Run every test once, outside a calibration."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.keep import Keep
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import hold, recover, run_folder
from grainfit.evaluation import Evaluation, Proposal
from grainfit.solvers.base import Solver


def simulate_once(
    solvers: Mapping[str, Solver],
    parameters: Mapping[str, float],
    seed: int,
    folder: Path,
    timeouts: Mapping[str, float] | None = None,
    keep: Keep = "all",
) -> tuple[Evaluation, dict[str, Path]]:
    """Run every test once, or find the run in the store of the folder.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    parameters : mapping of str to float
        Values of the free parameters.
    seed : int
        Insertion seed.
    folder : Path
        Work folder; it may be that of a calibration.
    timeouts : mapping of str to float, optional
        Longest wall time by name of the test, s.
    keep : {"all", "results"}
        Files of a run folder that are kept.

    Returns
    -------
    evaluation : Evaluation
        Responses and failures.
    folders : dict of str to Path
        Run folder by name of the test, for those solvers that use one.
    """
    folder = folder.absolute()
    for solver in solvers.values():
        solver.check()
    with hold(folder):
        store = RunStore.in_folder(folder)
        recover(folder, store)
        campaign = Campaign(
            solvers, store, folder, CampaignOptions(len(solvers), timeouts or {}, keep=keep)
        )
        try:
            campaign.start(Proposal(dict(parameters), seed, "design"))
            [evaluation] = campaign.wait()
        except KeyboardInterrupt:
            campaign.cancel()
            raise
        finally:
            campaign.close()
            store.close()
    folders = {
        test: run_folder(folder, identity)
        for test, identity in evaluation.runs.items()
        if solvers[test].uses_folder
    }
    return evaluation, folders
