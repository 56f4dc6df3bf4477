"""Options that are files, folders or programs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grainfit.files import is_file, is_folder
from grainfit.options import messages
from grainfit.options.kinds import Kind, Schema, Text
from grainfit.options.places import Place, show


@dataclass(frozen=True)
class Located(Kind):
    """A file or a folder; a relative path starts at the folder of the calibration file."""

    is_folder: bool = False

    def read(self, value: Any, place: Place) -> Path | None:
        """Read a path to something that exists."""
        text = Text().read(value, place)
        if text is None:
            return None
        path = place.findings.folder / text
        if is_folder(path) if self.is_folder else is_file(path):
            return path
        note_not_there(text, place.findings.folder, place, "folder" if self.is_folder else "file")
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of a path."""
        return Text().schema()


def note_not_there(text: str, folder: Path, place: Place, word: str = "file") -> None:
    """Note that a file or a folder does not exist."""
    place.fault(messages.NOT_THERE, given=show(text), kind=word, folder=folder)


@dataclass(frozen=True)
class Program(Kind):
    """A program: its name, when it is on the search path, or its path."""

    def read(self, value: Any, place: Place) -> str | None:
        """Read a program; a relative path with a slash starts at the calibration file."""
        text = Text().read(value, place)
        if text is None or "/" not in text:
            return text
        path = Located().read(text, place)
        return None if path is None else str(path)

    def schema(self) -> Schema:
        """Return the JSON Schema of a program."""
        return Text().schema()
