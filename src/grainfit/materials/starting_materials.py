"""Starting materials: values and intervals to begin a calibration with, and their sources.

Each is a TOML file of the folder ``starting``: a table for each parameter with its ``value``, as a
calibration file takes it, and its ``source``. None of them is calibrated for anybody's material.
Tables below ``suggested`` are parameters that the file has as comments.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grainfit.errors import InputError
from grainfit.materials import messages

_FOLDER = Path(__file__).with_name("starting")
_HEAD = ("title", "about", "example_targets", "suggested")


@dataclass(frozen=True)
class StartingValue:
    """Value of one parameter, and its origin.

    Parameters
    ----------
    value : object
        As in a calibration file: a number, a text, or a table with ``min`` and ``max``.
    source : str
        Author, year and journal, or that there is none.
    """

    value: Any
    source: str

    @property
    def is_free(self) -> bool:
        """Whether it is an interval."""
        return isinstance(self.value, dict) and "min" in self.value

    @property
    def toml(self) -> str:
        """The value as TOML."""
        return _toml(self.value)


Sections = Mapping[str, Mapping[str, StartingValue]]


@dataclass(frozen=True)
class StartingMaterial:
    """A material to start from.

    Parameters
    ----------
    title : str
        Its name for people.
    about : tuple of str
        Lines on what its values stand for.
    example_targets : mapping of str to str
        Typical responses, to be replaced by measurements.
    sections : mapping of str to mapping of str to StartingValue
        Parameters by section and key of the calibration file.
    suggested : mapping of str to mapping of str to StartingValue
        Likewise, parameters for particles that are no dry spheres: comments in the file.
    """

    title: str
    about: tuple[str, ...]
    example_targets: Mapping[str, str]
    sections: Sections
    suggested: Sections


def starting_material_names() -> tuple[str, ...]:
    """Return the names of all starting materials."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def read_starting_material(name: str) -> StartingMaterial:
    """Read a starting material.

    Parameters
    ----------
    name : str
        One of `starting_material_names`, or one word of it, such as ``sand``; spaces and hyphens
        are as good as underscores.

    Raises
    ------
    InputError
        There is no such material.
    """
    known = starting_material_names()
    stem = "_".join(name.lower().replace("-", " ").split())
    if stem not in known:
        # One word is enough where it says which: sand, plastic.
        alike = [other for other in known if stem in other.split("_")]
        stem = alike[0] if len(alike) == 1 else ""
    if not stem:
        names = ", ".join(known)
        raise InputError(messages.NO_STARTING_MATERIAL.fault("material", name=name, known=names))
    data = tomllib.loads((_FOLDER / f"{stem}.toml").read_text(encoding="utf-8"))
    return StartingMaterial(
        title=data["title"],
        about=tuple(data["about"]),
        example_targets=data["example_targets"],
        sections=_values({name: entries for name, entries in data.items() if name not in _HEAD}),
        suggested=_values(data.get("suggested", {})),
    )


def _values(sections: Mapping[str, Any]) -> Sections:
    return {
        section: {key: StartingValue(**entry) for key, entry in entries.items()}
        for section, entries in sections.items()
    }


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_toml(entry)}' for key, entry in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    return f'"{value}"' if isinstance(value, str) else repr(value)
