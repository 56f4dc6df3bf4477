"""Free disk space: remove the files that solvers read and wrote in runs that have ended."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grainfit.campaign.folder_lock import hold
from grainfit.campaign.store.store import STORE_NAME, not_a_work_folder
from grainfit.campaign.work_folder import PARTIAL_SUFFIX, prune_run_folder, read_record
from grainfit.errors import InputError
from grainfit.work_folder import messages
from grainfit.work_folder.disk_use import RUNS


@dataclass(frozen=True)
class Pruned:
    """Outcome of pruning a work folder.

    Parameters
    ----------
    folders, freed : int
        Number of run folders in which something was removed, and bytes that it took.
    faults : tuple of str
        Folders in which not all could be removed, and why.
    """

    folders: int
    freed: int
    faults: tuple[str, ...] = ()


def prune_runs(folder: Path, failed: bool = False) -> Pruned:
    """Keep record, logs and pictures of the finished runs of a work folder, and remove the rest.

    No result is lost. Folders of runs that have not ended, and files that do not belong to a
    run, are kept; links are not followed.

    Parameters
    ----------
    folder : Path
        The work folder.
    failed : bool
        Whether failed runs are pruned too.

    Raises
    ------
    InputError
        It is not a work folder, or the folder of its runs is a link.
    StoreError
        It is in use.
    """
    if not (folder / STORE_NAME).is_file():
        raise InputError(not_a_work_folder(folder))
    if (folder / RUNS).is_symlink():
        raise InputError(messages.RUNS_ARE_A_LINK.fault("", path=str(folder / RUNS)))
    wanted = ("finished", "failed") if failed else ("finished",)
    folders, freed, faults = 0, 0, []
    with hold(folder, is_only=True):
        for path in sorted((folder / RUNS).iterdir()):
            if not _is_run_folder(path, wanted):
                continue
            try:
                found = prune_run_folder(path)
            except OSError as error:
                faults.append(f"{path}: {error.strerror}")
                continue
            folders += found > 0
            freed += found
    return Pruned(folders, freed, tuple(faults))


def _is_run_folder(path: Path, statuses: tuple[str, ...]) -> bool:
    if path.is_symlink() or not path.is_dir() or path.suffix == PARTIAL_SUFFIX:
        return False
    record = read_record(path)
    return record is not None and record.status in statuses
