"""A round plate below a heap: the circle of its edge in a picture tells where up is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from grainfit.photographs.camera import ray
from grainfit.photographs.pictures import opencv

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Share of the visible edge of a plate that must be seen as an edge, and how near to it, pixels;
#: ellipses of which this less is seen are as good.
_SEEN, _NEAR, _AS_WELL = 0.85, 1.6, 0.1
#: A plate is wider than the heap by this factor at least and at most.
_WIDER = (1.04, 4.0)
#: Standard uncertainty of the place of its edge, pixels, and of its being level, degrees.
_EDGE, _LEVEL = 0.7, 0.2
#: Least depth of the ellipse over its width, and pixels by which the heap may be beyond the edge.
_THIN, _BEYOND = 0.02, 3.0
#: Edges are looked for in a picture that is softened by this share of its width; they are steeper
#: than this share of all places, and than these differences of neighbours, times eight.
_SOFT, _GRAIN, _STEEP = 0.0035, 0.9, (16.0, 6.0)
#: Longest edges that are looked at; pieces of one, and their length over the width of the heap.
_MOST_EDGES, _MOST_PIECES, _PIECE = 14, 5, 0.4
#: Width of a straight edge over its length.
_STRAIGHT = 0.01


@dataclass(frozen=True)
class Plate:
    """The edge of a round plate in a picture.

    Parameters
    ----------
    up : ndarray of shape (3,)
        Upward direction in the axes of the camera.
    elevation, error : float
        Of the camera, seen from the middle of the plate, and its standard uncertainty, degrees.
    ellipse : ndarray of shape (n, 2)
        Its edge, columns and rows.
    half_width : float
        Half its width in the picture, pixels.
    """

    up: Array
    elevation: float
    error: float
    ellipse: Array
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
    columns = np.flatnonzero(heap.any(axis=0))
    width = float(np.ptp(columns))
    size = max(3, 2 * round(0.012 * width) + 1)
    hidden = cv2.dilate(heap.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
    soft = cv2.GaussianBlur(colours, (0, 0), max(1.6, _SOFT * colours.shape[1]))
    lowest = _lowest(heap)
    lab = cv2.cvtColor(soft, cv2.COLOR_RGB2LAB)
    steep, weak = (np.where(hidden, 0, _edges(lab, least)).astype(np.uint8) for least in _STEEP)
    # Ellipses through steep edges; weak ones are seen around them.
    for chains in (_chains(steep, width), _chains(weak, width)):
        conic = _best(chains, weak, hidden, width, lowest)
        if conic is not None:
            return _plate(conic, focal, middle)
    return None


def _edges(lab: NDArray[np.uint8], least: float) -> NDArray[np.uint8]:
    """Find edges in any channel that are steeper than the grain."""
    cv2 = opencv()
    edges = np.zeros(lab.shape[:2], np.uint8)
    for channel in range(3):
        shade = np.ascontiguousarray(lab[..., channel])
        across, down = (cv2.Sobel(shade, cv2.CV_16S, *way) for way in ((1, 0), (0, 1)))
        grain = float(np.quantile(np.hypot(across[::4, ::4], down[::4, ::4]), _GRAIN))
        high = max(least, 1.5 * grain)
        edges |= cv2.Canny(across, down, 0.5 * high, high, L2gradient=True)
    return edges


def _best(
    chains: list[Array], edges: NDArray[np.uint8], hidden: Mask, width: float, foot: Array
) -> Array | None:
    """Return the conic of the ellipse around the foot that is the edge of a plate."""
    cv2 = opencv()
    distance = cv2.distanceTransform((edges == 0).astype(np.uint8), cv2.DIST_L2, 5)
    found = []
    for some in (*combinations(chains, 1), *combinations(chains, 2)):
        ellipse = _fitted(np.vstack(some), distance, edges, hidden, width, foot)
        if ellipse is not None and ellipse[0] >= _SEEN:
            found.append(ellipse)
    if not found:
        return None
    # The lower rim of a thick plate goes well with the back of its upper one: the upper one is
    # within the ellipse of both.
    seen = max(share for share, _ in found) - _AS_WELL
    return min((conic for share, conic in found if share >= seen), key=_area)


def _area(conic: Array) -> float:
    shape = _axes_of(conic)
    return math.inf if shape is None else shape[1] * shape[2]


def _chains(edges: NDArray[np.uint8], width: float) -> list[Array]:
    """Return pieces of the longest edges: columns and rows."""
    cv2 = opencv()
    outlines, _ = cv2.findContours(edges, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    longest = sorted(outlines, key=len, reverse=True)[:_MOST_EDGES]
    found: list[Array] = []
    for outline in longest:
        # A thin line is traced there and back.
        points = outline.reshape(-1, 2).astype(np.float64)
        points = points[: len(points) // 2 + 1]
        if len(points) > 0.15 * width and not _is_straight(points):
            # In pieces, for an edge of the plate may go on as one of something else.
            count = min(max(1, round(len(points) / (_PIECE * width))), _MOST_PIECES)
            found += np.array_split(points, count)
    return found


def _is_straight(points: Array) -> bool:
    """Return whether an edge is a line, as that of a table."""
    centred = points - points.mean(axis=0)
    thin, long = np.linalg.svd(centred, full_matrices=False)[1][::-1]
    return bool(thin < _STRAIGHT * long)


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
