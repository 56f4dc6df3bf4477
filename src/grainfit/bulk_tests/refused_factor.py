"""Way out of a factor of coarse graining at which particles are too large for an apparatus."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from grainfit.errors import InputError

#: Part of a refused factor that is tried next. Not zero, as in a bisection down to 1: a large
#: apparatus may hold too many of the real particles.
_STEP = 0.9


def with_factor(
    error: InputError, factor: float, is_possible: Callable[[float], bool]
) -> InputError:
    """Return the faults of a test with the factor that causes them, and one that is possible.

    Parameters
    ----------
    error : InputError
        The faults.
    factor : float
        Diameter of the simulated particles over that of the real ones.
    is_possible : callable
        Whether the test is possible at another factor.
    """
    possible = largest_factor(factor, is_possible)
    large = f"particles are {factor:g} times as large as the real ones"
    if possible is None:
        hint = f"{large.capitalize()} (particle.coarse_graining)."
    elif possible == 1:
        hint = f"Or leave particle.coarse_graining out: {large}."
    else:
        hint = f"Or use particle.coarse_graining = {possible:g} at most: {large}."
    return InputError([replace(f, remedy=f"{f.remedy} {hint}".strip()) for f in error.faults])


def largest_factor(refused: float, is_possible: Callable[[float], bool]) -> float | None:
    """Return the largest possible factor below one that is refused, in hundredths; None if none is.

    Parameters
    ----------
    refused : float
        A factor above 1.
    is_possible : callable
        Whether a factor is possible.

    Examples
    --------
    >>> largest_factor(9, lambda factor: 1.2 <= factor <= 3.3333)
    3.33
    >>> largest_factor(9, lambda factor: factor < 0.5)
    """
    above = math.ceil(100 * refused)
    found = above
    while found == above:
        if above <= 100:
            return None
        found = max(100, math.floor(_STEP * above))
        if not is_possible(found / 100):
            above = found
    while above - found > 1:
        middle = (above + found) // 2
        if is_possible(middle / 100):
            found = middle
        else:
            above = middle
    return found / 100
