"""Arrays that a metamodel is given, checked: faults are named instead of calculated with."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array
from grainfit.errors import InputError
from grainfit.metamodels import messages

#: Beyond these, squares of a response or of its rounding error are no floating-point numbers.
MAGNITUDES = (1e-100, 1e100)
#: Distance from the unit cube up to which points are predicted, in its sides.
BEYOND_CUBE = 1.0


def checked(name: str, array: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    """Return an array as finite floats.

    Parameters
    ----------
    name : str
        Its name in messages.
    array : array_like
        The array.
    shape : tuple of int or None
        Its shape; None is any length.

    Raises
    ------
    InputError
        It has another shape, or a value is not finite.
    """
    try:
        found = np.asarray(array, dtype=float)
    except (TypeError, ValueError):
        raise InputError(messages.NO_ARRAY.fault(name)) from None
    fits = len(found.shape) == len(shape) and all(
        want is None or want == got for want, got in zip(shape, found.shape, strict=True)
    )
    if not fits:
        wanted = " x ".join("any" if length is None else str(length) for length in shape)
        raise InputError(messages.BAD_SHAPE.fault(name, shape=found.shape, wanted=wanted))
    if not np.isfinite(found).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(found))[0])
        raise InputError(messages.NOT_FINITE.fault(name, value=found[where], where=where))
    return found


def checked_values(values: ArrayLike, n: int) -> Array:
    """Return n responses whose squares are floating-point numbers, or raise `InputError`."""
    found = checked("values", values, (n,))
    largest = float(np.abs(found).max(initial=0.0))
    if largest and not MAGNITUDES[0] <= largest <= MAGNITUDES[1]:
        least, most = MAGNITUDES
        fault = messages.BAD_MAGNITUDE.fault("values", largest=largest, least=least, most=most)
        raise InputError(fault)
    return found


def checked_noise(noise: ArrayLike | None, n: int, name: str = "noise_variance") -> Array:
    """Return n variances or standard errors, 0 where none are given, or raise `InputError`."""
    if noise is None:
        return np.zeros(n)
    found = checked(name, noise, (n,))
    if (found < 0).any():
        raise InputError(messages.NEGATIVE.fault(name, least=found.min()))
    return found


def checked_points(points: ArrayLike, d: int | None) -> Array:
    """Return points in or about the unit cube of d dimensions, or raise `InputError`."""
    found = checked("points", points, (None, d))
    if found.size and (found.min() < -BEYOND_CUBE or found.max() > 1.0 + BEYOND_CUBE):
        low, high = found.min(), found.max()
        raise InputError(messages.OUTSIDE_CUBE.fault("points", low=low, high=high))
    return found
