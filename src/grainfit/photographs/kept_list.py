"""The list of the pictures of a calibration, in its work folder, for a report at any later time."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from grainfit.files import LARGEST_RESULT, read_within, write_atomically
from grainfit.photographs.kept import FOLDER, KeptPicture

#: The list, beside what was measured on each picture.
LIST_NAME = "pictures.json"

StateOfOriginal = Literal["the same", "changed", "gone", "unknown"]


@dataclass(frozen=True)
class KeptTarget:
    """Pictures of one target.

    Parameters
    ----------
    response : str
        Name in the problem.
    result : str
        Value and uncertainty in words.
    heaps : sequence of sequence of KeptPicture
        Measured pictures of each heap; of a drum, each video, or its stills.
    refused : sequence of KeptPicture
        Pictures that were not measured.
    hashes : mapping of str to str
        SHA-256 of every original by its file: stills of a drum are measured together.
    """

    response: str
    result: str
    heaps: Sequence[Sequence[KeptPicture]]
    refused: Sequence[KeptPicture]
    hashes: Mapping[str, str]


@dataclass(frozen=True)
class KeptPictures:
    """All pictures of a calibration.

    Parameters
    ----------
    folder : Path
        Where copies and overlays are.
    originals : Path or None
        Folder of the calibration file, from which the names of the pictures start.
    targets : sequence of KeptTarget
        The targets that they tell.
    """

    folder: Path
    originals: Path | None
    targets: Sequence[KeptTarget]

    def copy_of(self, picture: KeptPicture) -> Path:
        """Return the path of the upright copy of a picture."""
        return self.folder / f"{picture.name}.jpg"

    def state_of(self, file: str, sha256: str) -> StateOfOriginal:
        """Return whether an original is still what was measured."""
        if self.originals is None:
            return "unknown"
        path = self.originals / file
        try:
            found = path.stat()
        except OSError:
            return "gone"
        digest = _hash_once(path, found.st_size, found.st_mtime_ns)
        if not digest:
            return "gone"
        return "the same" if digest == sha256 else "changed"


def hash_of(path: Path) -> str:
    """Return the SHA-256 of a file; empty if it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


@lru_cache
def _hash_once(path: Path, _size: int, _changed: int) -> str:
    """Return the hash of a file that is asked for often, as long as it is not written."""
    return hash_of(path)


def write_list(work_folder: Path, originals: Path, targets: Sequence[Mapping[str, Any]]) -> None:
    """Write the list into a work folder.

    Parameters
    ----------
    work_folder : Path
        Its folder `FOLDER` exists.
    originals : Path
        Folder of the calibration file.
    targets : sequence of mapping
        ``key``, ``response``, ``result`` and ``pictures`` of each, as JSON.
    """
    folder = work_folder / FOLDER
    try:
        # Both folders may be moved together.
        place = os.path.relpath(originals.resolve(), folder.resolve())
    except ValueError:
        place = str(originals.resolve())
    text = json.dumps({"originals": place, "targets": targets})
    write_atomically(folder / LIST_NAME, text)


def read_list(folder: Path) -> dict[str, Any]:
    """Return the list in the folder of the kept pictures; without targets if it cannot be read."""
    try:
        found = json.loads(read_within(folder / LIST_NAME, LARGEST_RESULT))
        return found if isinstance(found["targets"], list) else {"targets": []}
    except (OSError, ValueError, KeyError, TypeError):
        return {"targets": []}


def kept_pictures(work_folder: Path) -> KeptPictures | None:
    """Return the pictures with which the calibration of a work folder was begun; None without any.

    Of a list that is damaged, what can be read is returned.
    """
    folder = work_folder / FOLDER
    found = read_list(folder)
    targets = [one for one in map(_target, found["targets"]) if one is not None]
    if not targets:
        return None
    place = found.get("originals")
    return KeptPictures(folder, folder / place if isinstance(place, str) else None, targets)


def _target(data: Any) -> KeptTarget | None:
    heaps: dict[int, list[KeptPicture]] = {}
    refused = []
    hashes = {}
    try:
        for one in data["pictures"]:
            hashes[str(one["file"])] = str(one["sha256"])
            if "heap" not in one:
                continue
            number = int(one["heap"])
            picture = KeptPicture.from_plain(one)
            if picture.refused:
                refused.append(picture)
            else:
                heaps.setdefault(number, []).append(picture)
        response, result = str(data["response"]), str(data["result"])
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
    return KeptTarget(response, result, list(heaps.values()), refused, hashes)
