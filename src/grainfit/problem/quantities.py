"""Quantities such as ``"2.1 g/cm^3"`` and ``"2 %"`` as arguments of parameters and targets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grainfit.errors import Fault, InputError
from grainfit.units import UnitError, percentage, to_si, to_unit
from grainfit.validation import as_number, kind_faults


def shown(value: object) -> str:
    """Return an argument for a message."""
    return repr(value) if isinstance(value, str) else " ".join(str(value).split())


def make_floats(owner: object, *keys: str) -> None:
    """Convert numbers of any kind to floats, whole ones too: definitions are compared as JSON."""
    for key in keys:
        value = getattr(owner, key)
        if value is not None:
            object.__setattr__(owner, key, float(value))


def require_units(owner: Any, *keys: str) -> None:
    """Raise `InputError` if units of an owner with a name are no texts."""
    InputError.raise_for(
        fault
        for key in keys
        for fault in kind_faults(
            f"{owner.name}.{key}", getattr(owner, key), str | None, 'a text such as "kg/m^3"'
        )
    )


def read_quantities(owner: Any, keys: Mapping[str, str], usual_unit: str | None = None) -> None:
    """Convert texts such as ``"2.1 g/cm^3"`` to numbers in the owner's unit.

    Without a unit, the owner gets the usual one, or that of the first quantity where that is not
    known; a usual unit that is empty is that of numbers.
    """
    texts = {key: text for key in keys if isinstance(text := getattr(owner, key), str)}
    if not texts:
        return
    faults = []
    for key, text in texts.items():
        unit = owner.unit or usual_unit
        try:
            value, unit = to_si(text) if unit is None else (to_unit(text, unit), unit)
        except UnitError as error:
            faults.append(Fault(f"{owner.name}.{keys[key]}", error.message, error.remedy))
            continue
        object.__setattr__(owner, key, value)
        object.__setattr__(owner, "unit", unit)
    InputError.raise_for(faults)


def share_of(given: Any, value: Any) -> Any:
    """Return a percentage of a value as a number; anything else unchanged."""
    if not isinstance(given, str) or not given.strip().endswith("%"):
        return given
    share = percentage(given)
    return given if share is None else share * abs(as_number(value))
