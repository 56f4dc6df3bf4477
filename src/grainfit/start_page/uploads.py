"""Pictures that are given to the page: kept beside the calibration file, which names them."""

from __future__ import annotations

import base64
import binascii
import re
from dataclasses import dataclass
from itertools import count
from pathlib import Path, PurePath
from typing import Any

from grainfit.photographs.pictures import SUFFIXES

#: Longest request with a picture in it, bytes.
LONGEST = 60_000_000


@dataclass(frozen=True)
class Upload:
    """A picture for a question.

    Parameters
    ----------
    key : str
        Of the question.
    suffix : str
        End of its name, one of `SUFFIXES`.
    content : bytes
        The file.
    """

    key: str
    suffix: str
    content: bytes

    @classmethod
    def from_plain(cls, body: Any) -> Upload:
        """Return the upload of a request.

        Raises
        ------
        ValueError
            It is none; or the file is of no kind that can be read.
        """
        given = body if isinstance(body, dict) else {}
        key, name, content = (given.get(part) for part in ("key", "name", "content"))
        if not (isinstance(key, str) and isinstance(name, str) and isinstance(content, str)):
            raise ValueError("key, name and content are texts")
        suffix = PurePath(name).suffix.lower()
        if suffix not in SUFFIXES:
            raise ValueError(f"{name[:80]} is none of {', '.join(SUFFIXES)}")
        try:
            return cls(key, suffix, base64.b64decode(content, validate=True))
        except binascii.Error:
            raise ValueError("content is no base64") from None

    def kept(self, file: Path) -> Path:
        """Write the picture beside a calibration file, where none is yet; return its path.

        The name is that of the file and of the test: nothing of it comes from the browser.

        Raises
        ------
        OSError
            It cannot be written.
        """
        folder = file.parent / f"{_plain(file.stem)}_photos"
        folder.mkdir(exist_ok=True)
        test = _plain(self.key.partition(".")[0])
        for number in count(1):
            path = folder / f"{test}_{number}{self.suffix}"
            try:
                with path.open("xb") as made:
                    made.write(self.content)
            except FileExistsError:
                continue
            return path
        raise AssertionError("there is no last number")


def _plain(name: str) -> str:
    return re.sub(r"[^\w-]+", "_", name) or "pictures"
