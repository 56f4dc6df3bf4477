"""Check values from outside: arguments, files, custom models."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real

from grainfit.errors import Fault


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


def count_faults(given: Mapping[str, object]) -> list[Fault]:
    """Return a fault for every value that is not a whole number from 1 on.

    Parameters
    ----------
    given : mapping of str to object
        Values by name of the argument.
    """
    return [
        Fault(name, f"is {value!r}.", "Give a whole number from 1 on.")
        for name, value in given.items()
        if not isinstance(value, int) or isinstance(value, bool) or value < 1
    ]
