"""Instruments by name: dimensions of known apparatus, as options of the tests that they do.

Each is a TOML file of the folder ``instruments``. Its ``type`` is a bulk test; below ``options``
is a table for each dimension, with its ``value``, as a calibration file takes it, and its
``source``; ``prints`` lists what a report of the instrument has, and the response that it is.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from grainfit.bulk_tests import messages
from grainfit.errors import InputError
from grainfit.options.kinds import suggest
from grainfit.tables import TextTable

_FOLDER = Path(__file__).with_name("instruments")


@dataclass(frozen=True)
class Dimension:
    """Value of an option that an instrument decides.

    Parameters
    ----------
    value : object
        As in a calibration file.
    source : str
        A public one: a standard, a publication, or an address.
    unless : str
        Option with another value of which this one means nothing; empty if there is none.
    """

    value: Any
    source: str
    unless: str = ""

    @property
    def toml(self) -> str:
        """The value as TOML: a text, a number, or true or false."""
        return json.dumps(self.value)


@dataclass(frozen=True)
class Printed:
    """Quantity in the report of an instrument.

    Parameters
    ----------
    name : str
        As the report calls it.
    response : str
        Response that it is a target for; empty if none is.
    remark : str
        How to enter it, or why there is no response.
    """

    name: str
    response: str = ""
    remark: str = ""

    def __str__(self) -> str:
        end = f" ({self.remark})" if self.response and self.remark else self.remark
        return f"{self.name}: {self.response}{end}."


@dataclass(frozen=True)
class Instrument:
    """A known apparatus.

    Parameters
    ----------
    name : str
        As in a calibration file.
    title : str
        Its name for people.
    type : str
        Bulk test that it does.
    procedure : tuple of str
        Sentences on what the operator does, and on what the simulation does otherwise.
    options : mapping of str to Dimension
        Options of the test that the instrument decides.
    prints : tuple of Printed
        Quantities of its report.
    """

    name: str
    title: str
    type: str
    procedure: tuple[str, ...]
    options: Mapping[str, Dimension]
    prints: tuple[Printed, ...]

    @property
    def values(self) -> dict[str, Any]:
        """Values of its options, as in a calibration file."""
        return {name: dimension.value for name, dimension in self.options.items()}

    def beside(self, given: Collection[str]) -> Instrument:
        """Return what is left of it beside options that a calibration file gives."""
        left = {
            name: one
            for name, one in self.options.items()
            if name not in given and one.unless not in given
        }
        return replace(self, options=left)

    def parts(self) -> list[str]:
        """Return all of it in sentences, each dimension with its source."""
        return [
            f'{self.title}: apparatus = "{self.name}" in a [[test]] with type = "{self.type}".',
            *self.procedure,
            "Its dimensions, as options of the test:",
            *(f"  {key} = {it.toml}  ({it.source})" for key, it in self.options.items()),
            "Its report, and the response that each number is a target for:",
            *(f"  {printed}" for printed in self.prints),
        ]


def instrument_names(test: str = "") -> tuple[str, ...]:
    """Return the names of all instruments, or of those of one type of test."""
    names = sorted(path.stem for path in _FOLDER.glob("*.toml"))
    return tuple(name for name in names if test in ("", _read(name).type))


def read_instrument(name: str) -> Instrument:
    """Read an instrument.

    Parameters
    ----------
    name : str
        One of `instrument_names`; spaces and hyphens are as good as underscores.

    Raises
    ------
    InputError
        There is no such instrument; the fault has the nearest name.
    """
    stem = "_".join(name.lower().replace("-", " ").replace("_", " ").split())
    known = instrument_names()
    if stem not in known:
        nearest = suggest(stem, known, "Those that are known")
        raise InputError(messages.NO_INSTRUMENT.fault("apparatus", name=name, nearest=nearest))
    return _read(stem)


def instrument_table() -> TextTable:
    """Return all instruments, each with its test and title."""
    known = map(_read, instrument_names())
    return TextTable(("apparatus", "type", ""), tuple((i.name, i.type, i.title) for i in known))


@cache
def _read(stem: str) -> Instrument:
    data = tomllib.loads((_FOLDER / f"{stem}.toml").read_text(encoding="utf-8"))
    return Instrument(
        stem,
        data["title"],
        data["type"],
        tuple(data["procedure"]),
        {key: Dimension(**entry) for key, entry in data["options"].items()},
        tuple(Printed(**entry) for entry in data["prints"]),
    )
