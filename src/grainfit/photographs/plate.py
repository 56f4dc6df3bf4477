"""A round plate below a heap: the circle of its edge in a picture tells where up is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from grainfit.photographs.camera import ray
from grainfit.photographs.pictures import opencv

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Share of the visible edge of a plate that must be seen as an edge, and how near to it, pixels.
_SEEN, _NEAR = 0.7, 2.0
#: A plate is wider than the heap by this factor at least and at most.
_WIDER = (1.04, 4.0)
#: Standard uncertainty of the place of its edge, pixels, and of its being level, degrees.
_EDGE, _LEVEL = 0.7, 0.2
#: Least depth of the ellipse over its width, and pixels by which the heap may be beyond the edge.
_THIN, _BEYOND = 0.02, 3.0
#: Length of the longer side of the picture in which a plate is looked for, pixels.
_LENGTH = 800
#: Edges are looked for in a picture that is softened by so many pixels; two limits of steepness.
_SOFT, _STEEP = 1.6, (12, 30)
#: Longest edges that are looked at, and pieces of them.
_MOST_EDGES, _MOST_PIECES = 14, 36


@dataclass(frozen=True)
class Plate:
    """The edge of a round plate in a picture.

    Parameters
    ----------
    up : ndarray of shape (3,)
        Upward direction in the axes of the camera.
    elevation, error : float
        Of the camera, seen from the middle of the plate, and its standard uncertainty, degrees.
    edge : ndarray of shape (n, 2)
        Columns and rows.
    half_width : float
        Half its width in the picture, pixels.
    """

    up: Array
    elevation: float
    error: float
    edge: Array
    half_width: float


def find_plate(
    colours: NDArray[np.uint8], heap: Mask, focal: float, middle: tuple[float, float]
) -> Plate | None:
    """Find the edge of the plate that a heap lies on; None where none is seen.

    Parameters
    ----------
    colours : ndarray of uint8 of shape (rows, columns, 3)
        The picture.
    heap : ndarray of bool of shape (rows, columns)
        Where the heap is.
    focal : float
        Focal length, pixels.
    middle : tuple of float
        Where the optical axis is: column and row.
    """
    cv2 = opencv()
    factor = _LENGTH / max(heap.shape)
    if factor < 1:
        reduced = (round(heap.shape[1] * factor), round(heap.shape[0] * factor))
        small = cv2.resize(heap.astype(np.uint8), reduced, interpolation=cv2.INTER_AREA) > 0
        colours = cv2.resize(colours, reduced, interpolation=cv2.INTER_AREA)
        nearer = ((middle[0] + 0.5) * factor - 0.5, (middle[1] + 0.5) * factor - 0.5)
        plate = find_plate(colours, small, focal * factor, nearer)
        if plate is None:
            return None
        edge = (plate.edge + 0.5) / factor - 0.5
        return replace(plate, edge=edge, half_width=plate.half_width / factor)
    columns = np.flatnonzero(heap.any(axis=0))
    width = float(np.ptp(columns))
    size = max(3, 2 * round(0.012 * width) + 1)
    hidden = cv2.dilate(heap.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
    lab = cv2.cvtColor(cv2.GaussianBlur(colours, (0, 0), _SOFT), cv2.COLOR_RGB2LAB)
    edges = np.zeros(heap.shape, np.uint8)
    for channel in range(3):
        edges |= cv2.Canny(np.ascontiguousarray(lab[..., channel]), *_STEEP, L2gradient=True)
    edges[hidden] = 0
    distance = cv2.distanceTransform((edges == 0).astype(np.uint8), cv2.DIST_L2, 5)
    lowest = _lowest(heap)
    best: tuple[float, Array] | None = None
    for some in combinations(_pieces(edges, width), 2):
        found = _fitted(np.vstack(some), distance, edges, hidden, width, lowest)
        if found is not None and (best is None or found[0] > best[0]):
            best = found
    if best is None or best[0] < _SEEN:
        return None
    return _plate(best[1], focal, middle)


def _pieces(edges: NDArray[np.uint8], width: float) -> list[Array]:
    """Return pieces of the longest edges, a sixth of the heap's width each: columns and rows."""
    cv2 = opencv()
    length = max(12, round(width / 6))
    outlines, _ = cv2.findContours(edges, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    found: list[Array] = []
    for outline in sorted(outlines, key=len, reverse=True)[:_MOST_EDGES]:
        # A thin line is traced there and back.
        points = outline.reshape(-1, 2).astype(np.float64)
        points = points[: len(points) // 2 + 1]
        cuts = range(0, len(points) - length // 2, length)
        found += [points[k : k + length] for k in cuts]
    return sorted(found, key=len, reverse=True)[:_MOST_PIECES]


def _fitted(
    points: Array,
    distance: NDArray[np.float32],
    edges: NDArray[np.uint8],
    hidden: Mask,
    width: float,
    foot: Array,
) -> tuple[float, Array] | None:
    """Fit an ellipse; return the share of it that is seen, and its conic, or None."""
    seen = 0.0
    place: Array | None = None
    for _ in range(3):
        conic = _conic_of(points)
        shape = None if conic is None else _axes_of(conic)
        if conic is None or shape is None:
            return None
        middle, half, depth, turn = shape
        if not _WIDER[0] * width / 2 < half < _WIDER[1] * width / 2:
            return None
        if abs(turn) > math.radians(15) or not _THIN * half < depth < 0.75 * half:
            return None
        # The heap lies on the plate, near its middle.
        x, y = ((foot - middle) @ _turn(turn)).T
        if (np.hypot(x / (half + _BEYOND), y / (depth + _BEYOND)) > 1).any():
            return None
        if abs(float(x.mean())) > 0.4 * half:
            return None
        place = _around(middle, half, depth, turn)
        seen = _share_seen(place, distance, hidden)
        if seen < 0.25:
            return None
        # All edges near the ellipse, for the next fit.
        dense = _around(middle, half, depth, turn, 1440)
        near = np.zeros(edges.shape, np.uint8)
        opencv().polylines(near, [np.round(dense).astype(np.int32)], True, 1, round(2 * _NEAR) + 1)
        rows, columns = np.nonzero((near > 0) & (edges > 0))
        if len(rows) < 20:
            return None
        points = np.column_stack([columns, rows]).astype(np.float64)
    return (seen, conic) if conic is not None else None


def _conic_of(points: Array) -> Array | None:
    """Fit an ellipse directly (Fitzgibbon and others 1999); return its symmetric matrix."""
    if len(points) < 6:
        return None
    shift, scale = points.mean(axis=0), float(points.std()) or 1.0
    x, y = ((points - shift) / scale).T
    quadratic = np.column_stack([x**2, x * y, y**2])
    linear = np.column_stack([x, y, np.ones_like(x)])
    s1, s2, s3 = quadratic.T @ quadratic, quadratic.T @ linear, linear.T @ linear
    try:
        t = -np.linalg.solve(s3, s2.T)
        m = s1 + s2 @ t
        m = np.array([m[2] / 2, -m[1], m[0] / 2])
        _, vectors = np.linalg.eig(m)
    except np.linalg.LinAlgError:
        return None
    vectors = np.real(vectors)
    good = np.flatnonzero(4 * vectors[0] * vectors[2] - vectors[1] ** 2 > 0)
    if len(good) != 1:
        return None
    a, b, c = vectors[:, good[0]]
    d, e, f = t @ vectors[:, good[0]]
    conic = np.array([[a, b / 2, d / 2], [b / 2, c, e / 2], [d / 2, e / 2, f]])
    move = np.array(
        [[1 / scale, 0, -shift[0] / scale], [0, 1 / scale, -shift[1] / scale], [0, 0, 1]]
    )
    found: Array = move.T @ conic @ move
    return found


def _axes_of(conic: Array) -> tuple[Array, float, float, float] | None:
    """Return middle, half axes, and inclination of the longer axis to the columns, rad."""
    square = conic[:2, :2]
    try:
        middle = -np.linalg.solve(square, conic[:2, 2])
    except np.linalg.LinAlgError:
        return None
    value = float(conic[2, 2] + conic[:2, 2] @ middle)
    values, vectors = np.linalg.eigh(-square / value) if value else (np.zeros(2), np.eye(2))
    if not (values > 0).all():
        return None
    half, depth = 1 / math.sqrt(values[0]), 1 / math.sqrt(values[1])
    axis = vectors[:, 0] * (1 if vectors[0, 0] >= 0 else -1)
    return np.asarray(middle, np.float64), half, depth, math.atan2(axis[1], axis[0])


def _around(middle: Array, half: float, depth: float, turn: float, count: int = 240) -> Array:
    t = np.linspace(0, 2 * math.pi, count, endpoint=False)
    x, y = half * np.cos(t), depth * np.sin(t)
    found: Array = middle + np.column_stack([x, y]) @ _turn(turn).T
    return found


def _turn(angle: float) -> Array:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def _lowest(heap: Mask) -> Array:
    """Lower edge of a heap: columns and rows."""
    columns = np.flatnonzero(heap.any(axis=0))[::4]
    rows = heap.shape[0] - 1 - np.argmax(heap[::-1, columns], axis=0)
    return np.column_stack([columns, rows]).astype(np.float64)


def _share_seen(ellipse: Array, distance: NDArray[np.float32], hidden: Mask) -> float:
    """Share of the visible parts of an ellipse that is near an edge, least of front and ends."""
    rows, columns = distance.shape
    x, y = np.round(ellipse).astype(int).T
    inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
    if inside.mean() < 0.9:
        return 0.0
    x, y = np.clip(x, 0, columns - 1), np.clip(y, 0, rows - 1)
    visible = inside & ~hidden[y, x]
    near = visible & (distance[y, x] <= _NEAR)
    count = len(ellipse)
    # Quarters: right, front, left, back; a plate is seen at the ends, and in front or behind.
    quarter = (np.arange(count) + count // 8) * 4 // count % 4
    shares = [
        float(near[quarter == k].sum() / max(visible[quarter == k].sum(), 1)) for k in range(4)
    ]
    if min(shares[0], shares[2]) < 0.5 or shares[1] < 0.5:
        return 0.0
    return float(near.sum() / max(visible.sum(), 1))


def _plate(conic: Array, focal: float, middle: tuple[float, float]) -> Plate | None:
    """Return where up is, by the cone of the rays to the edge (closed form of eigenvalues)."""
    shape = _axes_of(conic)
    assert shape is not None
    place, half, depth, turn = shape
    to_picture = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1.0]])
    rays = to_picture.T @ conic @ to_picture
    values, vectors = np.linalg.eigh(rays)
    if (values > 0).sum() == 1:
        values, vectors = -values[::-1], vectors[:, ::-1]
    low, mid, high = values  # low < 0 < mid <= high
    across = math.sqrt(max((high - mid) / (high - low), 0.0))
    along = math.sqrt(max((mid - low) / (high - low), 0.0))
    towards = ray(focal, middle, (float(place[0]), float(place[1])))
    best: Array | None = None
    for sign in (1, -1):
        normal = across * vectors[:, 2] + sign * along * vectors[:, 0]
        normal *= -np.sign(normal @ towards)
        # A plate that is seen shows its upper side.
        if best is None or normal[1] < best[1]:
            best = normal
    assert best is not None
    # The middle of the circle is the pole of the horizon; that of the ellipse is nearer.
    centre = np.linalg.solve(rays, best)
    towards = centre / np.linalg.norm(centre)
    towards *= np.sign(towards[2])
    elevation = math.asin(float(np.clip(-(towards @ best), -1, 1)))
    error = math.hypot(math.degrees(_EDGE / (half * math.cos(elevation))), _LEVEL)
    return Plate(best, math.degrees(elevation), error, _around(place, half, depth, turn), half)
