"""A round plate below a heap: the circle of its edge in a picture tells where up is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.photographs.camera import foot_of
from grainfit.photographs.pictures import opencv

Mask = NDArray[np.bool_]

#: Share of the visible edge of a plate that must be seen as an edge: of all of it, of its front,
#: and of each of its ends; and how near to it, pixels.
_SEEN, _FRONT_SEEN, _END_SEEN, _NEAR = 0.6, 0.6, 0.5, 2.0
#: From this share on no other ellipse is followed.
_SEEN_WELL = 0.9
#: A plate is wider than the heap by this factor at least and at most.
_WIDER = (1.04, 4.0)
#: Standard uncertainty of the place of its edge, pixels, and of its being level, degrees.
_EDGE, _LEVEL = 0.5, 0.2
#: Least depth of the ellipse over its width, and pixels by which the heap may be beyond the edge.
_THIN, _BEYOND = 0.02, 3.0
#: Length of the longer side of the picture in which a plate is looked for, pixels.
_LENGTH = 800
#: Edges are looked for in a picture that is softened by so many pixels; two limits of steepness.
_SOFT, _STEEP = 1.6, (12, 30)
#: Longest edges that are looked at, pieces of them, and ellipses through these that are followed.
_MOST_EDGES, _MOST_PIECES, _MOST_FOLLOWED = 14, 36, 4
#: Directions from its middle in which an ellipse is followed, and places to both sides of each that
#: are averaged, so that an edge is seen below the grain of the picture.
_DIRECTIONS, _AVERAGED = 120, 5
#: A step is an edge from this many times the usual step of the picture; where several are parallel,
#: from this share of the largest.
_EDGE_STEP, _OF_LARGEST = 3.0, 0.25
#: The side of a plate is seen as high as this at most, over half its width.
_THICK = 0.13


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


@dataclass(frozen=True)
class Rim:
    """The edge of a round plate, or of what may be one, in a picture.

    Parameters
    ----------
    points : ndarray of shape (n, 2)
        Places where it is seen, columns and rows.
    edge : ndarray of shape (m, 2)
        The whole of it.
    half_width : float
        Half its width, pixels.
    """

    points: Array
    edge: Array
    half_width: float

    def plate(self, focal: float, middle: tuple[float, float]) -> Plate:
        """Return the plate that a camera sees so.

        Parameters
        ----------
        focal : float
            Focal length, pixels.
        middle : tuple of float
            Where the optical axis is: column and row.
        """
        circle = foot_of(self.points, focal, middle, 0.0, whole=True)
        reach = self.half_width * math.cos(math.radians(circle.elevation))
        error = math.hypot(math.degrees(_EDGE / reach), _LEVEL, circle.error)
        return Plate(circle.up, circle.elevation, error, self.edge, self.half_width)


def drawn_rim(left: Array, right: Array, front: Array) -> Rim:
    """Return the edge of a plate by its ends and its nearest place in a picture."""
    middle, across = (left + right) / 2, right - left
    half = max(float(np.hypot(*across)) / 2, 1.0)
    turn = math.atan2(across[1], across[0])
    depth = max(float((front - middle) @ _turn(turn)[:, 1]), 0.5)
    ellipse = _Ellipse(middle, half, depth, turn)
    return Rim(ellipse.around(_DIRECTIONS), ellipse.around(240), half)


def find_rim(colours: NDArray[np.uint8], heap: Mask) -> Rim | None:
    """Find the edge of the plate that a heap lies on; None where none is seen.

    Parameters
    ----------
    colours : ndarray of uint8 of shape (rows, columns, 3)
        The picture.
    heap : ndarray of bool of shape (rows, columns)
        Where the heap is.
    """
    cv2 = opencv()
    factor = _LENGTH / max(heap.shape)
    if factor < 1:
        reduced = (round(heap.shape[1] * factor), round(heap.shape[0] * factor))
        small = cv2.resize(heap.astype(np.uint8), reduced, interpolation=cv2.INTER_AREA) > 0
        colours = cv2.resize(colours, reduced, interpolation=cv2.INTER_AREA)
        rim = find_rim(colours, small)
        if rim is None:
            return None
        points, edge = ((places + 0.5) / factor - 0.5 for places in (rim.points, rim.edge))
        return Rim(points, edge, rim.half_width / factor)
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
    candidates = []
    for some in combinations(_pieces(edges, width), 2):
        found = _fitted(np.vstack(some), distance, edges, hidden, width, lowest)
        if found is not None:
            candidates.append(found)
    picture = _Steps(lab.astype(np.float32), hidden)
    best: tuple[float, Array, _Ellipse] | None = None
    for ellipse in _distinct(candidates):
        followed = _followed(ellipse, picture)
        if followed is not None and (best is None or followed[0] > best[0]):
            best = followed
        if best is not None and best[0] > _SEEN_WELL:
            break
    if best is None:
        return None
    _, points, shape = best
    return Rim(points, shape.around(240), shape.half)


@dataclass(frozen=True)
class _Ellipse:
    """An ellipse in a picture: its middle, half axes, and the turn of the longer one, rad."""

    middle: Array
    half: float
    depth: float
    turn: float

    def around(self, count: int, shift: float = 0.0) -> Array:
        """Return places on it, from its right end over the front; moved along its depth."""
        t = np.linspace(0, 2 * math.pi, count, endpoint=False)
        x, y = self.half * np.cos(t), self.depth * np.sin(t) + shift
        found: Array = self.middle + np.column_stack([x, y]) @ _turn(self.turn).T
        return found

    def normals(self, count: int) -> Array:
        """Return the outward directions at these places."""
        t = np.linspace(0, 2 * math.pi, count, endpoint=False)
        normal = np.column_stack([np.cos(t) / self.half, np.sin(t) / self.depth])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        found: Array = normal @ _turn(self.turn).T
        return found


class _Steps:
    """Steps of the colours of a picture across an ellipse.

    Parameters
    ----------
    lab : ndarray of float32 of shape (rows, columns, 3)
        The picture, softened.
    hidden : ndarray of bool of shape (rows, columns)
        Where the heap is.
    """

    def __init__(self, lab: NDArray[np.float32], hidden: Mask) -> None:
        self._lab, self._hidden = lab, hidden.astype(np.float32)

    def across(self, ellipse: _Ellipse, reach: int, shift: float = 0.0) -> tuple[Array, Mask]:
        """Return the steps at offsets from -reach to reach, outward, in each direction.

        And the directions in which the ellipse is in the picture and not hidden.
        """
        cv2 = opencv()
        count = _DIRECTIONS * _AVERAGED
        beyond = reach + 3
        offsets = np.arange(-beyond, beyond + 1)
        places = ellipse.around(count, shift)[:, None, :]
        places = places + offsets[None, :, None] * ellipse.normals(count)[:, None, :]
        x, y = places[..., 0].astype(np.float32), places[..., 1].astype(np.float32)
        # A direction has the places to both of its sides.
        turned = [np.roll(one, _AVERAGED // 2, axis=0) for one in (x, y)]
        shape = (_DIRECTIONS, _AVERAGED, len(offsets))
        colours = cv2.remap(self._lab, *turned, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        profile = colours.reshape(*shape, 3).mean(axis=1)
        heap = cv2.remap(self._hidden, *turned, cv2.INTER_LINEAR).reshape(shape).max(axis=1) > 0
        rows, columns = self._hidden.shape
        inside = (turned[0] >= 0) & (turned[0] < columns) & (turned[1] >= 0) & (turned[1] < rows)
        whole: Mask = inside.reshape(shape).all(axis=1)
        sums = np.cumsum(np.pad(profile, ((0, 0), (1, 0), (0, 0))), axis=1)
        middle = np.arange(3, len(offsets) - 3)
        outer = sums[:, middle + 4] - sums[:, middle + 1]
        inner = sums[:, middle] - sums[:, middle - 3]
        steps = np.linalg.norm(outer - inner, axis=2) / 3
        windows = np.lib.stride_tricks.sliding_window_view(whole & ~heap, 7, axis=1)
        shown: Mask = np.asarray(windows.all(axis=2))
        return np.where(shown, steps, 0.0), shown[:, reach]


def _distinct(candidates: list[tuple[float, Array]]) -> list[_Ellipse]:
    """Return the ellipses that are seen best, each once."""
    found: list[_Ellipse] = []
    for _, conic in sorted(candidates, key=lambda one: -one[0]):
        shape = _axes_of(conic)
        if shape is None:
            continue
        ellipse = _Ellipse(*shape)
        places = ellipse.around(16)
        if all(np.abs(places - other.around(16)).max() > 6 for other in found):
            found.append(ellipse)
        if len(found) == _MOST_FOLLOWED:
            break
    return found


def _followed(ellipse: _Ellipse, picture: _Steps) -> tuple[float, Array, _Ellipse] | None:
    """Return the share of a plate's upper edge that is seen, places on it, and its ellipse."""
    t = np.linspace(0, 2 * math.pi, _DIRECTIONS, endpoint=False)
    front, back = np.sin(t) > 0.25, np.sin(t) < -0.25
    steps, visible = picture.across(ellipse, 12)
    if not visible.any():
        return None
    # Most of the picture beside an ellipse is no edge.
    usual = max(1.4 * float(np.quantile(steps[visible], 0.25)), 0.3)
    thick = max(4, round(_THICK * ellipse.half))
    # Inward of the lower edge of a plate's side, its upper edge follows: the innermost is it.
    rises = np.arange(-4.0, thick + 1)
    risen = _innermost(_strengths(picture, ellipse, -rises, front) / usual)
    # Behind there is one edge only.
    falls = np.arange(-float(thick), thick + 1)
    at_back = _strengths(picture, ellipse, falls, back) / usual
    shifts = np.zeros(_DIRECTIONS)
    if risen is not None:
        shifts[front] = -rises[risen]
    if at_back.max() >= _EDGE_STEP:
        shifts[back] = falls[int(at_back.argmax())]
    moved = ellipse.around(_DIRECTIONS) + np.outer(shifts, _turn(ellipse.turn)[:, 1])
    used = visible
    if at_back.max() < _EDGE_STEP:
        used = used & ~back
    if risen is None:
        return None
    points = moved[used]
    for reach in (4, 3, 2):
        conic = _conic_of(points)
        shape = None if conic is None else _axes_of(conic)
        if shape is None:
            return None
        ellipse = _Ellipse(*shape)
        steps, visible = picture.across(ellipse, reach)
        at = steps.argmax(axis=1)
        edge = visible & (steps.max(axis=1) >= _EDGE_STEP * usual)
        # The largest step is within the reach, not at its end.
        edge &= (at > 0) & (at < 2 * reach)
        if edge.sum() < _DIRECTIONS // 5:
            return None
        offset = at - reach + _vertex(steps, at)
        points = ellipse.around(_DIRECTIONS) + offset[:, None] * ellipse.normals(_DIRECTIONS)
        points = points[edge]
    right, left = np.cos(t) > 0.75, np.cos(t) < -0.75
    shares = [
        float(edge[part].sum() / max(visible[part].sum(), 1)) for part in (front, right, left)
    ]
    share = float(edge.sum() / max(visible.sum(), 1))
    if share < _SEEN or shares[0] < _FRONT_SEEN or min(shares[1:]) < _END_SEEN:
        return None
    return share, points, ellipse


def _strengths(picture: _Steps, ellipse: _Ellipse, shifts: Array, part: Mask) -> Array:
    """Return the usual step across a part of an ellipse that is moved along its depth."""
    found = []
    for shift in shifts:
        steps, visible = picture.across(ellipse, 0, float(shift))
        shown = visible & part
        enough = shown.sum() > part.sum() / 4
        found.append(float(np.median(steps[shown, 0])) if enough else 0.0)
    return np.array(found)


def _innermost(strengths: Array) -> int | None:
    """Return the last peak that is an edge."""
    limit = max(_EDGE_STEP, _OF_LARGEST * float(strengths.max()))
    padded = np.pad(strengths, 1)
    peaks = (strengths >= limit) & (strengths >= padded[:-2]) & (strengths >= padded[2:])
    return int(np.flatnonzero(peaks)[-1]) if peaks.any() else None


def _vertex(steps: Array, at: NDArray[np.int64]) -> Array:
    """Return by how much a peak is beyond its largest value, in offsets, by a parabola."""
    rows = np.arange(len(steps))
    inner = np.clip(at, 1, steps.shape[1] - 2)
    low, high, top = steps[rows, inner - 1], steps[rows, inner + 1], steps[rows, inner]
    bend = np.minimum(low + high - 2 * top, -1e-9)
    found: Array = np.clip((low - high) / (2 * bend), -0.5, 0.5)
    return found


def _pieces(edges: NDArray[np.uint8], width: float) -> list[Array]:
    """Return pieces of the longest edges, a sixth of the heap's width each: columns and rows."""
    cv2 = opencv()
    length = max(12, round(width / 6))
    outlines, _ = cv2.findContours(edges, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    found: list[Array] = []
    for outline in sorted(outlines, key=len, reverse=True)[:_MOST_EDGES]:
        # A thin line is traced there and back.
        points, first = np.unique(outline.reshape(-1, 2), axis=0, return_index=True)
        points = points[np.argsort(first)].astype(np.float64)
        jumps = np.flatnonzero(np.abs(np.diff(points, axis=0)).max(axis=1) > 1.5) + 1
        for begin, end in pairwise([0, *jumps.tolist(), len(points)]):
            found += [
                points[k : min(k + length, end)] for k in range(begin, end - length // 2, length)
            ]
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
        ellipse = _Ellipse(middle, half, depth, turn)
        seen = _share_seen(ellipse.around(240), distance, hidden)
        if seen < 0.25:
            return None
        # All edges near the ellipse, for the next fit.
        dense = ellipse.around(1440)
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
    if min(shares[0], shares[2]) < 0.25 or shares[1] < 0.5:
        return 0.0
    return float(near.sum() / max(visible.sum(), 1))
