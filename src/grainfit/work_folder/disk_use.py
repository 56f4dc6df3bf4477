"""Disk space that the runs of a work folder take."""

from __future__ import annotations

import os
import time
from pathlib import Path

#: Folder of the run folders, in a work folder.
RUNS = "runs"


def disk_use(folder: Path, seconds: float) -> int | None:
    """Return the bytes that the run folders of a work folder take; links are not followed.

    Parameters
    ----------
    folder : Path
        The work folder.
    seconds : float
        Time limit; None is returned after it.
    """
    end = time.monotonic() + seconds
    total = 0
    waiting = [str(folder / RUNS)]
    while waiting:
        if time.monotonic() > end:
            return None
        try:
            with os.scandir(waiting.pop()) as entries:
                for entry in entries:
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append(entry.path)
                    else:
                        total += entry.stat(follow_symlinks=False).st_size
        except OSError:
            continue
    return total
