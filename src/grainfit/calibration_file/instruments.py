"""The key ``apparatus`` of a test: an instrument whose dimensions the test takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.bulk_tests import messages
from grainfit.bulk_tests.instrument import Instrument, instrument_names, read_instrument
from grainfit.errors import InputError
from grainfit.options.kinds import Kind, Schema, note_wrong_kind
from grainfit.options.places import Place
from grainfit.options.tables import Key


@dataclass(frozen=True)
class InstrumentOf(Kind):
    """The name of an instrument that does a test.

    Parameters
    ----------
    test : str
        Type of the test.
    """

    test: str

    def read(self, value: Any, place: Place) -> Instrument | None:
        """Read the instrument of this name."""
        if not isinstance(value, str):
            note_wrong_kind(value, place, "a text", 'Write it in quotes: "...".')
            return None
        try:
            found = read_instrument(value)
        except InputError as error:
            for fault in error.faults:
                place.fault(fault.message, fault.remedy)
            return None
        if found.type == self.test:
            return found
        fault = messages.OTHER_TYPE.fault("", name=value, type=found.type)
        place.fault(fault.message, fault.remedy)
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema: any text, with the names of the instruments as examples."""
        return {"type": "string", "examples": list(instrument_names(self.test))}


def apparatus_key(test: str) -> Key | None:
    """Return the key of the instruments of a type of test; None if there are none."""
    names = instrument_names(test)
    if not names:
        return None
    return Key(
        "apparatus",
        InstrumentOf(test),
        "Instrument of the laboratory, by its name: it gives the options of its dimensions; those "
        "that stand beside it override them.",
        default="none",
        example=f'"{names[0]}"',
    )


def with_instrument(
    test: Mapping[str, Any], place: Place
) -> tuple[Mapping[str, Any], Instrument | None]:
    """Return a test with the options of its instrument where the file gives none.

    Parameters
    ----------
    test : mapping of str to object
        The table of the file, with its type.
    place : Place
        Where it is.

    Returns
    -------
    tuple of mapping and Instrument
        The table without the key of the instrument, and the instrument; as it was, and None,
        without one, or with one that cannot be read, whose fault is noted.
    """
    key = apparatus_key(test["type"])
    if key is None or key.name not in test:
        return test, None
    instrument = key.kind.read(test[key.name], place.at(key.name))
    own = {name: value for name, value in test.items() if name != key.name}
    return ({**instrument.values, **own}, instrument) if instrument else (own, None)
