"""Options of the user's own functions: plain values, whose meaning only the functions know."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grainfit.options.kinds import Kind, Quantity, Schema, Text, note_wrong_kind
from grainfit.options.places import Place
from grainfit.units import UnitError, to_si


@dataclass(frozen=True)
class OptionValue(Kind):
    """A number, a quantity with a unit, a text, true or false."""

    def read(self, value: Any, place: Place) -> bool | int | float | str | None:
        """Read a value; a quantity with a unit becomes a number in SI units."""
        if isinstance(value, bool):
            return value
        if isinstance(value, int | float):
            good = Quantity("").read(value, place) is not None
            return value if good else None
        if not isinstance(value, str):
            note_wrong_kind(value, place, "a number, a text, true or false")
            return None
        text = Text().read(value, place)
        try:
            return text if text is None else to_si(text)[0]
        except UnitError:
            return text

    def schema(self) -> Schema:
        """Return the JSON Schema of a plain value."""
        return {"type": ["number", "string", "boolean"]}
