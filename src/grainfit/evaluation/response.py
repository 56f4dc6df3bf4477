"""Responses of a run: numbers and curves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

from grainfit.errors import InputError
from grainfit.evaluation import messages


@dataclass(frozen=True)
class Response:
    """One measured quantity of one run.

    Parameters
    ----------
    value : float
        Value in SI units; angles in degrees.
    standard_error : float
        Standard error of this run's value, 0 if unknown. The metamodels estimate the scatter from
        the runs. Standard errors indicate which runs scatter more than others (a short average, a
        small heap); they are used if the runs confirm them.
    """

    value: float
    standard_error: float = 0.0


@dataclass(frozen=True)
class Curve:
    """A response over a coordinate, such as stress over strain, of one run.

    Parameters
    ----------
    coordinates, values : sequence of float
        Points, at least two, coordinates increasing; in SI units.
    stays : bool
        Whether the last value holds for all larger coordinates, as the mass that has left a
        container does.

    Raises
    ------
    InputError
        The points are fewer than two, not finite, or not in order.

    Examples
    --------
    >>> Curve([0.0, 0.5, 1.0], [0.0, 2.0, 3.0]).values
    (0.0, 2.0, 3.0)
    """

    coordinates: Sequence[float]
    values: Sequence[float]
    stays: bool = False

    if TYPE_CHECKING:
        # Arrays are read: attributes are sequences of numbers.
        def __init__(
            self, coordinates: Iterable[float], values: Iterable[float], stays: bool = False
        ) -> None: ...

    def __repr__(self) -> str:
        return f"Curve({len(self.coordinates)} points, stays={self.stays})"

    def __post_init__(self) -> None:
        for key in ("coordinates", "values"):
            given = getattr(self, key)
            try:
                numbers = tuple(map(float, given))
            except (TypeError, ValueError):
                numbers = ()
            if len(numbers) < 2 or not all(map(math.isfinite, numbers)):
                raise InputError(messages.NOT_FINITE.fault(key))
            object.__setattr__(self, key, numbers)
        places = self.coordinates
        if len(places) != len(self.values):
            fault = messages.UNEQUAL_NUMBERS.fault(
                "coordinates", count=len(places), values=len(self.values)
            )
            raise InputError(fault)
        if any(later <= earlier for earlier, later in pairwise(places)):
            raise InputError(messages.NOT_INCREASING.fault("coordinates"))


#: A response as a run yields it: one number, or a curve.
Measured: TypeAlias = Response | Curve


def scalars(found: Mapping[str, Measured]) -> dict[str, Response]:
    """Return the responses that are one number."""
    return {name: one for name, one in found.items() if isinstance(one, Response)}


def curves(found: Mapping[str, Measured]) -> dict[str, Curve]:
    """Return the responses that are curves."""
    return {name: one for name, one in found.items() if isinstance(one, Curve)}
