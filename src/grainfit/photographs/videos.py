"""Frames of videos, at equal intervals, in their working size."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from grainfit.errors import InputError
from grainfit.photographs import messages
from grainfit.photographs.drum_circle import Colours
from grainfit.photographs.pictures import opencv

#: Formats, by the ends of their names.
SUFFIXES = (".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm")
#: Frames are worked on in this length of their longer side, pixels.
_LENGTH = 800
#: Most frames that are looked at.
_MOST = 600
#: Frame rate of a video that does not tell it, 1/s.
_USUAL_RATE = 30.0


def is_video(path: Path) -> bool:
    """Return whether a file is a video, by the end of its name."""
    return path.suffix.lower() in SUFFIXES


class Video:
    """A video.

    Parameters
    ----------
    path : Path
        Its file; it is turned upright as its data say.

    Raises
    ------
    InputError
        It cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.exists():
            raise InputError(messages.NO_FILE.fault("", path=path))
        reader = opencv().VideoCapture(str(path))
        self._count = int(reader.get(opencv().CAP_PROP_FRAME_COUNT))
        rate = float(reader.get(opencv().CAP_PROP_FPS))
        opened = reader.isOpened() and self._count > 0
        reader.release()
        if not opened:
            raise InputError(messages.NO_VIDEO.fault("", path=path))
        self._every = max(1, -(-self._count // _MOST))
        #: Time between two frames that are read, s.
        self.interval = self._every / (rate if 0.1 < rate < 1e4 else _USUAL_RATE)

    def __len__(self) -> int:
        return -(-self._count // self._every)

    def frames(self) -> Iterator[Colours]:
        """Read frames at equal intervals."""
        reader = opencv().VideoCapture(str(self.path))
        try:
            number = 0
            while reader.grab():
                if number % self._every == 0:
                    read, colours = reader.retrieve()
                    if not read:
                        return
                    yield _reduced(colours)
                number += 1
        finally:
            reader.release()

    def some(self, count: int) -> list[Colours]:
        """Read so many frames, from the first to the last."""
        wanted = set(np.unique(np.linspace(0, len(self) - 1, count).astype(int)).tolist())
        return [frame for number, frame in enumerate(self.frames()) if number in wanted]


def _reduced(colours: Colours) -> Colours:
    cv2 = opencv()
    rows, columns = colours.shape[:2]
    factor = _LENGTH / max(rows, columns)
    if factor < 1:
        size = (round(columns * factor), round(rows * factor))
        colours = cv2.resize(colours, size, interpolation=cv2.INTER_AREA)
    found: Colours = cv2.cvtColor(colours, cv2.COLOR_BGR2RGB)
    return found
