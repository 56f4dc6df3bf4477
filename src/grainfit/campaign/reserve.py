"""Disk space reserved for finished runs in case the disk becomes full."""

from __future__ import annotations

import shutil
from contextlib import suppress
from pathlib import Path

from grainfit import platforms

RESERVE_NAME = "reserve"
_BYTES = 4_000_000
#: On a disk with less free space than this, the reserve itself would fill the disk.
_LEAST_FREE_BYTES = 2 * _BYTES


class Reserve:
    """A file of zeros in the work folder, removed when finished runs need its space.

    Parameters
    ----------
    folder : Path or None
        The work folder; None reserves nothing.
    """

    def __init__(self, folder: Path | None) -> None:
        self._path = None if folder is None else folder / RESERVE_NAME
        if self._path is not None:
            # On a full disk, the first run reports the error.
            with suppress(OSError):
                self._set_aside(self._path)

    @staticmethod
    def _set_aside(path: Path) -> None:
        if path.is_file() and path.stat().st_size == _BYTES:
            # Left by a killed process. If it were removed first, others could take the space.
            return
        path.unlink(missing_ok=True)
        if shutil.disk_usage(path.parent).free < _LEAST_FREE_BYTES:
            return
        try:
            with path.open("wb") as file:
                platforms.set_space_aside(file.fileno(), _BYTES)
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def release(self) -> None:
        """Free the reserved space."""
        if self._path is not None:
            with suppress(OSError):
                self._path.unlink(missing_ok=True)

    def close(self) -> None:
        """Remove the file at the end of a calibration."""
        self.release()
