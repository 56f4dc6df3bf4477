"""Room on the disk that is set aside for what has finished when the disk becomes full."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path

RESERVE_NAME = "reserve"
_BYTES = 4_000_000
#: On a disk with less room than this the reserve itself would be what fills it.
_LEAST_FREE_BYTES = 2 * _BYTES


class Reserve:
    """A file of zeros in the work folder, given up when the results of runs need its room.

    Parameters
    ----------
    folder : Path or None
        The work folder; without one there is nothing to keep.
    """

    def __init__(self, folder: Path | None) -> None:
        self._path = None if folder is None else folder / RESERVE_NAME
        if self._path is not None:
            # Without room for it there is none to be had; the first run will say so.
            with suppress(OSError):
                self._set_aside(self._path)

    @staticmethod
    def _set_aside(path: Path) -> None:
        if path.is_file() and path.stat().st_size == _BYTES:
            # Left by a process that was killed, and others would take the room in between.
            return
        path.unlink(missing_ok=True)
        if shutil.disk_usage(path.parent).free < _LEAST_FREE_BYTES:
            return
        try:
            with path.open("wb") as file:
                os.posix_fallocate(file.fileno(), 0, _BYTES)
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def release(self) -> None:
        """Make its room free."""
        if self._path is not None:
            with suppress(OSError):
                self._path.unlink(missing_ok=True)

    def close(self) -> None:
        """Remove the file; it is of no use to a calibration that has ended."""
        self.release()
