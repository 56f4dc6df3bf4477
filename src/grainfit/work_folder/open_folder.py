"""Opening a work folder for reading: its store, and the calibration that was started last.

Imports no NumPy: `grainfit status` starts with it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from grainfit.campaign.folder_lock import is_held
from grainfit.campaign.pending import executing
from grainfit.campaign.store.records import CalibrationRecord, RequestRecord, RunRecord
from grainfit.campaign.store.store import STORE_NAME, UNUSABLE, RunStore, not_a_work_folder
from grainfit.campaign.work_folder import RESULT_NAME
from grainfit.errors import GrainfitError, StoreError
from grainfit.result import Result
from grainfit.verdict.rule import Status
from grainfit.work_folder import messages

if TYPE_CHECKING:
    from grainfit.calibration.live_file import LiveState

_STATES = ("not started", "running", "failed", *get_args(Status))


@dataclass(frozen=True)
class OpenFolder:
    """A work folder and the calibration that was started last in it.

    Parameters
    ----------
    folder : Path
        The work folder.
    store : RunStore
        Its store, for reading; closed at the end of `open_folder`.
    calibration : CalibrationRecord, optional
        The calibration; None if nothing was calibrated yet.
    requests : sequence of RequestRecord
        The parameter sets that it asked for.
    is_held : bool
        Whether a process is at work in the folder.
    holdouts : LiveState, optional
        State of the hold-outs that are simulated after the verdict; None unless they are.
    """

    folder: Path
    store: RunStore
    calibration: CalibrationRecord | None
    requests: Sequence[RequestRecord]
    is_held: bool
    holdouts: LiveState | None = None

    @property
    def is_at_work(self) -> bool:
        """Whether the calibration runs, or its hold-outs are simulated after the verdict."""
        return self.state == "running" or self.holdouts is not None

    @property
    def state(self) -> str:
        """``running``, or how it ended; ``interrupted`` also when its process died."""
        if self.calibration is None:
            return "running" if self.is_held else "not started"
        # Another command may be at work in the folder of a calibration that has ended.
        if self.is_held and self.calibration.status == "running":
            return "running"
        return "interrupted" if self.calibration.status == "running" else self.calibration.status

    @property
    def workers(self) -> int:
        """Runs at a time; 1 where that is not recorded."""
        return int(self.calibration.about.get("workers", 1)) if self.calibration else 1

    @property
    def failure(self) -> str:
        """What stopped it; empty while it is running."""
        if self.calibration is None or self.state == "running":
            return ""
        return str(self.calibration.about.get("failure", ""))

    def running(self, statuses: Iterable[str]) -> int:
        """Return how many of the runs with these statuses execute.

        A run is stored before a worker begins with it: those beyond the workers wait.
        """
        under_way = self.under_way(statuses)
        if self.holdouts is not None:
            return executing(under_way, self.workers, self.holdouts.jobs)
        if self.calibration is None or not under_way:
            return under_way
        # Imported here: the status of a calibration that does not run needs no NumPy.
        from grainfit.calibration.live_file import read_live_state

        live = read_live_state(self.folder, self.calibration.identity)
        return executing(under_way, self.workers, live.jobs if live else ())

    def under_way(self, statuses: Iterable[str]) -> int:
        """Return how many of the runs with these statuses execute, or wait for a worker."""
        if self.holdouts is not None:
            # No parameter set of the search is asked for: its process alone knows its runs.
            return sum(run.state == "submitted" for run in self.holdouts.pending)
        return list(statuses).count("running") if self.state == "running" else 0

    def cut_off(self) -> list[tuple[str, Mapping[str, float]]]:
        """Return test and free parameters of the runs under way when the last start died."""
        if self.is_held:
            return []
        states = self.store.states()
        return [
            (name, request.parameters)
            for request in self.requests
            for name, identity in request.runs.items()
            if states.get(identity) == "running"
        ]

    def warm_start_requests(self) -> list[RequestRecord]:
        """Return the parameter sets of other calibrations that it started from.

        Raises
        ------
        StoreError
            They cannot be read.
        """
        with self.naming():
            known = self.calibration.about.get("learnt", []) if self.calibration else []
            return [RequestRecord.from_row({"position": 0, **row}) for row in known]

    def records_of(self, requests: Sequence[RequestRecord]) -> dict[str, RunRecord]:
        """Return the runs of parameter sets by identity, as far as they are kept."""
        asked = {run for request in requests for run in request.runs.values()}
        return self.store.find_many(asked)

    @contextmanager
    def naming(self) -> Iterator[None]:
        """Name the file of a calibration that cannot be read."""
        try:
            yield
        except (GrainfitError, *UNUSABLE) as error:
            store = str(self.folder / STORE_NAME)
            raise StoreError(messages.UNREADABLE(store=store, why=str(error))) from error

    def read_result(self) -> tuple[Result | None, str]:
        """Read the result of the calibration, or why there is none that can be used.

        A calibration that is running has none. The result of an earlier calibration in the folder
        is not used, and is no fault.
        """
        path = self.folder / RESULT_NAME
        if self.calibration is None or self.state == "running" or not path.exists():
            return None, ""
        try:
            result = Result.from_json(path)
        except StoreError as error:
            return None, str(error)
        return (result if result.identity == self.calibration.identity else None), ""

    def require_result(self) -> Result:
        """Read the result of the calibration.

        Raises
        ------
        StoreError
            There is none, or it cannot be used.
        """
        result, fault = self.read_result()
        if result is not None:
            return result
        if fault:
            raise StoreError(fault)
        raise StoreError(messages.NO_RESULT(folder=str(self.folder), state=self.state))


def _live_holdouts(folder: Path, calibration: CalibrationRecord | None) -> LiveState | None:
    if calibration is None or calibration.status == "running":
        return None
    # Imported here: the status of a calibration that does not run needs no NumPy.
    from grainfit.calibration.live_file import read_live_holdouts

    return read_live_holdouts(folder, calibration.identity)


@contextmanager
def open_folder(folder: Path) -> Iterator[OpenFolder]:
    """Open a work folder without changing it or disturbing a running calibration.

    Raises
    ------
    StoreError
        The folder is not a work folder, or its store cannot be read.
    """
    if not (folder / STORE_NAME).exists():
        raise StoreError(str(not_a_work_folder(folder)))
    with closing(RunStore.read_only(folder)) as store:
        calibration = store.latest_calibration()
        requests = store.requests(calibration.identity) if calibration else []
        held = is_held(folder)
        holdouts = _live_holdouts(folder, calibration) if held else None
        opened = OpenFolder(folder, store, calibration, requests, held, holdouts)
        if calibration is not None and opened.state not in _STATES:
            shown = f"status is {opened.state!r:.60}"
            raise store.damaged(f"table calibrations, row {calibration.identity}: {shown}")
        yield opened
