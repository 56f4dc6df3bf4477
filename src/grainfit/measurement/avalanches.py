"""Standard error of the mean of a series that avalanches interrupt.

The inclination of a bed in a slow drum rises until an avalanche takes it down again. Its values are
correlated, first positively and then, half an avalanche apart, negatively. A standard error from an
autocorrelation that is summed up to its first small value leaves out the negative part and is far
too large; the means of whole avalanches are nearly independent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement import messages

#: A series has passed its mean once it is this many standard deviations beyond it.
_BAND = 0.2
#: Fewest whole avalanches whose means can be compared.
_FEWEST = 3


@dataclass(frozen=True)
class Avalanches:
    """Whole avalanches of a series: from one rise through its mean to the next.

    Parameters
    ----------
    bounds : tuple of int
        Indices at which they begin, and the one after the last.
    length : int
        Length of the series.
    """

    bounds: tuple[int, ...]
    length: int

    def __len__(self) -> int:
        return len(self.bounds) - 1

    @property
    def parts(self) -> list[slice]:
        """The part of each avalanche."""
        return [slice(*ends) for ends in pairwise(self.bounds)]

    def means(self, series: Array) -> Array:
        """Return the mean of a series over each avalanche."""
        return np.array([series[part].mean() for part in self.parts])

    def standard_error(self, means: Array) -> float:
        """Return the standard error of the series' mean, from the mean over each avalanche."""
        return float(np.std(means, ddof=1)) / math.sqrt(self._count)

    @property
    def _count(self) -> float:
        """Number of avalanches in the series, with the incomplete ones at its ends."""
        return self.length * len(self) / (self.bounds[-1] - self.bounds[0])

    def drift(self, series: Array) -> Response:
        """Return the mean of the later half of the series minus that of the earlier half."""
        half, means = len(series) // 2, self.means(series)
        # Around a line, so that a drift does not hide in its own scatter.
        times = [(part.start + part.stop) / 2 for part in self.parts]
        residuals = means - np.polyval(np.polyfit(times, means, 1), times)
        variance = float(residuals @ residuals) / (len(means) - 2)
        change = float(series[-half:].mean() - series[:half].mean())
        return Response(change, math.sqrt(variance * 4 / self._count))


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
        found = max(len(bounds) - 1, 0)
        raise NotMeasurableError(messages.FEW_AVALANCHES(found=found, needed=_FEWEST))
    return Avalanches(tuple(bounds), len(series))
