"""Distances of places from walls: negative within a solid one, and behind a plane."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array
from grainfit.scenes.scene import Box
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Mesh, Plane, Prism, Shape


def distances(shape: Shape, box: Box, places: Array) -> Array:
    """Return the distances of places, shape (n, 3), from a wall, m; infinite from a `Mesh`."""
    if isinstance(shape, Plane):
        way = places[:, "xyz".index(shape.axis)] - shape.at
        return np.asarray(way if shape.upwards else -way)
    if isinstance(shape, Block | Prism):
        return _from_solid(shape, box, places)
    if isinstance(shape, Mesh):
        return np.full(len(places), np.inf)
    axis, *ends = _outline(shape, box)
    radii = np.linalg.norm(np.delete(places, axis, axis=1), axis=1)
    return _from_lines(np.column_stack((radii, places[:, axis])), [ends])


def _outline(shape: Cylinder | Cone | Disc | Annulus, box: Box) -> tuple[int, ArrayLike, ArrayLike]:
    """Return the axis of a round wall, and its ends as distances from and along the axis, m."""
    if isinstance(shape, Cylinder):
        ends = shape.bottom, shape.top
        if shape.axis in box.periodic:
            ends = box.beyond(shape.axis)
        return "xyz".index(shape.axis), (shape.radius, ends[0]), (shape.radius, ends[1])
    if isinstance(shape, Cone):
        return 2, (shape.lower_radius, shape.bottom), (shape.upper_radius, shape.top)
    if isinstance(shape, Disc):
        return 2, (0.0, shape.z), (shape.radius, shape.z)
    return 2, (shape.inner_radius, shape.z), (shape.outer_radius, shape.z)


def _from_solid(shape: Block | Prism, box: Box, places: Array) -> Array:
    """Return distances from a block or a prism, which goes on through each period."""
    limits = [
        box.beyond(axis) if axis in box.periodic else (low, high)
        for axis, low, high in zip("xyz", shape.low, shape.high, strict=True)
    ]
    (left, right), (front, back), (bottom, top) = limits
    shift = shape.shift if isinstance(shape, Prism) else 0.0
    x, y, z = places.T
    upright = x - shift * (z - bottom) / (top - bottom)
    is_within = (upright > left) & (upright < right) & (z > bottom) & (z < top)
    corners = [(left, bottom), (right, bottom), (right + shift, top), (left + shift, top)]
    sides = zip(corners, [*corners[1:], corners[0]], strict=True)
    away = np.where(is_within, -1.0, 1.0) * _from_lines(np.column_stack((x, z)), sides)
    beyond = np.maximum(front - y, y - back)
    outside = np.hypot(np.maximum(away, 0.0), np.maximum(beyond, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(away, beyond), 0.0))


def _from_lines(places: Array, lines: Iterable[Iterable[ArrayLike]]) -> Array:
    """Return the distances of places in a plane, shape (n, 2), from the nearest of some lines."""
    found = np.full(len(places), np.inf)
    for ends in lines:
        start, end = map(np.asarray, ends)
        way = end - start
        share = np.clip((places - start) @ way / (way @ way), 0.0, 1.0)
        nearest = start + share[:, None] * way
        found = np.minimum(found, np.linalg.norm(places - nearest, axis=1))
    return found
