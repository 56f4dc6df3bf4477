"""Outlines of photographed heaps as curves: height over the distance from the axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.photographs import messages
from grainfit.photographs.kept import KeptPicture

#: Distance between two points, in particle diameters: the outline is averaged over as much.
_STEP = 2.0
_FEWEST, _MOST = 5, 40
#: Any number of pictures shows so many independent sides of one heap.
_INDEPENDENT_SIDES = 6
#: Standard uncertainty of the length of a pixel, relative, and of the height of the plate, in
#: particle diameters (apex of twelve rendered heaps: -0.25 in the mean, 0.15 scatter).
_SCALE, _PLATE = 0.01, 0.25


@dataclass(frozen=True)
class Outlines:
    """Curves of several sides or heaps at the same distances, m.

    Parameters
    ----------
    distances : ndarray of shape (n,)
        From the axis.
    heights : ndarray of shape (k, n)
        Above the plate: of each heap, or of the sides of a single one.
    systematic : ndarray of shape (n,)
        Standard uncertainty that all of them share: of the camera, the separation and the scale.
    """

    distances: Array
    heights: Array
    systematic: Array


def outlines_of(heaps: Sequence[Sequence[KeptPicture]]) -> Outlines:
    """Return the outlines of heaps, down to where the foot begins.

    Parameters
    ----------
    heaps : sequence of sequence of KeptPicture
        Pictures of each heap, with a known scale.

    Raises
    ------
    NotMeasurableError
        The scale of a picture is not known, or a heap is too small for a curve.
    """
    pictures = [picture for heap in heaps for picture in heap]
    if any(picture.scale is None for picture in pictures):
        raise NotMeasurableError(messages.NO_SCALE())
    step = _STEP * max((one.scale or 0.0) * one.diameter for one in pictures)
    reach = min(map(_reach, pictures))
    count = min(int(reach / step) + 1, _MOST)
    if count < _FEWEST:
        raise NotMeasurableError(messages.SHORT_OUTLINE(count=count, needed=_FEWEST))
    distances = np.linspace(0.0, reach, count)
    sides = [[side for one in heap for side in _sides(one, distances)] for heap in heaps]
    heights = np.array([np.mean(of_heap, axis=0) for of_heap in sides])
    if len(heaps) == 1:
        groups = min(len(sides[0]), _INDEPENDENT_SIDES)
        heights = np.array([np.mean(sides[0][i::groups], axis=0) for i in range(groups)])
    mean = heights.mean(axis=0)
    of_scale = _SCALE * np.abs(mean - distances * np.gradient(mean, distances))
    of_pictures, of_plate = _of_pictures(pictures) * mean, _PLATE * step / _STEP
    systematic = np.sqrt(of_scale**2 + of_pictures**2 + of_plate**2)
    return Outlines(distances, heights, systematic)


def _sides(picture: KeptPicture, distances: Array) -> tuple[Array, Array]:
    scale = picture.scale or 0.0
    across, heights = (scale * np.array(values) for values in picture.outline)
    left, right = (np.interp(side * distances, across, heights) for side in (-1, 1))
    return left, right


def _reach(picture: KeptPicture) -> float:
    """Return the distance from the axis, m, at which the outline of one side reaches the foot."""
    across, heights = (np.array(values) for values in picture.outline)
    flank = across[heights > picture.ground]
    return (picture.scale or 0.0) * float(min(-flank.min(), flank.max()))


def _of_pictures(pictures: Sequence[KeptPicture]) -> float:
    """Relative standard uncertainty of heights by what makes angles uncertain in one picture.

    A height is proportional to the tangent of the angle, whose relative error is that of the angle
    times 2 / sin(2 angle).
    """
    squares = []
    for one in pictures:
        parts = {name: part for name, part in one.parts.items() if name != "particle size"}
        error = math.radians(math.sqrt(sum(part**2 for part in parts.values())))
        squares.append((2 * error / math.sin(math.radians(2 * one.angle))) ** 2)
    return math.sqrt(float(np.mean(squares)))
