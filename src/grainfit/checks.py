"""Check values from outside: arguments, files, custom models."""

from __future__ import annotations

import math
from numbers import Real


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
