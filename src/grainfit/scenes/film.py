"""Film of a run: frames of all particles at one interval, through all stages of its scene."""

from __future__ import annotations

import mmap
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from grainfit.errors import NotMeasurableError
from grainfit.files import open_regular
from grainfit.scenes import messages
from grainfit.scenes.scene import Scene

#: File in the folder of a run: a text dump, for OVITO, too.
FILM = "film.dump"
#: Frames that a run of the expected duration keeps, over those that are shown. Nobody knows before
#: how long a bed takes to come to rest: of one that takes a third of the time, enough are left.
_SPARE = 3
_FRAME = re.compile(rb"ITEM: TIMESTEP\n(\d+)\nITEM: NUMBER OF ATOMS\n(\d+)\n")
_COLUMNS = re.compile(rb"ITEM: ATOMS ([^\n]*)\n")
#: Columns of a frame: number, place, radius.
_NEEDED = ("id", "x", "y", "z", "radius")
_GLUED = "v_glued"


def filmed(scene: Scene, frames: int, duration: float) -> Scene:
    """Return a scene whose run keeps frames through all stages; they change nothing of the run.

    Of a run that takes about the duration, s, so many frames are to be shown; see `Film.spread`.
    """
    return replace(scene, film_interval=duration / (_SPARE * frames))


@dataclass(frozen=True)
class FilmFrame:
    """All particles of a run at one time, as the program wrote them: possibly not finite.

    Parameters
    ----------
    step : int
        Time step.
    numbers : ndarray of shape (n,)
        Number of each particle, the same in all frames; ascending.
    positions : ndarray of shape (n, 3)
        Centres, m.
    radii : ndarray of shape (n,)
        m.
    glued : ndarray of shape (n,)
        Number of the glued set of each in the order of the scene, from 1; 0 for loose particles.
    """

    step: int
    numbers: NDArray[np.int64]
    positions: NDArray[np.float64]
    radii: NDArray[np.float64]
    glued: NDArray[np.int64]


class Film:
    """Frames in the folder of a run; of a run that was stopped, those before.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    NotMeasurableError
        It is missing, cannot be read, or has no complete frame.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        #: Time step, beginning and end of each complete frame.
        self._places = _places(path)
        if not self._places:
            raise NotMeasurableError(messages.NO_FRAME(path=path))

    @cached_property
    def steps(self) -> NDArray[np.int64]:
        """Time steps of all frames, ascending."""
        return np.array([step for step, _, _ in self._places], dtype=np.int64)

    def spread(self, most: int) -> list[int]:
        """Return the numbers of so many frames, two or more, from the first to the last, evenly."""
        count = len(self._places)
        if count <= most:
            return list(range(count))
        return [int(number) for number in np.linspace(0, count - 1, most).round()]

    def read(self, numbers: Sequence[int]) -> list[FilmFrame]:
        """Read some of the frames.

        Raises
        ------
        NotMeasurableError
            One is damaged.
        """
        with open_regular(self.path) as file:
            return [self._read(file, *self._places[number]) for number in numbers]

    def _read(self, file: BinaryIO, step: int, start: int, end: int) -> FilmFrame:
        file.seek(start)
        content = file.read(end - start)
        try:
            return _parse(step, content)
        except ValueError as error:
            shown = messages.BAD_FRAME(path=self.path, step=step, error=error)
            raise NotMeasurableError(shown) from None


def _places(path: Path) -> list[tuple[int, int, int]]:
    try:
        with (
            open_regular(path) as file,
            mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as text,
        ):
            found = [(int(m[1]), int(m[2]), m.start()) for m in _FRAME.finditer(text)]
            ends = [start for _, _, start in found[1:]]
            if found:
                ends += _end_of_last(text[found[-1][2] :], *found[-1][1:])
    except (OSError, ValueError) as error:
        raise NotMeasurableError(messages.UNREADABLE(path=path, error=error)) from error
    frames = [(step, start, end) for (step, _, start), end in zip(found, ends, strict=False)]
    # A program that pauses at a step of a frame may write it twice.
    return [one for one, later in pairwise([*frames, (-1, 0, 0)]) if one[0] != later[0]]


def _end_of_last(frame: bytes, count: int, start: int) -> list[int]:
    """Return the end of the last frame in the file; none if the program was stopped in it."""
    header = _COLUMNS.search(frame)
    if header is None:
        return []
    *rows, rest = frame[header.end() :].split(b"\n", count)
    return [start + len(frame) - len(rest)] if len(rows) == count else []


def _parse(step: int, content: bytes) -> FilmFrame:
    header = _COLUMNS.search(content)
    if header is None:
        raise ValueError(messages.NO_COLUMNS())
    columns = header[1].decode("ascii", errors="replace").split()
    wanted = [*_NEEDED, *([_GLUED] if _GLUED in columns else [])]
    missing = [name for name in wanted if name not in columns]
    if missing:
        raise ValueError(messages.NO_COLUMN(names=" and no column ".join(missing)))
    rows = content[header.end() :].decode("ascii", errors="replace").splitlines()
    if not rows:
        nothing = np.empty(0)
        return FilmFrame(
            step, nothing.astype(int), np.empty((0, 3)), nothing, nothing.astype(np.int64)
        )
    table = np.loadtxt(rows, usecols=[columns.index(name) for name in wanted], ndmin=2)
    table = table[np.argsort(table[:, 0], kind="stable")]
    glued = table[:, 5] if _GLUED in columns else np.zeros(len(table))
    return FilmFrame(
        step, table[:, 0].astype(np.int64), table[:, 1:4], table[:, 4], glued.astype(np.int64)
    )
