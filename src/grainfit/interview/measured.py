"""Measurements as they are typed: repeats with a unit, and an uncertainty."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.errors import Fault, InputError
from grainfit.interview import messages
from grainfit.units import UnitError, example_with, percentage, to_unit

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
ERROR = re.compile(r"±|\+\s*/?\s*-(?=\s*[\d.])")
#: Keys of a target that say what was measured; its others stay.
MEASURED = ("value", "uncertainty", "measurements", "systematic", "photos")


@dataclass(frozen=True)
class Measured:
    """One value with its uncertainty, or repeats with what is wrong in all of them.

    Parameters
    ----------
    values : tuple of str
        Quantities with their units.
    error : str
        Standard uncertainty; of repeats the part that they share; empty if it is not given.
    """

    values: tuple[str, ...]
    error: str = ""

    def target(self) -> dict[str, Any]:
        """Return the keys of a target in a calibration file."""
        repeated = len(self.values) > 1
        if repeated:
            found: dict[str, Any] = {"measurements": [_plain(value) for value in self.values]}
        else:
            found = {"value": _plain(self.values[0])}
        if self.error:
            found["systematic" if repeated else "uncertainty"] = _plain(self.error)
        return found


def read_measured(key: str, text: str, unit: str) -> Measured:
    """Read measurements as they are typed.

    Parameters
    ----------
    key : str
        Of the target, for faults.
    text : str
        Such as ``"31; 32.5; 30 deg ± 0.5 deg"``: repeats are separated by spaces, semicolons, or
        commas with a space, and the last unit is that of all that have none.
    unit : str
        SI unit of the response; angles and pure numbers may be without.

    Raises
    ------
    InputError
        A value is no quantity of the unit.

    Examples
    --------
    >>> read_measured("angle", "31, 32.5 30 deg ± 0.5", "deg")
    Measured(values=('31 deg', '32.5 deg', '30 deg'), error='0.5 deg')
    >>> read_measured("mass_flow", "20 g/s", "kg/s").target()
    {'value': '20 g/s'}
    """
    given, *errors = ERROR.split(text)
    parts = _quantities(given)
    if not parts or len(errors) > 1:
        raise InputError(messages.NO_MEASUREMENT.fault(key, given=text, example=_example(unit)))
    last = next((written for _, written in reversed(parts) if written), _own(unit))
    values = tuple(_checked(key, number, written or last, unit) for number, written in parts)
    return Measured(values, _error(key, errors[0].strip(), last, unit) if errors else "")


def typed(target: Mapping[str, Any]) -> str:
    """Return what one would type for a target of a file; empty if it is a table.

    Examples
    --------
    >>> typed({"measurements": ["31 deg", "32 deg"], "systematic": "1 deg"})
    '31 deg; 32 deg ± 1 deg'
    """
    if isinstance(target.get("photos"), list):
        return "; ".join(map(str, target["photos"]))
    values = target.get("measurements", [target["value"]] if "value" in target else [])
    error = target.get("systematic", target.get("uncertainty", ""))
    if not isinstance(values, list) or not values:
        return ""
    return "; ".join(map(str, values)) + (f" ± {error}" if error != "" else "")


def _quantities(text: str) -> list[tuple[str, str]]:
    """Return numbers with what is written behind each."""
    found: list[tuple[str, str]] = []
    for word in re.split(r"[;\s]+|,\s+", text.strip().rstrip(",;")):
        number = _NUMBER.match(word)
        if number is not None:
            found.append((number[0], word[number.end() :]))
        elif word and found:
            found[-1] = found[-1][0], f"{found[-1][1]} {word}".strip()
        elif word:
            return []
    return found


def _own(unit: str) -> str:
    """Return the unit of values without one: only of angles nobody takes it for another."""
    return unit if unit == "deg" else ""


def _checked(key: str, number: str, written: str, unit: str) -> str:
    if not written and unit not in ("", "deg"):
        example = _example(unit)
        raise InputError(messages.NO_UNIT.fault(key, given=number, example=example))
    # Anything else than a unit stays at its number, so that a fault shows it as it was typed.
    value = f"{number}{' ' * written[:1].isalpha()}{written}"
    try:
        to_unit(value, unit)
    except UnitError as error:
        raise InputError(Fault(key, error.message, error.remedy)) from None
    return value


def _error(key: str, text: str, last: str, unit: str) -> str:
    if percentage(text) is not None:
        return text
    number = _NUMBER.match(text)
    if number is None:
        raise InputError(messages.NO_ERROR.fault(key, given=text))
    return _checked(key, number[0], text[number.end() :].strip() or last, unit)


def _example(unit: str) -> str:
    return example_with(unit) if unit else "0.4"


def _plain(value: str) -> str | float:
    """Return a pure number as such: TOML has it without quotes."""
    return float(value) if _NUMBER.fullmatch(value) else value
