"""Tables of options: their keys, and the faults of a table."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from grainfit.options import messages
from grainfit.options.kinds import (
    NAME_PATTERN,
    Kind,
    Schema,
    note_bad_name,
    note_wrong_kind,
    suggest,
)
from grainfit.options.places import Place

#: Values read from a table, by key; None where a value was faulty.
Values = dict[str, Any]
#: Builds a result from the values of a table.
Finish = Callable[[Values, Place], Any]


@dataclass(frozen=True)
class Key:
    """One key of a table.

    Parameters
    ----------
    name : str
        As written in the file.
    kind : Kind
        Kind of its value.
    description : str
        For the editor's completion and the documentation, with marks of code.
    required : bool
        Whether its absence is a fault.
    example : str
        A good value, as TOML.
    default : str
        Default in words, unless the description states it.
    """

    name: str
    kind: Kind
    description: str
    required: bool = False
    example: str = ""
    default: str = ""

    def in_words(self) -> Key:
        """Return the key with plain texts, as pages, paper and terminals show them."""
        description, default = (text.replace("`", "") for text in (self.description, self.default))
        return replace(self, description=description, default=default)

    def note_missing(self, place: Place) -> None:
        """Note that this key is missing in the table at a place."""
        remedy = f"Add it, for example: {self.name} = {self.example}" if self.example else ""
        place.at(self.name).fault(messages.MISSING, remedy=remedy)

    def schema(self) -> Schema:
        """Return the JSON Schema of the value, with description and example."""
        default = f" Default: {self.default}." if self.default else ""
        schema = {"description": f"{self.description}{default}", **self.kind.schema()}
        if self.example:
            schema["examples"] = [tomllib.loads(f"value = {self.example}")["value"]]
        return schema


def _as_read(values: Values, place: Place) -> Any:  # noqa: ARG001
    return values


@dataclass(frozen=True)
class Table(Kind):
    """A table with known keys.

    Parameters
    ----------
    keys : tuple of Key
        All keys that it can have.
    finish : callable
        Builds the result from the values read, and notes faults that concern several of them.
        Absent keys are absent from the values; faulty ones are None.
    homes : mapping of str to str
        Right section of keys that belong elsewhere, for the remedy.
    answers : mapping of str to str
        Remedies of names that are no keys, but that people write for a reason.
    """

    keys: tuple[Key, ...]
    finish: Finish = _as_read
    homes: Mapping[str, str] | None = None
    answers: Mapping[str, str] | None = None

    def read(self, value: Any, place: Place) -> Any:
        """Read every known key, and note the unknown and the missing ones."""
        if not isinstance(value, dict):
            note_wrong_kind(value, place, "a table", self._table_remedy(place))
            return None
        kinds = {key.name: key.kind for key in self.keys}
        unknown = [name for name in value if name not in kinds]
        for name in unknown:
            place.at(name).fault(messages.UNKNOWN_KEY, remedy=self._meant(name))
        # A misspelt key is one fault: the key that was meant is not missing, too.
        meant = {self._close(name) for name in unknown}
        for key in self.keys:
            if key.required and key.name not in value and key.name not in meant:
                key.note_missing(place)
        values = {
            name: kinds[name].read(entry, place.at(name))
            for name, entry in value.items()
            if name in kinds
        }
        # The key that was meant is there, but cannot be read.
        values.update({name: None for name in meant if name and name not in values})
        return self.finish(values, place)

    def _close(self, name: str) -> str:
        names = [key.name for key in self.keys]
        return next(iter(difflib.get_close_matches(name[:64], names, n=1)), "")

    def _meant(self, name: str) -> str:
        if self.answers and name in self.answers:
            return self.answers[name]
        if self.homes and name in self.homes and not self._close(name):
            return f"It belongs in {self.homes[name]}."
        return suggest(name, (key.name for key in self.keys), "Keys here")

    def _table_remedy(self, place: Place) -> str:
        if len(place.path) == 1:
            return f"Write [{place.key}] and its keys below."
        names = [key.name for key in self.keys if key.required]
        shown = names or [key.name for key in self.keys[:2]]
        return f"Write {{ {', '.join(f'{name} = ...' for name in shown)} }}."

    def schema(self) -> Schema:
        """Return the JSON Schema of the table."""
        schema: Schema = {
            "type": "object",
            "properties": {key.name: key.schema() for key in self.keys},
            "additionalProperties": False,
        }
        required = [key.name for key in self.keys if key.required]
        if required:
            schema["required"] = required
        return schema


@dataclass(frozen=True)
class Named(Kind):
    """A table whose keys are names that the user chooses.

    Parameters
    ----------
    entry : Kind
        Kind of every value.
    shortest : int
        Number of entries that it needs.
    reserved : tuple of str
        Names that are taken.
    is_whole : bool
        Whether nothing is read of a table with a faulty entry.
    """

    entry: Kind
    shortest: int = 0
    reserved: tuple[str, ...] = ()
    is_whole: bool = False

    def read(self, value: Any, place: Place) -> Values | None:
        """Read every entry; those that are faulty are None."""
        if not isinstance(value, dict):
            note_wrong_kind(value, place, "a table", f"Write [{place.key}] and its keys below.")
            return None
        read = {name: self._entry(name, entry, place.at(name)) for name, entry in value.items()}
        return None if self.is_whole and None in read.values() else read

    def _entry(self, name: str, value: Any, place: Place) -> Any:
        if name in self.reserved:
            place.fault(messages.RESERVED_NAME, name=name)
            return None
        return self.entry.read(value, place) if note_bad_name(name, place) else None

    def schema(self) -> Schema:
        """Return the JSON Schema of the table."""
        names: Schema = {"pattern": f"^{NAME_PATTERN}$"}
        if self.reserved:
            names["not"] = {"enum": list(self.reserved)}
        return {
            "type": "object",
            "propertyNames": names,
            "additionalProperties": self.entry.schema(),
            "minProperties": self.shortest,
        }
