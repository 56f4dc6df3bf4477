"""What was measured on the photographs or videos of a target."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grainfit.calibration_file import messages

#: Key that makes a target, or friction on a wall, one of photographs.
PHOTOS = "photos"


def in_words(value: float, error: float, parts: Mapping[str, float]) -> str:
    """Return an angle and its standard uncertainty, degrees, with the sources of this."""
    sources = ", ".join(f"{name} {part:.2f}" for name, part in parts.items())
    return f"{value:.2f} ± {error:.2f} deg ({sources})"


@dataclass(frozen=True)
class Original:
    """A picture or a video, and what is kept of it.

    Parameters
    ----------
    file : str
        As the calibration file names it.
    sha256 : str
        Hash of the original.
    version : str
        Of the code that measured it.
    name : str
        Of what is kept of it, without endings, or of its folder.
    about : mapping of str to object
        What was measured on it, as plain data.
    """

    file: str
    sha256: str
    version: str
    name: str
    about: Mapping[str, Any]


@dataclass(frozen=True)
class PhotographedTarget:
    """What was measured on the pictures or videos of one target.

    Parameters
    ----------
    key : str
        Dotted key of the target in the file.
    test : int
        Position of its test in the file.
    response : str
        Name of the response.
    originals : tuple of Original
        Pictures and videos, those that were not measured as well.
    result : str
        Value and uncertainty in words.
    found : tuple of str
        What was found on each, in words.
    folder : Path
        Where overlays and what was measured are kept.
    changes : tuple of str
        How the originals differ from those with which the calibration was begun.
    speed : tuple of float, optional
        Rotational speed that videos show, and its standard error, rad/s.
    """

    key: str
    test: int
    response: str
    originals: tuple[Original, ...]
    result: str
    found: tuple[str, ...]
    folder: Path
    changes: tuple[str, ...] = ()
    speed: tuple[float, float] | None = None

    def lines(self) -> Iterator[str]:
        """Yield what was measured, for people."""
        yield self.result
        yield from (f"  {line}" for line in self.found)
        yield "  " + messages.OVERLAYS(folder=self.folder)
