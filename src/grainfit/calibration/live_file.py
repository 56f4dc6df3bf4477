"""Live state of a running calibration, in a file of its work folder for whoever watches it.

The store has every run and every request. The file adds what only the process knows: the estimate
of the time left, the runs that wait, and the jobs of a cluster. It is removed at the end; a killed
process leaves it, and it counts only while its process holds the folder.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from grainfit.calibration.progress import Progress
from grainfit.calibration.repetitions import Repetitions
from grainfit.campaign.folder_lock import Signature, holder
from grainfit.campaign.pending import ClusterJob, PendingRun
from grainfit.campaign.store.store import UNUSABLE
from grainfit.files import read_within, write_atomically
from grainfit.plain_data import parse_json, read_plain
from grainfit.result.holdout import HOLDOUT_STAGE

LIVE_NAME = "live.json"
_INTERVAL_SECONDS = 1.0
_LARGEST = 20_000_000


@dataclass(frozen=True)
class LiveState:
    """State of a running calibration beyond what the store has.

    Parameters
    ----------
    stage : str
        ``design``, ``optimisation``, ``verification`` or ``hold-out``.
    done, failed : int
        Finished and failed runs.
    left : pair of int
        Range of the number of remaining runs.
    seconds_left : pair of float, optional
        Range of the remaining time when it was estimated, s.
    estimated, started : float
        Time of that estimate, and of the start, seconds since the epoch.
    notices : tuple of str
        Notices for the user.
    pending : tuple of PendingRun
        Runs that have not ended.
    jobs : tuple of ClusterJob
        Jobs of a cluster.
    stale : mapping of str to tuple of str
        Responses that verify nothing by the seed of their proposal, see `Repetitions`.
    deterministic : tuple of str
        Tests whose model gives the same for every seed, see `Repetitions`.
    """

    stage: str
    done: int
    failed: int
    left: tuple[int, int]
    seconds_left: tuple[float, float] | None
    estimated: float
    started: float
    notices: tuple[str, ...]
    pending: tuple[PendingRun, ...]
    jobs: tuple[ClusterJob, ...]
    stale: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    deterministic: tuple[str, ...] = ()

    @property
    def repetitions(self) -> Repetitions:
        """Runs with fresh seeds that are no evidence of their own."""
        stale = {int(seed): names for seed, names in self.stale.items()}
        return Repetitions(stale, self.deterministic)


class LiveFile:
    """The live file of this process in a work folder, which it has locked.

    Parameters
    ----------
    folder : Path
        The work folder.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / LIVE_NAME
        self._process = asdict(Signature.own())
        self._started = time.time()
        self._estimate: tuple[object, float] = (None, 0.0)
        self._written: dict[str, Any] = {}
        self._looked = float("-inf")

    def __enter__(self) -> LiveFile:
        return self

    def __exit__(self, *_raised: object) -> None:
        with suppress(OSError):
            self._path.unlink(missing_ok=True)

    @property
    def is_due(self) -> bool:
        """Whether the last update is long enough ago."""
        return time.monotonic() - self._looked >= _INTERVAL_SECONDS

    def update(
        self, calibration: str, progress: Progress, repetitions: Repetitions | None = None
    ) -> None:
        """Write the state, if it has changed. It is only for display: a full disk is no fault.

        Parameters
        ----------
        calibration : str
            Identity of the calibration.
        progress : Progress
            Its progress.
        repetitions : Repetitions, optional
            Its runs with fresh seeds that are no evidence of their own.
        """
        self._looked = time.monotonic()
        estimated = (progress.done, progress.to_come, progress.seconds_left)
        if estimated != self._estimate[0]:
            self._estimate = (estimated, time.time())
        content = {
            "process": self._process,
            "calibration": calibration,
            "stage": progress.stage,
            "done": progress.done,
            "failed": progress.failed,
            "left": progress.to_come.range,
            "seconds_left": progress.seconds_left_range,
            "estimated": self._estimate[1],
            "started": self._started,
            "notices": progress.notices,
            "pending": [asdict(run) for run in progress.pending],
            "jobs": [asdict(job) for job in progress.jobs],
            **asdict(repetitions or Repetitions()),
        }
        if content == self._written:
            return
        with suppress(OSError):
            write_atomically(self._path, json.dumps(content))
            self._written = content


def read_live_state(folder: Path, calibration: str) -> LiveState | None:
    """Read the live state of a calibration that is running.

    Returns
    -------
    LiveState or None
        None when the file is missing or damaged, or was left by a process that has ended.
    """
    try:
        found = parse_json(read_within(folder / LIVE_NAME, _LARGEST))
        if found["calibration"] != calibration or Signature(**found["process"]) != holder(folder):
            return None
        state: LiveState = read_plain(LiveState, found)
        return state
    except (OSError, *UNUSABLE):
        return None


def read_live_holdouts(folder: Path, calibration: str) -> LiveState | None:
    """Read the live state of the hold-outs of a calibration that has ended.

    Returns
    -------
    LiveState or None
        None unless its process simulates them now.
    """
    live = read_live_state(folder, calibration)
    return live if live is not None and live.stage == HOLDOUT_STAGE else None
