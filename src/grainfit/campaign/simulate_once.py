"""Run every test once, outside a calibration."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.keep import Keep
from grainfit.campaign.open_campaign import open_campaign
from grainfit.campaign.work_folder import run_folder
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
    options = CampaignOptions(len(solvers), timeouts or {}, keep=keep)
    with open_campaign(solvers, folder, options) as campaign:
        campaign.start(Proposal(dict(parameters), seed, "design"))
        [evaluation] = campaign.wait()
    folders = {
        test: run_folder(folder.absolute(), identity)
        for test, identity in evaluation.runs.items()
        if solvers[test].uses_folder
    }
    return evaluation, folders
