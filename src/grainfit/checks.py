"""Checks of values that come from outside: arguments, files, models of the user's own."""

from __future__ import annotations

import math
from numbers import Real


def as_number(value: object) -> float:
    """Return a value as a plain float; NaN when it is no real number, or too large for one.

    A truth value is no number here: a comparison that slipped in is a mistake, not 0 or 1.

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
