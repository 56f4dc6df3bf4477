"""The inclination of a plane or of a bed in one picture: its longest straight edge."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.measurement.angle_of_repose import robust_line
from grainfit.photographs import messages
from grainfit.photographs.camera import USUAL_FOCAL
from grainfit.photographs.marker import find_marker_sheet
from grainfit.photographs.pictures import Picture, opencv

#: Length of the longer side in which edges are looked for, pixels; and how far colours must change
#: across an edge, in Lab over a pixel.
_COARSE, _CHANGE = 320, 2.0
#: Inclinations of lines that are tried, degrees; steps of their distance, pixels; and how far from
#: the direction of its edge a place may count for a line, degrees.
_STEP, _DISTANCE, _TURNED = 1.0, 1.5, 12.0
#: Most edges that are looked at.
_MOST = 16
#: Gaps that a straight edge may have, and its least length, over the longer side of the picture.
_GAP, _SHORTEST = 0.05, 0.25
#: Inclinations of a slope, degrees: others are tables and walls.
_SLOPES = (3.0, 75.0)
#: Edges within this many degrees belong to one plane; another edge, longer than this share of the
#: longest one, is another slope.
_ONE_PLANE, _RIVAL = 2.0, 0.6
#: Where an edge is looked for beside its first line, over the longer side; its least strength.
_REACH, _STEEP = 0.006, 3.0
#: Share of its length on which an edge must be seen; and between its halves at most, degrees: a
#: curved bed has no one inclination.
_SEEN, _BENT = 0.6, 4.0
#: Places along an edge that are independent of each other, pixels, at least.
_INDEPENDENT = 8.0
#: Standard uncertainty of the picture's being taken square to the slope, degrees; of a level camera
#: by default, and by the marker sheet; and by pixels and lens.
_SQUARE, LEVEL, _BY_SHEET, _PICTURE = 6.0, 0.5, 0.2, 0.1
#: Standard uncertainty of a point that is given, pixels of the working size.
_POINT = 2.0


#: Two places in a picture, columns and rows.
Points = tuple[tuple[float, float], tuple[float, float]]


class Edge(NamedTuple):
    """A straight edge: its ends, columns and rows, and its inclination, rising right, degrees."""

    start: tuple[float, float]
    end: tuple[float, float]
    angle: float

    @property
    def length(self) -> float:
        """Pixels."""
        return math.dist(self.start, self.end)


@dataclass(frozen=True)
class SlopeInPicture:
    """What was measured on one picture of a slope.

    Parameters
    ----------
    picture : Picture
        In its working size.
    angle : float
        Inclination to the horizontal, degrees, whichever way it rises.
    parts : dict
        Standard uncertainties by their source, degrees.
    edge : Edge
        The straight edge.
    level : float
        Inclination of the horizontal in the picture, rising right, degrees.
    seen_by : str
        What tells the horizontal.
    """

    picture: Picture
    angle: float
    parts: dict[str, float]
    edge: Edge
    level: float
    seen_by: str

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty of the angle, degrees."""
        return math.sqrt(sum(part**2 for part in self.parts.values()))


def measure_slope(
    picture: Picture,
    reference: Points | None = None,
    level: float | None = None,
) -> SlopeInPicture:
    """Measure the inclination of the longest straight edge that is neither level nor upright.

    Parameters
    ----------
    picture : Picture
        The plane or the bed from the side, square to its slope.
    reference : pair of places, optional
        Columns and rows of two points of a level line, pixels of the file.
    level : float, optional
        Standard uncertainty of how level the camera is, degrees.

    Raises
    ------
    NotMeasurableError
        There is no slope, or more than one, and why.
    """
    edges = _edges(picture.colours)
    horizontal, error, seen_by = _horizontal(picture, edges, reference, level)
    inclined = [e for e in edges if _SLOPES[0] < abs(e.angle - horizontal) < _SLOPES[1]]
    if not inclined:
        raise NotMeasurableError(messages.NO_SLOPE(share=100 * _SHORTEST))
    best = max(inclined, key=lambda one: one.length)
    others = [e for e in inclined if abs(e.angle - best.angle) > _ONE_PLANE]
    rival = max(others, key=lambda one: one.length, default=best)
    if rival is not best and rival.length > _RIVAL * best.length:
        shown = {"first": abs(best.angle - horizontal), "second": abs(rival.angle - horizontal)}
        raise NotMeasurableError(messages.TWO_SLOPES(**shown))
    edge, edge_error = _refined(picture.colours, best)
    angle = abs(edge.angle - horizontal)
    # Seen from beside, a slope looks steeper: tan a' = tan a / cos of that angle.
    tangent = math.tan(math.radians(angle)) * math.cos(math.radians(_SQUARE))
    parts = {
        "edge": edge_error,
        "horizontal": error,
        "direction of view": angle - math.degrees(math.atan(tangent)),
        "picture": _PICTURE,
    }
    return SlopeInPicture(picture, angle, parts, edge, horizontal, seen_by)


def _horizontal(
    picture: Picture,
    edges: list[Edge],
    reference: Points | None,
    level: float | None,
) -> tuple[float, float, str]:
    """Return the inclination of the horizontal, its standard uncertainty, degrees, and by what."""
    if reference is not None:
        (x, y), (u, v) = sorted((a * picture.reduced, b * picture.reduced) for a, b in reference)
        length = math.hypot(u - x, v - y)
        if length < _SHORTEST / 2 * max(picture.colours.shape[:2]):
            raise NotMeasurableError(messages.SHORT_REFERENCE())
        error = math.degrees(math.sqrt(2) * _POINT / length)
        return math.degrees(math.atan2(y - v, u - x)), error, "by the reference line"
    rows, columns = picture.colours.shape[:2]
    focal = picture.focal or USUAL_FOCAL * max(rows, columns)
    sheet = find_marker_sheet(picture.colours, focal, picture.middle)
    if sheet is None:
        return 0.0, LEVEL if level is None else level, "by the rows of the picture"
    # Upright lines meet in the picture: that of the longest edge counts.
    places = [np.add(e.start, e.end) / 2 for e in edges] or [np.array(picture.middle)]
    x, y = (places[0] - np.array(picture.middle)) / focal
    up = (sheet.up[0] - x * sheet.up[2], sheet.up[1] - y * sheet.up[2])
    return -math.degrees(math.atan2(up[0], -up[1])), _BY_SHEET, "by the marker sheet"


def _edges(colours: NDArray[np.uint8]) -> list[Edge]:
    """Return the long straight edges of a picture, the longest first."""
    cv2 = opencv()
    factor = min(_COARSE / max(colours.shape[:2]), 1.0)
    size = (round(colours.shape[1] * factor), round(colours.shape[0] * factor))
    small = cv2.resize(colours, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    lab = cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 1.5), cv2.COLOR_RGB2LAB)
    across, down = np.gradient(lab, axis=1), np.gradient(lab, axis=0)
    # The direction in which colours change most, by the structure tensor.
    xx, yy, xy = (across**2).sum(-1), (down**2).sum(-1), (across * down).sum(-1)
    strength = np.sqrt(xx + yy)
    rows, columns = np.nonzero(strength > _CHANGE)
    normal = 0.5 * np.arctan2(2 * xy[rows, columns], (xx - yy)[rows, columns])
    # Inclination of the edge itself, rising right, within half a turn.
    along = (np.degrees(math.pi / 2 - normal) + 90) % 180 - 90
    shortest = _SHORTEST * max(size)
    free = np.ones(len(rows), dtype=bool)
    found: list[Edge] = []
    for _ in range(_MOST):
        line = _line(columns, rows, along, free)
        if line is None or line[2] < _SEEN * shortest:
            break
        angle, at, _ = line
        a = math.radians(angle)
        offset = columns * math.sin(a) + rows * math.cos(a) - at
        near = free & (_apart(along, angle) < 2 * _TURNED) & (np.abs(offset) < 3 * _DISTANCE)
        free &= ~near
        on_line = near & (np.abs(offset) < _DISTANCE)
        places = (columns * math.cos(a) - rows * math.sin(a))[on_line]
        order = np.argsort(places)
        breaks = np.flatnonzero(np.diff(places[order]) > _GAP * max(size)) + 1
        run = max(np.split(order, breaks), key=lambda one: np.ptp(places[one]) if len(one) else 0)
        if len(run) < 3 or np.ptp(places[run]) < shortest:
            continue
        slope, shift = robust_line(places[run], offset[on_line][run])
        ends = []
        for s in (float(places[run].min()), float(places[run].max())):
            beside = at + shift + slope * s
            x = s * math.cos(a) + beside * math.sin(a)
            y = beside * math.cos(a) - s * math.sin(a)
            ends.append(((x + 0.5) / factor - 0.5, (y + 0.5) / factor - 0.5))
        found.append(Edge(ends[0], ends[1], angle - math.degrees(math.atan(slope))))
    return sorted(found, key=lambda one: -one.length)


def _apart(along: Array, angle: float) -> Array:
    """Angle between directions and a line, degrees."""
    found: Array = np.abs((along - angle + 90) % 180 - 90)
    return found


def _line(
    columns: NDArray[np.int64], rows: NDArray[np.int64], along: Array, free: NDArray[np.bool_]
) -> tuple[float, float, int] | None:
    """Return the line on which most places have its direction: angle, distance, and how many."""
    best: tuple[float, float, int] | None = None
    for angle in np.arange(-90.0, 90.0, _STEP):
        some = np.flatnonzero(free & (_apart(along, angle) < _TURNED))
        if not len(some):
            continue
        a = math.radians(angle)
        distance = columns[some] * math.sin(a) + rows[some] * math.cos(a)
        first = float(distance.min())
        counts = np.bincount(np.round((distance - first) / _DISTANCE).astype(np.int64))
        k = int(counts.argmax())
        if best is None or counts[k] > best[2]:
            best = (float(angle), first + k * _DISTANCE, int(counts[k]))
    return best


def _refined(colours: NDArray[np.uint8], edge: Edge) -> tuple[Edge, float]:
    """Fit a line to the steepest places across an edge; return its standard error, too, degrees.

    Raises
    ------
    NotMeasurableError
        It is not straight.
    """
    cv2 = opencv()
    longer = max(colours.shape[:2])
    reach, sigma = _REACH * longer, max(1.0, longer / 800)
    for again in (1.0, 0.6):
        a = math.radians(edge.angle)
        along = np.array([math.cos(a), -math.sin(a)])
        upward = np.array([-math.sin(a), -math.cos(a)])
        steps = np.arange(0.0, edge.length, 1.0)
        offsets = np.arange(-again * reach, again * reach + 0.5, 0.5)
        points = (
            np.array(edge.start) + steps[None, :, None] * along + offsets[:, None, None] * upward
        ).astype(np.float32)
        soft = cv2.GaussianBlur(colours, (0, 0), sigma).astype(np.float32) / 255
        lab = cv2.cvtColor(soft, cv2.COLOR_RGB2LAB)
        values = cv2.remap(
            lab, points[..., 0], points[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        change = values[4:] - values[:-4]
        # The same change of colour all along: the other edge of a plate has the opposite one.
        usual = np.median(change[len(change) // 2 - 2 : len(change) // 2 + 3], axis=(0, 1))
        steep = change @ (usual / max(float(np.linalg.norm(usual)), 1e-9))
        at = steep.argmax(axis=0)
        seen = steep[at, np.arange(len(steps))] > _STEEP
        if seen.mean() < _SEEN:
            raise NotMeasurableError(messages.FAINT_SLOPE(share=100 * float(seen.mean())))
        heights = offsets[at + 2][seen]
        slope, offset = robust_line(steps[seen], heights)
        rest = heights - slope * steps[seen] - offset
        turned = edge.angle + math.degrees(math.atan(slope))
        ends = [
            tuple(np.array(edge.start) + s * along + (offset + slope * s) * upward)
            for s in (0.0, edge.length)
        ]
        edge = Edge(
            (float(ends[0][0]), float(ends[0][1])), (float(ends[1][0]), float(ends[1][1])), turned
        )
    scatter = 1.4826 * float(np.median(np.abs(rest)))
    halves = [robust_line(steps[seen][half], heights[half])[0] for half in _halves(steps[seen])]
    bend = math.degrees(abs(math.atan(halves[0]) - math.atan(halves[1])))
    if bend > _BENT:
        raise NotMeasurableError(messages.BENT_SLOPE(bend=bend, most=_BENT))
    independent = max(edge.length / max(_INDEPENDENT, 4 * scatter), 3.0)
    error = math.degrees(scatter / edge.length * math.sqrt(12 / independent))
    return edge, max(error, bend / 4)


def _halves(steps: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    first = steps < (steps[0] + steps[-1]) / 2
    return first, ~first
