"""Dataclasses from plain data, such as that of a JSON file: every value is checked by its type."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from math import isfinite
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints


def parse_json(text: str | bytes) -> Any:
    """Return the data of a JSON text; raise ValueError for numbers that are not finite."""
    return json.loads(text, parse_float=_finite, parse_int=_whole, parse_constant=_finite)


def _finite(text: str) -> float:
    if not isfinite(value := float(text)):
        raise ValueError(f"{text[:20]} is not a finite number")
    return value


def _whole(text: str) -> int:
    # A whole number may also be larger than any floating-point number.
    _finite(text)
    return int(text)


def read_plain(kind: Any, data: Any, place: str = "") -> Any:
    """Return plain data as a value of a type: a dataclass, a collection, a number or a text.

    Keys that a dataclass does not have are ignored; whole numbers count as numbers.

    Parameters
    ----------
    kind : type
        The wanted type, with those of its parts.
    data : object
        Plain data.
    place : str
        Its place in the whole, for messages.

    Raises
    ------
    ValueError
        Some value is missing or has another type; says which.

    Examples
    --------
    >>> read_plain(tuple[float, ...], [1, 2.5])
    (1.0, 2.5)
    >>> read_plain(Mapping[str, int], {"runs": "3"})
    Traceback (most recent call last):
    ValueError: runs: has to be a whole number
    """
    if is_dataclass(kind):
        return _read_dataclass(kind, data, place)
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        [wanted] = [part for part in parts if part is not NoneType]
        return None if data is None else read_plain(wanted, data, place)
    if origin is Literal:
        _require(data in parts and isinstance(data, str), place, f"has to be one of {parts}")
        return data
    if origin is tuple:
        return _read_tuple(parts, data, place)
    if origin is not None and issubclass(origin, Mapping):
        _require(isinstance(data, dict), place, "has to be an object")
        return {key: read_plain(parts[1], one, _within(place, key)) for key, one in data.items()}
    return _read_value(kind, data, place)


def _read_dataclass(kind: Any, data: Any, place: str) -> Any:
    _require(isinstance(data, dict), place, "has to be an object")
    found = {}
    for field, wanted in _fields(kind):
        inside = _within(place, field.name)
        if field.name in data:
            found[field.name] = read_plain(wanted, data[field.name], inside)
        else:
            has_default = field.default is not MISSING or field.default_factory is not MISSING
            _require(has_default, inside, "is missing")
    return kind(**found)


@cache
def _fields(kind: Any) -> list[tuple[Any, Any]]:
    types = get_type_hints(kind)
    return [(field, types[field.name]) for field in fields(kind)]


def _read_tuple(parts: tuple[Any, ...], data: Any, place: str) -> tuple[Any, ...]:
    _require(isinstance(data, list), place, "has to be a list")
    if parts[-1] is Ellipsis:
        parts = parts[:1] * len(data)
    _require(len(parts) == len(data), place, f"has to have {len(parts)} items")
    numbered = enumerate(zip(parts, data, strict=True))
    return tuple(read_plain(part, one, _within(place, i)) for i, (part, one) in numbered)


def _read_value(kind: Any, data: Any, place: str) -> Any:
    if kind is float:
        is_number = isinstance(data, int | float) and not isinstance(data, bool)
        _require(is_number, place, "has to be a number")
        return float(data)
    names = {int: "a whole number", str: "a text", bool: "true or false"}
    # A truth value is a whole number, too, in Python.
    _require(type(data) is kind, place, f"has to be {names[kind]}")
    return data


def _require(is_right: bool, place: str, fault: str) -> None:
    if not is_right:
        raise ValueError(f"{place or 'it'}: {fault}")


def _within(place: str, key: object) -> str:
    return f"{place}.{key}" if place else str(key)
