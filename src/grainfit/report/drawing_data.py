"""Data of drawings in three dimensions, as the script of the particles reads them."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: The largest number that a length becomes.
LARGEST = 32_000

Colour = tuple[int, int, int]


@dataclass(frozen=True)
class DrawingScale:
    """Scale of a drawing, in which all lengths are small whole numbers.

    Parameters
    ----------
    step : float
        Length of the number 1, m.
    """

    step: float

    @classmethod
    def of(cls, *lengths: ArrayLike) -> Self:
        """Return the scale in which the largest of these lengths, m, is `LARGEST`."""
        return cls(max(float(np.abs(some).max()) for some in map(np.asarray, lengths)) / LARGEST)

    def packed(self, lengths: ArrayLike) -> str:
        """Return lengths, m, as text, two bytes for each."""
        return packed(np.asarray(lengths) / self.step)

    def listed(self, lengths: ArrayLike) -> list[Any]:
        """Return lengths, m, as nested lists of whole numbers."""
        found: list[Any] = np.round(np.asarray(lengths) / self.step).tolist()
        return found

    def spheres(self, positions: ArrayLike, radii: ArrayLike) -> str:
        """Return spheres as text: place and radius of each, m."""
        return self.packed(np.column_stack([positions, radii]))

    def outlines(self, lines: Iterable[ArrayLike]) -> list[Any]:
        """Return polylines through points, m."""
        return [self.listed(line) for line in lines]

    def wall(self, triangles: ArrayLike, colour: Colour) -> dict[str, Any]:
        """Return a wall of triangles, m, in a colour."""
        return {"triangles": self.packed(triangles), "colour": colour}

    def glued(self, positions: ArrayLike, radii: ArrayLike, colour: Colour) -> dict[str, Any]:
        """Return a glued set, m, in a colour."""
        return {"particles": self.spheres(positions, radii), "colour": colour}


def packed(values: NDArray[np.floating]) -> str:
    """Return values that are not above `LARGEST` as text, two bytes for each."""
    return base64.b64encode(np.round(values).astype("<i2").tobytes()).decode("ascii")
