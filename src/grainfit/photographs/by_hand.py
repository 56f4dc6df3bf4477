"""What was drawn by hand on a picture: kept beside it, and said with every value."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from grainfit.errors import InputError
from grainfit.files import write_atomically
from grainfit.photographs import messages

Points = tuple[tuple[float, float], ...]

#: How many points each has at least and at most.
_COUNTS = {"plate": (3, 3), "axis": (1, 1), "outline": (5, 1000), "corners": (4, 4)}
_WORDS = {
    "plate": "plate line",
    "axis": "axis",
    "outline": "outline",
    "corners": "four points",
}
#: A file is larger than this only if it is another one, bytes.
_LARGEST = 200_000


@dataclass(frozen=True)
class ByHand:
    """Places on a picture that were drawn by hand; empty where it was left to the program.

    Columns and rows, pixels of the whole picture, turned upright.

    Parameters
    ----------
    plate : tuple
        Left end, right end and front of the edge of the plate.
    axis : tuple
        Where the axis of the heap meets its apex.
    outline : tuple
        Corners of the outline of the heap.
    corners : tuple
        Of a level rectangle: a sheet, a tile.
    """

    plate: Points = ()
    axis: Points = ()
    outline: Points = ()
    corners: Points = ()

    @property
    def words(self) -> str:
        """What was drawn, in words; empty if nothing."""
        drawn = [words for name, words in _WORDS.items() if self.given(name)]
        return messages.BY_HAND(drawn=", ".join(drawn)) if drawn else ""

    def given(self, name: str) -> Points:
        """Return the points of a part."""
        found: Points = getattr(self, name)
        return found

    def scaled(self, factor: float) -> ByHand:
        """Return the same places on a picture that is larger by a factor."""
        # Places are those of the middles of pixels.
        moved = {
            field.name: tuple(
                ((x + 0.5) * factor - 0.5, (y + 0.5) * factor - 0.5)
                for x, y in self.given(field.name)
            )
            for field in fields(self)
        }
        return replace(self, **moved)

    def to_plain(self) -> dict[str, list[list[float]]]:
        """Return what was drawn as plain data."""
        return {
            field.name: [[round(x, 2), round(y, 2)] for x, y in self.given(field.name)]
            for field in fields(self)
            if self.given(field.name)
        }

    @staticmethod
    def from_plain(given: object) -> ByHand:
        """Return it from plain data.

        Raises
        ------
        ValueError
            It is of another kind, and why.
        """
        if not isinstance(given, Mapping):
            raise ValueError(messages.NO_PLACES())
        found = {}
        for name, points in given.items():
            low, high = _COUNTS.get(str(name), (0, -1))
            places = tuple(_places(points))
            if not low <= len(places) <= high:
                raise ValueError(messages.OTHER_COUNT(name=name, count=len(places)))
            found[str(name)] = places
        return ByHand(**found)


#: Everything is left to the program.
NOTHING_DRAWN = ByHand()


def _places(points: object) -> Iterator[tuple[float, float]]:
    for point in points if isinstance(points, list | tuple) else [None]:
        pair: Any = point if isinstance(point, list | tuple) and len(point) == 2 else (None, None)
        for value in pair:
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if not (is_number and math.isfinite(value) and abs(value) < 1e6):
                raise ValueError(messages.NO_PLACES())
        yield float(pair[0]), float(pair[1])


def by_hand_path(picture: Path) -> Path:
    """Return the file beside a picture that has what was drawn on it."""
    return picture.with_name(f"{picture.name}.by_hand.json")


def read_by_hand(picture: Path) -> ByHand:
    """Return what was drawn on a picture; nothing if there is no such file.

    Raises
    ------
    InputError
        The file is damaged, or the picture is another one.
    """
    path = by_hand_path(picture)
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        return NOTHING_DRAWN
    except OSError as error:
        raise InputError(messages.DAMAGED.fault("", path=path, reason=error.strerror)) from error
    try:
        if len(text) > _LARGEST:
            raise ValueError(messages.NO_PLACES())
        given = json.loads(text)
        if not isinstance(given, dict):
            raise ValueError(messages.NO_PLACES())
        digest = given.pop("picture_sha256", None)
        found = ByHand.from_plain(given)
    except (ValueError, RecursionError) as error:
        raise InputError(messages.DAMAGED.fault("", path=path, reason=error)) from error
    if digest != _digest(picture):
        raise InputError(messages.OTHER_PICTURE.fault("", path=path, picture=picture.name))
    return found


def write_by_hand(picture: Path, drawn: ByHand) -> Path:
    """Keep what was drawn beside a picture, and return the file; remove it if it is nothing."""
    path = by_hand_path(picture)
    if drawn == NOTHING_DRAWN:
        path.unlink(missing_ok=True)
    else:
        plain = {"picture_sha256": _digest(picture), **drawn.to_plain()}
        write_atomically(path, json.dumps(plain, indent=1) + "\n")
    return path


def _digest(picture: Path) -> str:
    return hashlib.sha256(picture.read_bytes()).hexdigest()
