"""Check values from outside: arguments, files, custom models."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, TypeGuard

from grainfit import ground_messages as messages
from grainfit.errors import Fault
from grainfit.one_line import shortened


def as_number(value: object) -> float:
    """Return a value as a plain float; NaN if it is not a real number, or too large for a float.

    A bool is not a number here: it is probably a comparison given by mistake.

    Examples
    --------
    >>> as_number(3), as_number(True), as_number("3")
    (3.0, nan, nan)
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan


#: Sizes of numbers that are computed with: products of several are numbers, too.
SMALLEST, LARGEST = 1e-30, 1e30
#: Smallest share of a number that floating-point numbers resolve with digits to spare.
SMALLEST_SHARE = 1e-9
#: Why a number is refused, and what to do.
NOT_COMPUTABLE = f"Give 0, or a number of {SMALLEST:g} to {LARGEST:g} in size: check its unit."


def is_computable(value: float) -> bool:
    """Return True if a number is zero, or of a size that can be computed with.

    Examples
    --------
    >>> is_computable(0.0), is_computable(-3e5), is_computable(5e-324), is_computable(1e300)
    (True, True, False, False)
    """
    return value == 0 or SMALLEST <= abs(value) <= LARGEST


def is_whole(value: object) -> TypeGuard[int]:
    """Return True for a whole number; a bool is none here.

    Examples
    --------
    >>> is_whole(3), is_whole(True), is_whole(3.0)
    (True, False, False)
    """
    return isinstance(value, int) and not isinstance(value, bool)


def whole_number_faults(given: Mapping[str, Any]) -> list[Fault]:
    """Return a fault for every value that is not a whole number from 1 on.

    Parameters
    ----------
    given : mapping of str to object
        Values by name of the argument.
    """
    return [
        messages.NO_COUNT.fault(name, given=value)
        for name, value in given.items()
        if not is_whole(value) or value < 1
    ]


def list_faults(name: str, given: object, kind: type) -> list[Fault]:
    """Return a fault of an argument unless it is a list of objects of a kind."""
    if isinstance(given, Sequence) and all(isinstance(item, kind) for item in given):
        return []
    return [messages.NO_LIST_OF.fault(name, given=shortened(given), kind=kind.__name__)]


def mapping_faults(name: str, given: object, example: str) -> list[Fault]:
    """Return a fault of an argument unless it maps names to values."""
    if isinstance(given, Mapping) and all(isinstance(key, str) for key in given):
        return []
    return [messages.NOT_BY_NAME.fault(name, given=shortened(given), example=example)]


def kind_faults(name: str, given: object, kinds: Any, wanted: str) -> list[Fault]:
    """Return a fault of an argument unless it is of one of some kinds, as `isinstance` has them."""
    if isinstance(given, kinds):
        return []
    return [messages.NOT_ACCEPTED.fault(name, given=shortened(given), wanted=wanted)]


def plain(value: Any) -> Any:
    """Return a number of NumPy as one of Python, which can be written as JSON; others unchanged."""
    return value.item() if getattr(value, "ndim", None) == 0 else value


def set_plain(owner: object, *keys: str) -> None:
    """Make numbers of NumPy among the attributes of a frozen dataclass ones of Python."""
    for key in keys:
        object.__setattr__(owner, key, plain(getattr(owner, key)))


def plain_tuple(given: Any) -> Any:
    """Return a sequence, an array or a Series as a tuple of plain values; others unchanged.

    Examples
    --------
    >>> plain_tuple([1, 2.5]), plain_tuple("1 mm"), plain_tuple(3)
    ((1, 2.5), '1 mm', 3)
    """
    if isinstance(given, str):
        return given
    try:
        return tuple(map(plain, given))
    except TypeError:
        return given


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def number_list_faults(name: str, given: object) -> list[Fault]:
    """Return a fault of an argument unless it is a tuple of numbers."""
    if isinstance(given, tuple) and all(map(_is_number, given)):
        return []
    return [messages.NO_NUMBERS.fault(name, given=shortened(given))]
