"""The angle of repose of a heap in a three-dimensional scan: PLY, XYZ or STL."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from scipy import ndimage

from grainfit.arrays import Array
from grainfit.errors import InputError, NotMeasurableError
from grainfit.evaluation import Response
from grainfit.files import LARGEST_MESH, read_within
from grainfit.measurement.angle_of_repose import AngleOfRepose, angle_of_repose_in, azimuths_of
from grainfit.measurement.silhouette import Silhouette
from grainfit.photographs.heap import diameter_by_roughness
from grainfit.scenes.stl import read_stl
from grainfit.work_folder import messages

#: Formats, by the ends of their names.
SUFFIXES = (".ply", ".xyz", ".stl")
_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_FEWEST_POINTS = 2000
#: Planes that are tried as the ground, points that vote, and how near they are to it over the size.
_PLANES, _VOTERS, _NEAR = 3000, 1500, 0.004
#: Share of the points that a ground has at least, and that may lie below it.
_ON_GROUND, _BELOW = 0.05, 0.03
#: Width of a heap in cells of its height map; views; sectors around the axis that must have points.
_CELLS, _VIEWS, _SECTORS = 500, 12, 24
#: Largest share of the heap's area that a second one may have.
_SECOND = 0.2
#: Standard uncertainty of an estimated particle diameter, relative.
_ESTIMATED = 0.3


def is_scan(path: Path) -> bool:
    """Return whether a file is a scan, by the end of its name."""
    return path.suffix.lower() in SUFFIXES


def measure_scan(path: Path) -> Response:
    """Measure the angle of repose of a heap in a scan, on silhouettes from all sides.

    The ground is the plane that most points lie on; the heap stands on it. Lengths of a scan have
    any unit.

    Parameters
    ----------
    path : Path
        Points of heap and ground: PLY (text or binary), XYZ (three numbers a line) or STL.

    Returns
    -------
    Response
        Mean of the flanks of twelve silhouettes, and its standard uncertainty: between the sides
        of the heap, by the density of the points, and by the particle diameter, which is estimated
        by the roughness; degrees.

    Raises
    ------
    InputError
        The file cannot be read, and what to do.
    NotMeasurableError
        There is no ground, no heap, or not one heap with flanks all around.
    """
    points = read_points_of(path)
    if len(points) < _FEWEST_POINTS:
        raise InputError(
            messages.FEW_POINTS.fault("", count=len(points), needed=_FEWEST_POINTS), str(path)
        )
    heap = _one_heap(_upright(points))
    found = _from_all_sides(heap)
    by_size = _from_all_sides(heap, 1 + _ESTIMATED).value - found.value
    # What half of the points change, is what as many more would change.
    half = heap[np.random.default_rng(0).permutation(len(heap))[: len(heap) // 2]]
    try:
        by_density = _from_all_sides(half).value - found.value
    except NotMeasurableError:
        raise NotMeasurableError(messages.COARSE_SCAN()) from None
    return Response(found.value, math.hypot(found.standard_error, by_size, by_density))


def _from_all_sides(heap: Array, size: float = 1.0) -> AngleOfRepose:
    """Fit the flanks of a heap, with so many times the particle diameter that it shows."""
    azimuths = azimuths_of(_VIEWS)
    silhouettes = [_silhouette(heap, azimuth) for azimuth in azimuths]
    diameter = size * _diameter(silhouettes)
    return angle_of_repose_in(silhouettes, azimuths, diameter, diameter)


def read_points_of(path: Path) -> Array:
    """Read the points of a scan, shape (n, 3), in its unit.

    Raises
    ------
    InputError
        The file is damaged or of another kind.
    """
    if path.suffix.lower() == ".stl":
        return read_stl(path).triangles.reshape(-1, 3)
    try:
        content = read_within(path, LARGEST_MESH)
        points = _ply(content) if path.suffix.lower() == ".ply" else _xyz(content)
    except (OSError, ValueError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(messages.NO_SCAN.fault("", reason=reason), str(path)) from error
    return points[np.isfinite(points).all(axis=1)]


def _xyz(content: bytes) -> Array:
    text = content.decode("utf-8-sig")
    rows = [re.split(r"[\s,;]+", line.strip())[:3] for line in text.splitlines() if line.strip()]
    # A first line may have names, or the number of points.
    first = next((i for i, row in enumerate(rows[:3]) if len(row) == 3 and _are_numbers(row)), 0)
    return np.array(rows[first:], dtype=np.float64)


def _are_numbers(row: list[str]) -> bool:
    return all(re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", cell) for cell in row)


def _ply(content: bytes) -> Array:
    """Read the vertices of a PLY file, which are its first element."""
    end = content.find(b"end_header")
    if not content.startswith(b"ply") or end < 0:
        raise ValueError("it has no header of a PLY file")
    header = [line.split() for line in content[:end].decode("ascii").splitlines()]
    kind = next((row[1] for row in header if row[:1] == ["format"]), "")
    count, columns = _vertices([row for row in header if row[:1] in (["element"], ["property"])])
    body = content[content.index(b"\n", end) + 1 :]
    if kind == "ascii":
        lines = body.decode("ascii").splitlines()[:count]
        if len(lines) < count:
            raise ValueError(f"it has {len(lines)} of {count} vertices: it is cut off")
        places = [list(columns).index(name) for name in "xyz"]
        return np.array([[line.split()[at] for at in places] for line in lines], dtype=np.float64)
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(kind)
    if order is None:
        raise ValueError(f"its format is {kind!r}")
    record = np.dtype([(name, order + one) for name, one in columns.items()])
    if len(body) < count * record.itemsize:
        raise ValueError(f"it ends before the last of its {count} vertices: it is cut off")
    found = np.frombuffer(body, record, count)
    return np.column_stack([found[name] for name in "xyz"]).astype(np.float64)


def _vertices(rows: list[list[str]]) -> tuple[int, dict[str, str]]:
    """Return the number of vertices, and the types of their properties."""
    if not rows or rows[0][:2] != ["element", "vertex"]:
        raise ValueError("its first element is not vertex")
    columns: dict[str, str] = {}
    for row in rows[1:]:
        if row[0] == "element":
            break
        if row[1] not in _TYPES:
            raise ValueError(f"a vertex has a property of type {row[1]}")
        columns[row[2]] = _TYPES[row[1]]
    if missing := [name for name in "xyz" if name not in columns]:
        raise ValueError(f"its vertices have no {', '.join(missing)}")
    return int(rows[0][2]), columns


def _upright(points: Array) -> Array:
    """Turn the ground to z = 0, and the heap upward.

    Raises
    ------
    NotMeasurableError
        No plane is the ground: with many points on it, and the others on one side.
    """
    rng = np.random.default_rng(0)
    points = points - np.median(points, axis=0)
    size = float(np.percentile(np.linalg.norm(points, axis=1), 95))
    voters = points[rng.permutation(len(points))[:_VOTERS]]
    best, normal, level = 0, np.array([0.0, 0.0, 1.0]), 0.0
    for _ in range(_PLANES):
        a, b, c = voters[rng.choice(len(voters), 3, replace=False)]
        across = np.cross(b - a, c - a)
        length = float(np.linalg.norm(across))
        if length < 1e-6 * size**2:
            continue
        distances = (voters - a) @ (across / length)
        side = 1.0 if np.median(distances) >= 0 else -1.0
        on = np.abs(distances) < _NEAR * size
        below = float((side * distances < -3 * _NEAR * size).mean())
        if on.sum() > best and below < _BELOW:
            best, normal, level = int(on.sum()), side * across / length, float(a @ across / length)
            level *= side
    if best < _ON_GROUND * len(voters):
        raise NotMeasurableError(messages.NO_GROUND())
    on = np.abs(points @ normal - level) < 2 * _NEAR * size
    centre = points[on].mean(axis=0)
    # The plane of least squares; its normal is the direction of least variance.
    found = np.linalg.svd(points[on] - centre, full_matrices=False)[2][2]
    normal = found if found @ normal > 0 else -found
    right = np.cross(normal, [1.0, 0.0, 0.0] if abs(normal[0]) < 0.9 else [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(normal, right), normal])
    turned: Array = (points - centre) @ axes.T
    return turned


def _one_heap(points: Array) -> Array:
    """Return the points of the heap: across in cells from its axis, upward in cells.

    Raises
    ------
    NotMeasurableError
        There is none, or two, or it is scanned from one side only.
    """
    noise = float(np.percentile(np.abs(points[:, 2]), 50))
    top = float(np.percentile(points[:, 2], 99.9))
    high = points[points[:, 2] > max(0.06 * top, min(4 * noise, 0.2 * top))]
    spread = np.ptp(high[:, :2], axis=0).max() if len(high) else 0.0
    if len(high) < _FEWEST_POINTS / 10 or top < 0.02 * spread:
        raise NotMeasurableError(messages.NO_HEAP_IN_SCAN())
    coarse = np.floor((high[:, :2] - high[:, :2].min(axis=0)) / (spread / 60)).astype(int)
    covered = np.zeros(coarse.max(axis=0) + 1, dtype=bool)
    covered[coarse[:, 0], coarse[:, 1]] = True
    labels, _ = ndimage.label(ndimage.binary_closing(np.pad(covered, 3), iterations=2))
    areas = np.bincount(labels.ravel())[1:]
    order = np.argsort(areas)[::-1]
    if len(areas) > 1 and areas[order[1]] > _SECOND * areas[order[0]]:
        raise NotMeasurableError(
            messages.TWO_HEAPS_IN_SCAN(share=100 * areas[order[1]] / areas[order[0]])
        )
    own = labels[coarse[:, 0] + 3, coarse[:, 1] + 3] == order[0] + 1
    heap = high[own]
    cell = float(np.ptp(heap[:, :2], axis=0).max()) / _CELLS
    # The axis is that of the volume, in which every cell of the height map counts once.
    cells = np.floor(heap[:, :2] / (4 * cell)).astype(int)
    _, first = np.unique(cells, axis=0, return_index=True)
    axis = np.average(heap[first, :2], axis=0, weights=heap[first, 2])
    placed = np.column_stack([heap[:, :2] - axis, heap[:, 2]]) / cell
    turn = np.arctan2(placed[:, 1], placed[:, 0])
    outside = np.hypot(placed[:, 0], placed[:, 1]) > 0.15 * _CELLS
    sectors = np.floor((turn[outside] + math.pi) / (2 * math.pi) * _SECTORS).astype(int)
    empty = _SECTORS - len(np.unique(np.clip(sectors, 0, _SECTORS - 1)))
    if empty:
        raise NotMeasurableError(messages.SIDES_MISSING(share=100 * empty / _SECTORS))
    return placed


def _silhouette(points: Array, azimuth: float) -> Silhouette:
    """Return the silhouette of points from one side, lengths in cells."""
    angle = math.radians(azimuth)
    across = points[:, 0] * math.cos(angle) + points[:, 1] * math.sin(angle)
    half = math.ceil(float(np.abs(points[:, :2]).max()) * 1.5)
    columns = np.clip(np.floor(across).astype(int) + half, 0, 2 * half - 1)
    tops = np.zeros(2 * half)
    np.maximum.at(tops, columns, points[:, 2])
    seen = np.flatnonzero(tops)
    between = np.arange(seen[0], seen[-1] + 1)
    tops[between] = np.interp(between, seen, tops[seen])
    rows = math.ceil(tops.max()) + 1
    image = (rows - np.arange(rows) - 0.5)[:, None] < tops[None, :]
    return Silhouette(image, 1.0, -float(half), 0.0)


def _diameter(silhouettes: list[Silhouette]) -> float:
    """Return the particle diameter by the roughness of the flanks, in cells."""
    found = []
    for one in silhouettes:
        heights, places = np.nan_to_num(one.outline()), one.columns
        top = float(heights.max())
        for side in (places < 0, places > 0):
            flank = side & (heights > 0.2 * top) & (heights < 0.8 * top)
            if flank.sum() > 20:
                found.append(diameter_by_roughness(places[flank], heights[flank], 0.0))
    return float(np.median(found)) if found else 1.0
