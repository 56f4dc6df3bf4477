"""Averages of a series that avalanches interrupt: over whole avalanches, with a standard error.

The inclination of a bed in a slow drum rises until an avalanche takes it down again. Its values are
correlated, first positively and then, half an avalanche apart, negatively. A standard error from an
autocorrelation that is summed up to its first small value leaves out the negative part and is far
too large; the means of whole avalanches are nearly independent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response

#: A series has passed its mean once it is this many standard deviations beyond it.
_BAND = 0.5
#: Fewest whole avalanches to average over.
_FEWEST = 3

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Avalanches:
    """Whole avalanches of a series: from one rise through its mean to the next.

    Parameters
    ----------
    bounds : tuple of int
        Indices at which they begin, and the one after the last.
    """

    bounds: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.bounds) - 1

    @property
    def all(self) -> slice:
        """The part of the series that whole avalanches cover."""
        return slice(self.bounds[0], self.bounds[-1])

    @property
    def parts(self) -> list[slice]:
        """The part of each avalanche."""
        return [slice(*ends) for ends in zip(self.bounds[:-1], self.bounds[1:], strict=True)]

    def mean(self, series: Array) -> Response:
        """Return the mean of a series over whole avalanches, and its standard error."""
        means = np.array([series[part].mean() for part in self.parts])
        return Response(float(series[self.all].mean()), self.standard_error(means))

    def standard_error(self, means: Array) -> float:
        """Return the standard error of a mean over all avalanches from the means of each."""
        return float(np.std(means, ddof=1)) / math.sqrt(len(means))

    def drift(self, series: Array) -> Response:
        """Return the mean of the later half of the avalanches minus that of the earlier half."""
        means = np.array([series[part].mean() for part in self.parts])
        half = len(means) // 2
        change = float(means[-half:].mean() - means[:half].mean())
        # Pooled: two halves of a few avalanches each have no standard deviations of their own.
        residuals = np.concatenate([part - part.mean() for part in (means[:half], means[-half:])])
        freedom = max(2 * half - 2, 1)
        return Response(change, math.sqrt(float(residuals @ residuals) / freedom * 2 / half))


def whole_avalanches(series: Array) -> Avalanches:
    """Find the whole avalanches of a series.

    Parameters
    ----------
    series : ndarray of shape (n,)
        Values at equal intervals, several for each avalanche.

    Raises
    ------
    NotMeasurableError
        There are fewer than three.
    """
    mean, band = float(series.mean()), _BAND * float(series.std())
    bounds: list[int] = []
    was_low = False
    for index, value in enumerate(series):
        if value < mean - band:
            was_low = True
        elif was_low and value > mean + band:
            below = np.flatnonzero(series[:index] < mean)
            bounds.append(int(below[-1]) + 1)
            was_low = False
    if len(bounds) <= _FEWEST:
        raise NotMeasurableError(
            f"there are {max(len(bounds) - 1, 0)} whole avalanches in the averaged turns, and "
            f"{_FEWEST} are needed; use a larger averaged_turns"
        )
    return Avalanches(tuple(bounds))
