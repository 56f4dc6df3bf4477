"""Cells of the store: read as text, number or names with values, or refused by name."""

from __future__ import annotations

import json
import math
import reprlib
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, NoReturn, TypeVar

from grainfit.validation import as_number, is_whole

_Choice = TypeVar("_Choice", bound=str)


class UnreadableCell:
    """Content of a cell that should have been JSON and is not."""

    def __init__(self, content: object) -> None:
        self._content = content

    def __repr__(self) -> str:
        return f"not JSON: {_shortened.repr(self._content)}"


_shortened = reprlib.Repr()
_shortened.maxstring = 60


def read_json(content: str | bytes) -> Any:
    """Return JSON data; an `UnreadableCell` where there are none.

    One cell that cannot be read is not to hide the name of its row.
    """
    try:
        return json.loads(content, parse_constant=_refuse)
    except (TypeError, ValueError, RecursionError):
        return UnreadableCell(content)


def read_text(content: bytes) -> str | bytes:
    """Decode a cell; bytes that are no UTF-8 text are returned unchanged, for `text` to refuse."""
    try:
        return content.decode()
    except UnicodeDecodeError:
        return content


def text(value: Any, column: str) -> str:
    """Return a text."""
    return value if isinstance(value, str) else _refuse_cell(column, value, "a text")


def finite(value: Any, column: str) -> float:
    """Return a finite number."""
    number = as_number(value)
    return number if math.isfinite(number) else _refuse_cell(column, value, "a finite number")


def moment(value: Any, column: str) -> float:
    """Return a time in seconds since the epoch; refuse one outside the calendar."""
    seconds = finite(value, column)
    try:
        datetime.fromtimestamp(seconds, UTC)
    except (ValueError, OverflowError, OSError):
        _refuse_cell(column, value, "a time")
    return seconds


def whole(value: Any, column: str) -> int:
    """Return a whole number."""
    if not is_whole(value):
        _refuse_cell(column, value, "a whole number")
    return value


def choice(value: Any, column: str, values: Sequence[_Choice]) -> _Choice:
    """Return one of the values."""
    found = next((one for one in values if one == value), None)
    if found is None:
        _refuse_cell(column, value, f"one of {', '.join(values)}")
    return found


def mapping(value: Any, column: str) -> Mapping[str, Any]:
    """Return names with values."""
    if not isinstance(value, Mapping):
        _refuse_cell(column, value, "names with values")
    return value


def numbers_by_name(value: Any, column: str) -> dict[str, float]:
    """Return finite numbers by name."""
    return {n: finite(v, f"{column}.{n}") for n, v in mapping(value, column).items()}


def texts_by_name(value: Any, column: str) -> dict[str, str]:
    """Return texts by name."""
    return {n: text(v, f"{column}.{n}") for n, v in mapping(value, column).items()}


def texts(value: Any, column: str) -> list[str]:
    """Return a list of texts."""
    if not isinstance(value, list):
        _refuse_cell(column, value, "a list of texts")
    return [text(one, column) for one in value]


def _refuse_cell(column: str, value: Any, wanted: str) -> NoReturn:
    raise ValueError(f"{column} is {_shortened.repr(value)}, not {wanted}")


def _refuse(constant: str) -> NoReturn:
    raise ValueError(constant)
