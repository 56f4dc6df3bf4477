"""Objects in one line, as a debugger, a notebook or a failed test shows them."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

#: Longest representation, characters.
LONGEST = 120
_END = ", ...)"
_shortened = reprlib.Repr()
_shortened.maxstring, _shortened.maxother = 90, 40
_shortened.maxdict = _shortened.maxtuple = _shortened.maxlist = 3


def one_line(instance: Any) -> str:
    """Return the class of an object with those of its fields that are not at their default.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass
    ... class Heap(OneLine):
    ...     diameter: float
    ...     photographs: int = 4
    >>> Heap(0.01)
    Heap(diameter=0.01)
    """
    return as_call(type(instance).__name__, _shown(instance))


def as_call(name: str, arguments: Mapping[str, Any]) -> str:
    """Return a call with as many of its arguments as one line takes."""
    text = f"{name}("
    for number, (key, value) in enumerate(arguments.items()):
        part = f"{', ' if number else ''}{key}={shortened(value)}"
        if len(text) + len(part) + len(_END) > LONGEST:
            return text + (_END if number else "...)")
        text += part
    return f"{text})"


def shortened(value: Any) -> str:
    """Return the representation of a value in one line, its middle left out where it is long."""
    return " ".join(_shortened.repr(value).split())


def _shown(instance: Any) -> dict[str, Any]:
    if not is_dataclass(instance):
        return {name: value for name, value in vars(instance).items() if name[0] != "_"}
    shown = {}
    for field in fields(instance):
        value = getattr(instance, field.name)
        default = field.default if field.default_factory is MISSING else field.default_factory()
        if field.repr and (type(value) is not type(default) or not _is_same(value, default)):
            shown[field.name] = value
    return shown


def _is_same(value: Any, default: Any) -> bool:
    # Arrays are not compared.
    return value is None or (isinstance(value, str | int | float) and value == default)


class OneLine:
    """Base of classes whose subclasses, data classes too, are shown in one line.

    A subclass with a representation of its own keeps it.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        """Set the representation before a data class makes one of its own."""
        super().__init_subclass__(**options)
        is_inherited = cls.__repr__ in (object.__repr__, one_line)
        if "__repr__" not in vars(cls) and (is_inherited or OneLine in cls.__bases__):
            cls.__repr__ = one_line  # type: ignore[method-assign]
