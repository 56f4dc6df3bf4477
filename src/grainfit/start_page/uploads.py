"""Pictures that are given to the page: kept beside the calibration file, which names them."""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path, PurePath
from typing import Any

from grainfit.errors import InputError
from grainfit.formatting import plain
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
    name : str
        That it has where it was taken from.
    suffix : str
        End of its name, one of `SUFFIXES`.
    content : bytes
        The file.
    """

    key: str
    name: str
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
            return cls(key, plain(name), suffix, base64.b64decode(content, validate=True))
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


def forget(path: Path) -> None:
    """Remove a picture that `Upload.kept` wrote, with its folder where it was the only one."""
    path.unlink(missing_ok=True)
    with suppress(OSError):
        path.parent.rmdir()


def in_given_names(error: InputError, names: Mapping[Path, str]) -> InputError:
    """Return an error that says the names of pictures as they were given, not as they are kept.

    Parameters
    ----------
    error : InputError
        Of a file that names them.
    names : mapping of Path to str
        Names that were given, by the kept pictures.
    """
    given = {
        said: name
        for path, name in names.items()
        for said in (str(path), str(Path(path.parent.name, path.name)), path.name)
    }
    # The longest first: a path ends with a name.
    row = sorted(map(re.escape, given), key=len, reverse=True)
    kept = re.compile(rf"(?<![\w-])(?:{'|'.join(row)})(?!\w)")
    return InputError(
        [
            replace(fault, message=kept.sub(lambda found: given[found[0]], fault.message))
            for fault in error.faults
        ]
    )


def _plain(name: str) -> str:
    return re.sub(r"[^\w-]+", "_", name) or "pictures"
