"""Triangles of walls, for solvers that take them as STL files."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grainfit.scenes.scene import Box
from grainfit.scenes.shapes import (
    Annulus,
    Block,
    Cone,
    Cylinder,
    Disc,
    Mesh,
    Plane,
    Prism,
    Shape,
    Vector,
)
from grainfit.scenes.stl import mesh_triangles

#: Shape (n, 3, 3): corners of n triangles, m.
Triangles = NDArray[np.float64]
_DISC_FACETS = 40


def triangles_of(shape: Shape, box: Box, edge: float) -> Triangles:
    """Return the triangles of a wall.

    Parameters
    ----------
    shape : Shape
        The shape of the wall.
    box : Box
        The simulated space: infinite walls end with it.
    edge : float
        No facet of a tube is much wider, m.

    Raises
    ------
    InputError
        The file of a `Mesh` is no STL file, see `grainfit.scenes.stl.read_stl`.
    """
    if isinstance(shape, Mesh):
        return mesh_triangles(shape, box)
    if isinstance(shape, Cylinder):
        return _cylinder(shape, box, edge)
    if isinstance(shape, Cone):
        return _tube(shape.lower_radius, shape.upper_radius, shape.bottom, shape.top, edge)
    if isinstance(shape, Disc):
        return _disc(shape.radius, shape.z)
    if isinstance(shape, Annulus):
        return _annulus(shape, edge)
    if isinstance(shape, Plane):
        return _plane(shape, box)
    if isinstance(shape, Prism):
        return _prism(shape, box)
    assert isinstance(shape, Block)
    return _block(shape, box)


def _ring(radius: float, z: float, facets: int) -> NDArray[np.float64]:
    """Corners of a polygon with the area of the circle, shape (facets, 3)."""
    corner = radius * math.sqrt(2 * math.pi / facets / math.sin(2 * math.pi / facets))
    angle = np.arange(facets) * 2 * math.pi / facets
    return np.column_stack((corner * np.cos(angle), corner * np.sin(angle), np.full(facets, z)))


def _between(lower: NDArray[np.float64], upper: NDArray[np.float64]) -> Triangles:
    """Triangles between two rings with as many corners."""
    next_lower, next_upper = np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0)
    return np.concatenate(
        (
            np.stack((lower, next_lower, next_upper), axis=1),
            np.stack((lower, next_upper, upper), axis=1),
        )
    )


def _facets(radius: float, edge: float) -> int:
    return max(24, math.ceil(2 * math.pi * radius / edge))


def _tube(
    lower: float, upper: float, bottom: float, top: float, edge: float, fewest: int = 2
) -> Triangles:
    """Return a tube or funnel about the z axis, of at least so many rings of triangles."""
    facets = _facets(max(lower, upper), edge)
    # Triangles longer than a few facets are worse for the solver's neighbour search than many.
    levels = np.linspace(bottom, top, max(fewest, int((top - bottom) / (5 * edge))) + 1)
    radii = np.linspace(lower, upper, len(levels))
    rings = [_ring(radius, z, facets) for radius, z in zip(radii, levels, strict=True)]
    return np.concatenate([_between(low, high) for low, high in itertools.pairwise(rings)])


def _cylinder(shape: Cylinder, box: Box, edge: float) -> Triangles:
    """Return a tube about its own axis; along a periodic axis from end to end of the box."""
    if shape.axis == "z":
        return _tube(shape.radius, shape.radius, shape.bottom, shape.top, edge)
    axis = "xyz".index(shape.axis)
    ends, parts = (shape.bottom, shape.top), 2
    if shape.axis in box.periodic:
        ends = (box.low[axis], box.high[axis])
        parts = max(parts, math.ceil((ends[1] - ends[0]) / box.longest_element))
    upright = _tube(shape.radius, shape.radius, *ends, edge, parts)
    # Cyclic: z becomes the axis, and normals keep their sense.
    return np.roll(upright, axis - 2, axis=2)


def _disc(radius: float, z: float) -> Triangles:
    edge = _ring(radius, z, _DISC_FACETS)
    centre = np.zeros_like(edge)
    centre[:, 2] = z
    return np.stack((centre, edge, np.roll(edge, -1, axis=0)), axis=1)


def _annulus(shape: Annulus, edge: float) -> Triangles:
    facets = _facets(shape.outer_radius, edge)
    inner = _ring(shape.inner_radius, shape.z, facets)
    return _between(inner, _ring(shape.outer_radius, shape.z, facets))


def _plane(shape: Plane, box: Box) -> Triangles:
    axis = "xyz".index(shape.axis)
    low, high = list(box.low), list(box.high)
    low[axis] = high[axis] = shape.at
    ends = (low[0], low[1], low[2]), (high[0], high[1], high[2])
    return _face(*ends, axis, box.longest_element)


def _block(shape: Block, box: Box, stretch: float = 1.0) -> Triangles:
    """Return the faces of a block within the box; it has no ends along a periodic axis.

    Its elements are shorter by a factor by which they are stretched afterwards.
    """
    low, high = np.array(shape.low, dtype=float), np.array(shape.high, dtype=float)
    for axis, name in enumerate("xyz"):
        if name in box.periodic:
            low[axis], high[axis] = box.low[axis], box.high[axis]
    low, high = np.maximum(low, box.low), np.minimum(high, box.high)
    faces = []
    for axis, name in enumerate("xyz"):
        if name in box.periodic:
            continue
        for at in (low[axis], high[axis]):
            if not box.low[axis] < at < box.high[axis]:
                continue
            start, end = low.copy(), high.copy()
            start[axis] = end[axis] = at
            faces.append(_face(tuple(start), tuple(end), axis, box.longest_element / stretch))
    return np.concatenate(faces)


def _prism(shape: Prism, box: Box) -> Triangles:
    """Return the faces of a prism; it has no ends along a periodic y axis."""
    slope = shape.shift / (shape.high[2] - shape.low[2])
    # A little around it, so that none of its faces is beyond the box that cuts a block.
    low, high = np.array(shape.low) - 1, np.array(shape.high) + 1
    period = (box.low[1], box.high[1]) if "y" in box.periodic else (low[1], high[1])
    around = Box((low[0], period[0], low[2]), (high[0], period[1], high[2]), box.periodic)
    # Its sides are longer than those of the block.
    triangles = _block(Block(shape.low, shape.high), around, math.hypot(1, slope))
    triangles[..., 0] += slope * (triangles[..., 2] - shape.low[2])
    return triangles


def _face(low: Vector, high: Vector, axis: int, longest: float) -> Triangles:
    """Triangles of an axis-parallel rectangle, no longer than a length, m, along each axis."""
    across = [other for other in range(3) if other != axis]
    lines = []
    for other in across:
        length = high[other] - low[other]
        parts = max(1, math.ceil(length / longest))
        lines.append(np.linspace(low[other], high[other], parts + 1))
    triangles = []
    for (a, b), (c, d) in itertools.product(
        itertools.pairwise(lines[0]), itertools.pairwise(lines[1])
    ):
        corners = np.empty((4, 3))
        corners[:, axis] = low[axis]
        corners[:, across[0]] = (a, b, b, a)
        corners[:, across[1]] = (c, c, d, d)
        triangles += [corners[[0, 1, 2]], corners[[0, 2, 3]]]
    return np.array(triangles)


def write_stl(path: Path, triangles: Triangles) -> None:
    """Write triangles as a text STL file."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    lines = ["solid wall"]
    for normal, corners in zip(normals, triangles, strict=True):
        lines.append("facet normal {:.7g} {:.7g} {:.7g}\n  outer loop".format(*normal))
        lines += ["    vertex {:.9g} {:.9g} {:.9g}".format(*corner) for corner in corners]
        lines.append("  endloop\nendfacet")
    lines.append("endsolid wall\n")
    path.write_text("\n".join(lines), encoding="ascii")
