"""Distances of places from walls: negative within a solid one, and behind a plane."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from grainfit.arrays import Array
from grainfit.scenes.scene import Box
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Mesh, Plane, Prism, Shape
from grainfit.scenes.stl import mesh_triangles

#: Walls about an axis, without a thickness.
Round = Cylinder | Cone | Disc | Annulus


def distances(shape: Shape, box: Box, places: Array, reach: float) -> Array:
    """Return the distances of places, shape (n, 3), from a wall, m.

    Those from a `Mesh` are infinite beyond a reach.
    """
    if isinstance(shape, Plane):
        way = places[:, "xyz".index(shape.axis)] - shape.at
        return np.asarray(way if shape.upwards else -way)
    if isinstance(shape, Block | Prism):
        return _from_solid(shape, box, places)
    if isinstance(shape, Mesh):
        return _from_triangles(mesh_triangles(shape, box), places, reach)
    radii, ends = _outline(shape)
    axis = "xyz".index(_axis(shape))
    if _axis(shape) in box.periodic:
        ends = box.beyond(_axis(shape))
    away = np.linalg.norm(np.delete(places, axis, axis=1), axis=1)
    line = zip(radii, ends, strict=True)
    return _from_lines(np.column_stack((away, places[:, axis])), [line])


def ends_along(shape: Round, axis: str) -> tuple[float, float]:
    """Return the ends of a round wall along one of x, y and z, m."""
    radii, ends = _outline(shape)
    return ends if axis == _axis(shape) else (-max(radii), max(radii))


def _axis(shape: Round) -> str:
    return shape.axis if isinstance(shape, Cylinder) else "z"


def _outline(shape: Round) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the radii of a round wall at both ends, and where these are on its axis, m."""
    if isinstance(shape, Cylinder):
        return (shape.radius, shape.radius), (shape.bottom, shape.top)
    if isinstance(shape, Cone):
        return (shape.lower_radius, shape.upper_radius), (shape.bottom, shape.top)
    if isinstance(shape, Disc):
        return (0.0, shape.radius), (shape.z, shape.z)
    return (shape.inner_radius, shape.outer_radius), (shape.z, shape.z)


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


def _from_triangles(triangles: Array, places: Array, reach: float) -> Array:
    """Return distances from the nearest of triangles, shape (m, 3, 3), that is within reach."""
    centres = triangles.mean(axis=1)
    spans = np.linalg.norm(triangles - centres[:, None], axis=2).max(axis=1)
    around = cKDTree(places).query_ball_point(centres, spans + reach)
    theirs = np.repeat(np.arange(len(triangles)), [len(own) for own in around])
    pairs = np.fromiter(chain.from_iterable(around), np.int64, len(theirs))
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    heights = ((places[pairs] - triangles[theirs, 0]) * normals[theirs]).sum(axis=1)
    near = np.abs(heights) < reach
    pairs, theirs, heights = pairs[near], theirs[near], heights[near]
    found = np.full(len(places), np.inf)
    away = _beside(places[pairs], triangles[theirs], normals[theirs])
    np.minimum.at(found, pairs, np.where(away > 0, away, np.abs(heights)))
    return found


def _beside(places: Array, triangles: Array, normals: Array) -> Array:
    """Return the distance of each place from the sides of its triangle; 0 above or below it."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    ways = places[:, None] - triangles
    is_over = ((np.cross(sides, ways) * normals[:, None]).sum(axis=2) >= 0).all(axis=1)
    shares = np.clip((ways * sides).sum(axis=2) / (sides**2).sum(axis=2), 0.0, 1.0)
    from_sides = np.linalg.norm(ways - shares[..., None] * sides, axis=2).min(axis=1)
    return np.asarray(np.where(is_over, 0.0, from_sides))


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
