"""Opening a work folder for reading: its store, and the calibration that was started last.

Imports no NumPy: `grainfit status` starts with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from grainfit.campaign.folder_lock import is_held
from grainfit.campaign.store.records import CalibrationRecord, RequestRecord
from grainfit.campaign.store.store import STORE_NAME, RunStore, not_a_work_folder
from grainfit.campaign.work_folder import RESULT_NAME
from grainfit.errors import StoreError
from grainfit.result import Result
from grainfit.verdict.rule import Status

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
    state : str
        ``running``, or how it ended; ``interrupted`` also when its process died.
    """

    folder: Path
    store: RunStore
    calibration: CalibrationRecord | None
    requests: Sequence[RequestRecord]
    state: str

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
        raise StoreError(
            f"there is no result in {str(self.folder)!r}: the calibration is {self.state}. "
            "'grainfit status' shows its progress."
        )


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
        state = _state(calibration, is_held(folder))
        if calibration is not None and state not in _STATES:
            words = f"table calibrations, row {calibration.identity}: status is {state!r:.60}"
            raise store.damaged(words)
        yield OpenFolder(folder, store, calibration, requests, state)


def _state(calibration: CalibrationRecord | None, held: bool) -> str:
    if calibration is None:
        return "running" if held else "not started"
    # Another command may be at work in the folder of a calibration that has ended.
    if held and calibration.status == "running":
        return "running"
    return "interrupted" if calibration.status == "running" else calibration.status
