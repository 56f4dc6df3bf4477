"""Options as fields of frozen dataclasses: declared once, checked when an object is made."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grainfit.errors import InputError
from grainfit.options.kinds import Kind
from grainfit.options.places import Findings, Place
from grainfit.options.tables import Key

_OPTION = "grainfit.option"


@dataclass(frozen=True)
class Option:
    """A declared option, from which file key, schema, checks, help and tables follow.

    Parameters
    ----------
    name : str
        Name of the field, and of the key in the calibration file.
    kind : Kind
        Accepted values.
    help : str
        Sentences for people.
    default : object
        Value when it is not given; None when it depends on something else.
    usual : str
        The default in words; empty when the value says it.
    example : str
        A good value other than the default, as TOML.
    """

    name: str
    kind: Kind
    help: str
    default: Any = None
    usual: str = ""
    example: str = ""

    @property
    def default_words(self) -> str:
        """The default for people, as it is written in the calibration file."""
        if self.usual or self.default is None:
            return self.usual or "none"
        if isinstance(self.default, bool):
            return str(self.default).lower()
        return f'"{self.default}"' if isinstance(self.default, str) else f"{self.default:g}"

    def key(self) -> Key:
        """Return the key of the calibration file."""
        text = f"{self.help} Default: {self.default_words}."
        return Key(self.name, self.kind, text, example=self.example)


def option(
    kind: Kind, text: str, *, default: Any = None, usual: str = "", example: str = ""
) -> Any:
    """Declare an option as a field of a dataclass.

    Parameters
    ----------
    kind, text, default, usual, example : object
        As in `Option`; the text is its help.

    Examples
    --------
    >>> from grainfit.options.kinds import Whole
    >>> @dataclass(frozen=True)
    ... class Oven:
    ...     trays: int = option(Whole(1, 4), "Trays that it holds.", default=2)
    >>> [(known.name, known.default_words) for known in options_of(Oven)]
    [('trays', '2')]
    """
    declared = {"kind": kind, "help": text, "usual": usual, "example": example}
    return dataclasses.field(default=default, metadata={_OPTION: declared})


def options_of(owner: Any) -> tuple[Option, ...]:
    """Return the options of a dataclass, or of one of its objects, in the order of its fields."""
    return tuple(
        Option(name=field.name, default=field.default, **field.metadata[_OPTION])
        for field in dataclasses.fields(owner)
        if _OPTION in field.metadata
    )


def check_options(owner: Any) -> None:
    """Check the options of an object that is being made, and turn them into plain values.

    Raises
    ------
    InputError
        Every option whose value is not accepted, by name.
    """
    findings = Findings(Path())
    for known in options_of(owner):
        given = getattr(owner, known.name)
        if given is None and known.default is None:
            continue
        value = known.kind.read(given, Place(findings, (known.name,)))
        object.__setattr__(owner, known.name, value)
    if findings.faults:
        raise InputError(findings.faults)
