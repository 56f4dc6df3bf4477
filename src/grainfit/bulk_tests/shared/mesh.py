"""Triangle meshes of the cylinder and the plate, for solvers that take walls as STL files."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_Triangles = NDArray[np.float64]
_PLATE_FACETS = 40


def write_cylinder(path: Path, radius: float, bottom: float, top: float, edge: float) -> None:
    """Write an open upright cylinder about the z axis; no facet is much wider than ``edge``."""
    facets = max(24, math.ceil(2 * math.pi * radius / edge))
    # Triangles longer than a few facets are worse for the solver's neighbour search than many.
    levels = np.linspace(bottom, top, max(2, int((top - bottom) / (5 * edge))) + 1)
    _write_stl(path, _tube(radius, levels, facets))


def write_plate(path: Path, radius: float, rim_height: float) -> None:
    """Write a horizontal disc at z = 0, with an upright rim where its height is above 0."""
    edge = _ring(radius, 0.0, _PLATE_FACETS)
    centre = np.zeros_like(edge)
    triangles = np.stack((centre, edge, np.roll(edge, -1, axis=0)), axis=1)
    if rim_height > 0:
        rim = _tube(radius, np.array([0.0, rim_height]), _PLATE_FACETS)
        triangles = np.concatenate((triangles, rim))
    _write_stl(path, triangles)


def _ring(radius: float, z: float, facets: int) -> NDArray[np.float64]:
    """Corners of a polygon with the area of the circle, shape (facets, 3)."""
    corner = radius * math.sqrt(2 * math.pi / facets / math.sin(2 * math.pi / facets))
    angle = np.arange(facets) * 2 * math.pi / facets
    return np.column_stack((corner * np.cos(angle), corner * np.sin(angle), np.full(facets, z)))


def _tube(radius: float, levels: NDArray[np.float64], facets: int) -> _Triangles:
    """Triangles between rings at these heights, shape (n, 3, 3)."""
    triangles = []
    for low, high in itertools.pairwise(levels):
        lower, upper = _ring(radius, low, facets), _ring(radius, high, facets)
        next_lower, next_upper = np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0)
        triangles.append(np.stack((lower, next_lower, next_upper), axis=1))
        triangles.append(np.stack((lower, next_upper, upper), axis=1))
    return np.concatenate(triangles)


def _write_stl(path: Path, triangles: _Triangles) -> None:
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    lines = ["solid wall"]
    for normal, corners in zip(normals, triangles, strict=True):
        lines.append("facet normal {:.7g} {:.7g} {:.7g}\n  outer loop".format(*normal))
        lines += ["    vertex {:.9g} {:.9g} {:.9g}".format(*corner) for corner in corners]
        lines.append("  endloop\nendfacet")
    lines.append("endsolid wall\n")
    path.write_text("\n".join(lines), encoding="ascii")
