"""Four corners of a level rectangle in a picture: they tell where up is, as a marker sheet does."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.photographs import messages
from grainfit.photographs.marker import MarkerSheet
from grainfit.photographs.pictures import opencv

#: Standard uncertainty of a place that is given by hand, pixels, and of being level, degrees.
_PLACE, _LEVEL = 1.0, 0.2
#: Largest cosine of the angle of two sides, and largest ratio of the sides to the given ones.
_SQUARE, _SHAPE = 0.15, 1.15


class Rectangle(MarkerSheet):
    """A level rectangle in a picture; its height is NaN where its sides are not known."""


def rectangle_of(
    points: Sequence[tuple[float, float]],
    focal: float,
    middle: tuple[float, float],
    sides: tuple[float, float] | None = None,
) -> Rectangle:
    """Return what the corners of a level rectangle tell.

    Its sides meet at two vanishing points, whose rays are at right angles to the vertical.

    Parameters
    ----------
    points : sequence of four pairs of float
        Columns and rows, in any order.
    focal : float
        Focal length, pixels.
    middle : tuple of float
        Where the optical axis is: column and row.
    sides : pair of float, optional
        Their lengths, m.

    Raises
    ------
    NotMeasurableError
        They are not those of a level rectangle, or not of one with these sides.
    """
    corners = np.array(points, np.float64)
    centre = corners.mean(axis=0)
    corners = corners[np.argsort(np.arctan2(*(corners - centre).T[::-1]))]
    edges = np.roll(corners, -1, axis=0) - corners
    turns = edges[:, 0] * np.roll(edges[:, 1], -1) - edges[:, 1] * np.roll(edges[:, 0], -1)
    if (turns <= 4.0).any():
        raise NotMeasurableError(messages.NO_RECTANGLE())
    rays, up = _plane(corners, focal, middle)
    lengths = np.linalg.norm(rays, axis=0)
    if abs(float(rays[:, 0] @ rays[:, 1])) > _SQUARE * lengths[0] * lengths[1]:
        raise NotMeasurableError(messages.NOT_LEVEL())
    place = rays @ [0.5, 0.5, 1.0]
    towards = place / np.linalg.norm(place)
    elevation = _elevation(up, towards)
    changes = []
    for corner, axis in np.ndindex(4, 2):
        moved = corners.copy()
        moved[corner, axis] += _PLACE
        changes.append(_elevation(_plane(moved, focal, middle)[1], towards) - elevation)
    height = math.nan
    if sides is not None:
        ratio = float(lengths[0] / lengths[1])
        first, second = sorted(
            (sides, sides[::-1]), key=lambda pair: abs(math.log(ratio * pair[1] / pair[0]))
        )[0]
        if abs(math.log(ratio * second / first)) > math.log(_SHAPE):
            raise NotMeasurableError(messages.OTHER_SHAPE(ratio=max(ratio, 1 / ratio)))
        height = float(-up @ rays[:, 2]) / math.sqrt(lengths[0] * lengths[1] / (first * second))
    return Rectangle(up, elevation, math.hypot(_LEVEL, *changes), corners, height)


def _plane(corners: Array, focal: float, middle: tuple[float, float]) -> tuple[Array, Array]:
    """Return rays along two sides and to a corner, in one scale, and the upward direction."""
    unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    shift = np.array([[1, 0, -middle[0]], [0, 1, -middle[1]], [0, 0, focal]]) / focal
    rays = shift @ opencv().getPerspectiveTransform(unit, corners.astype(np.float32))
    # Before the camera.
    rays *= math.copysign(1.0, float(rays[2] @ [0.5, 0.5, 1.0]))
    up = np.cross(rays[:, 0], rays[:, 1])
    up /= np.linalg.norm(up)
    up *= -math.copysign(1.0, float(up @ rays[:, 2]))
    return rays, up


def _elevation(up: Array, towards: Array) -> float:
    return math.degrees(math.asin(float(np.clip(-(up @ towards), -1, 1))))
