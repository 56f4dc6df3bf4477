"""Places in the data that is being read, and the faults found there."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from datetime import date, time
from pathlib import Path
from typing import Any, Protocol

from grainfit.errors import Fault, InputError
from grainfit.messages import Message

#: Keys and list positions that lead from the top of the file to a value.
KeyPath = tuple[str | int, ...]

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]{1,64}")


@dataclass(frozen=True)
class FileFault(Fault):
    """A fault of a calibration file.

    Parameters
    ----------
    key, message, remedy : str
        As in `Fault`.
    line : int, optional
        Line of the key in the file, counted from 1; of its table when it is missing.
    """

    line: int | None = None

    def __str__(self) -> str:
        return super().__str__() if self.line is None else f"line {self.line}, {super().__str__()}"


@dataclass
class Findings:
    """All faults found in one file.

    Parameters
    ----------
    folder : Path
        Where the file is: its relative paths start there.
    lines : mapping of path to int
        Line of each key, as far as known.
    faults : list of FileFault
        The faults.
    tables : list of str
        How each table that it names was understood.
    work_folder : callable
        Returns the work folder, where what is measured while the file is read is kept.
    photographs : list
        What was measured on the photographs of each target.
    """

    folder: Path = field(default_factory=Path)
    lines: Mapping[KeyPath, int] = field(default_factory=dict)
    faults: list[FileFault] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)
    work_folder: Callable[[], Path] = Path
    photographs: list[Any] = field(default_factory=list)

    def line_of(self, path: KeyPath) -> int | None:
        """Line of a key, or of the nearest table around it that has one."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.lines:
                return self.lines[path[:length]]
        return None


class Refusal(Protocol):
    """What is wrong with a value, and what to do: a `Fault`, or the error of a unit."""

    @property
    def message(self) -> str:
        """Description of the fault."""

    @property
    def remedy(self) -> str:
        """Suggestion how to correct it."""


@dataclass(frozen=True)
class Place:
    """A spot in the file that is being read."""

    findings: Findings
    path: KeyPath = ()

    def at(self, *parts: str | int) -> Place:
        """Return the place of a key, or of a position in a list, below this one."""
        return Place(self.findings, self.path + parts)

    @property
    def key(self) -> str:
        """The last key on the way here."""
        return next((part for part in reversed(self.path) if isinstance(part, str)), "")

    def fault(self, message: Message, /, *, near: KeyPath = (), **values: Any) -> None:
        """Note that something is wrong here.

        Parameters
        ----------
        message : Message
            Of the catalogue of its room.
        near : path, optional
            Whose line it has when there is nothing of this place in the file.
        **values : object
            Fields of the message.
        """
        self.refuse(message.fault("", **values), near=near)

    def refuse(self, fault: Refusal, *, near: KeyPath = ()) -> None:
        """Note a fault of this place, whatever its own key."""
        line = self.findings.line_of(self.path) or self.findings.line_of(near)
        self.findings.faults.append(FileFault(dotted(self.path), fault.message, fault.remedy, line))

    def note(self, error: InputError, keys: Collection[str], otherwise: Place) -> None:
        """Note the faults that the constructor of a value found.

        Parameters
        ----------
        error : InputError
            Its faults name arguments of the constructor.
        keys : collection of str
            Keys that are given here; an argument of the same name has its fault there.
        otherwise : Place
            Place of all other faults.
        """
        for fault in error.faults:
            key = fault.key.rpartition(".")[2]
            at = self.at(key) if key in keys else otherwise
            at.refuse(fault)


def dotted(path: KeyPath) -> str:
    """Write a path in dotted form: ``test[0].targets.bulk_density.value``."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + (part if _BARE_KEY.fullmatch(part) else show(part))
    return text


def show(value: object) -> str:
    """Write any value in one short line that is safe to print."""
    if isinstance(value, bool):
        return str(value).lower()
    printer = reprlib.Repr()
    printer.maxstring = 60
    printer.maxlevel = 2
    return " ".join(printer.repr(value).split())


def kind_of(value: object) -> str:
    """Return the kind of a value of a file, or of an argument, in words."""
    words: tuple[tuple[type | tuple[type, ...], str], ...] = (
        (bool, "a truth value"),
        ((int, float), "a number"),
        (str, "a text"),
        (list, "a list"),
        (dict, "a table"),
        ((date, time), "a date or time"),
    )
    other = "nothing" if value is None else f"an object of the type {type(value).__name__}"
    return next((text for types, text in words if isinstance(value, types)), other)
