"""Inclination of piles and wedges between parallel walls, from their surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement import messages
from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.height_map import HeightMap

#: The flanks are fitted between these parts of the height, and above the lowest layer.
_WINDOW = (0.1, 0.9)
_LOWEST_LAYER = 1.0
#: A surface lower than this, in diameters, has no flank but single particles; a flank shorter than
#: this is a step.
_LOWEST, _SHORTEST = 2.5, 2.0
#: Columns nearer to a wall than this, in diameters, are not fitted.
_WALL = 1.0
#: Thickness of the slices along the depth whose inclinations are compared, in diameters.
_SLICE = 2.0
#: Depth that counts as one independent inclination, in diameters: with these, standard errors are
#: the scatter from seed to seed of twelve draw-downs with a depth of 10 diameters (stated over
#: observed 0.96 for heaps and 1.03 for wedges). Avalanches on a heap are wider than on a wedge.
_PILE_CORRELATION, WEDGE_CORRELATION = 10.0, 5.0
#: Flanks outside these inclinations are a layer or a wall, degrees.
_LIMITS = (2.0, 70.0)


@dataclass(frozen=True)
class Inclination:
    """Inclination of the two flanks of a pile, or of the two wedges beside a slot.

    Parameters
    ----------
    value : float
        Mean inclination, degrees.
    standard_error : float
        Of `value` as the mean of many such piles, degrees.
    flanks : tuple of Flank
        The fitted lines, left and right, in x and the height above the ground.
    """

    value: float
    standard_error: float
    flanks: tuple[Flank, ...]

    @property
    def response(self) -> Response:
        """Value and standard error, degrees."""
        return Response(self.value, self.standard_error)


def inclination_of_pile(surface: HeightMap, diameter: float) -> Inclination:
    """Measure the inclination of a pile whose ridge is near x = 0 and runs along y.

    Each flank is fitted between 10 and 90 % of the height, and above the lowest layer.

    Parameters
    ----------
    surface : HeightMap
        Of the pile, on a floor at height 0.
    diameter : float
        Median particle diameter, m.

    Raises
    ------
    NotMeasurableError
        There is no pile with two flanks, and why.
    """
    return _measured(surface, diameter, _outward(surface, 0.0), _PILE_CORRELATION)


def inclination_of_wedges(surface: HeightMap, slot: float, diameter: float) -> Inclination:
    """Measure the inclination of the two wedges that are left beside a slot at x = 0.

    Parameters
    ----------
    surface : HeightMap
        From wall to wall, above a shelf at height 0.
    slot : float
        Width of the slot, m.
    diameter : float
        Median particle diameter, m.

    Raises
    ------
    NotMeasurableError
        There are no two wedges, and why.
    """
    inside = np.abs(surface.x) > slot / 2
    sides = _inward(surface, inside, _WALL * diameter)
    return _measured(surface, diameter, sides, WEDGE_CORRELATION)


@dataclass(frozen=True)
class _Side:
    """Columns of one side, from the top of the surface down to its foot."""

    x: Array
    columns: NDArray[np.int64]

    @property
    def distance(self) -> Array:
        """Distance along x from the first column, m."""
        distance: Array = np.abs(self.x - self.x[0])
        return distance


def _outward(surface: HeightMap, middle: float) -> list[_Side]:
    right = np.flatnonzero(surface.x > middle)
    left = np.flatnonzero(surface.x < middle)[::-1]
    return [_Side(surface.x[side], side) for side in (left, right)]


def _inward(surface: HeightMap, inside: NDArray[np.bool_], margin: float) -> list[_Side]:
    half = float(np.abs(surface.x).max())
    used = inside & (np.abs(surface.x) < half - margin)
    left = np.flatnonzero(used & (surface.x < 0))
    right = np.flatnonzero(used & (surface.x > 0))[::-1]
    return [_Side(surface.x[side], side) for side in (left, right)]


def _measured(
    surface: HeightMap, diameter: float, sides: list[_Side], correlation: float
) -> Inclination:
    slices = surface.slices(_SLICE * diameter)
    top = _top(surface, diameter)
    if top < _LOWEST * diameter:
        raise NotMeasurableError(messages.LOW_PILE(height=top / diameter, needed=_LOWEST))
    angles, flanks = [], []
    for side in sides:
        window = _window(surface, side, top, diameter)
        distance, heights = side.distance[window], slices[:, side.columns[window]]
        found = [_angle(distance, row) for row in heights]
        angles.append(found)
        flanks.append(_flank(side.x[window], heights.mean(axis=0)))
    for flank in flanks:
        if not _LIMITS[0] <= flank.angle <= _LIMITS[1]:
            low, high = _LIMITS
            shown = messages.FLANK_INCLINATION(angle=flank.angle, low=low, high=high)
            raise NotMeasurableError(shown)
    value = float(np.mean([flank.angle for flank in flanks]))
    error = error_of_mean(np.array(angles), surface.depth, correlation * diameter)
    return Inclination(value, error, tuple(flanks))


def error_of_mean(values: Array, depth: float, correlation: float) -> float:
    """Standard error of the mean of values of slices that are correlated along the depth.

    Parameters
    ----------
    values : ndarray of shape (sides, slices)
        Values of neighbouring slices of each side.
    depth, correlation : float
        Depth of all slices together, and depth that counts as one independent value, m.
    """
    independent = values.size * min(1.0, depth / values.shape[1] / correlation)
    return float(np.std(values)) / math.sqrt(max(independent - 1, 1.0))


def _top(surface: HeightMap, diameter: float) -> float:
    """Height of the surface's highest part, averaged over a diameter."""
    return float(_smooth(surface, diameter).max())


def _smooth(surface: HeightMap, diameter: float) -> Array:
    size = max(1, round(diameter / (surface.x[1] - surface.x[0])))
    padded = np.pad(surface.profile, size, mode="edge")
    smooth: Array = np.convolve(padded, np.ones(size) / size, "same")[size:-size]
    return smooth


def _window(surface: HeightMap, side: _Side, top: float, diameter: float) -> slice:
    """Columns of a flank, chosen by position: choosing by height would bias the slope."""
    profile = _smooth(surface, diameter)[side.columns]
    low, high = max(_WINDOW[0] * top, _LOWEST_LAYER * diameter), _WINDOW[1] * top
    above = np.flatnonzero(profile > high)
    begin = int(above[-1]) + 1 if len(above) else 0
    below = np.flatnonzero(profile[begin:] < low)
    end = begin + int(below[0]) if len(below) else len(profile)
    if end - begin < 2 or side.distance[end - 1] - side.distance[begin] < _SHORTEST * diameter:
        raise NotMeasurableError(messages.STEPS(height=top / diameter))
    return slice(begin, end)


def _angle(distance: Array, heights: Array) -> float:
    slope = float(np.polyfit(distance, heights, 1)[0])
    return math.degrees(math.atan(-slope))


def _flank(x: Array, heights: Array) -> Flank:
    slope, intercept = (float(value) for value in np.polyfit(x, heights, 1))
    lower, upper = float(x[-1]), float(x[0])
    angle = math.degrees(math.atan(slope * math.copysign(1.0, upper - lower)))
    return Flank(angle, (lower, intercept + slope * lower), (upper, intercept + slope * upper))
