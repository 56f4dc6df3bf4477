"""Open the campaign of a work folder, outside a calibration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path

from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import recover
from grainfit.solvers.base import Solver


@contextmanager
def open_campaign(
    solvers: Mapping[str, Solver], folder: Path, options: CampaignOptions
) -> Iterator[Campaign]:
    """Open a campaign whose runs are kept in a folder; Ctrl-C ends those that have not finished.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    folder : Path
        Work folder; it may be that of a calibration.
    options : CampaignOptions
        Options for executing runs.

    Raises
    ------
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used.
    """
    folder = folder.absolute()
    for solver in solvers.values():
        solver.check()
    with held_store(folder) as store:
        campaign = Campaign(solvers, store, folder, options)
        try:
            yield campaign
        except KeyboardInterrupt:
            campaign.cancel()
            raise
        finally:
            campaign.close()


@contextmanager
def held_store(folder: Path) -> Iterator[RunStore]:
    """Lock a work folder and open its store; what a killed process left is cleaned up first.

    Parameters
    ----------
    folder : Path
        Work folder, an absolute path.

    Raises
    ------
    StoreError
        The folder cannot be used.
    """
    with hold(folder), closing(RunStore.in_folder(folder)) as store:
        recover(folder, store)
        yield store
