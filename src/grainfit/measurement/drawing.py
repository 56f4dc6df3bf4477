"""Silhouettes of particles as small drawings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grainfit.measurement.angle_of_repose import Flank, View
from grainfit.measurement.silhouette import Silhouette

#: Largest deviation of the drawn outline from the rendered one, pixels of the silhouette: a
#: twentieth of a particle.
_TOLERANCE = 1.0
#: Height of a drawing of a curve, room around it, and most points of a curve.
CURVE_HEIGHT, _SPACE, _MOST_POINTS = 400, 12, 200


@dataclass(frozen=True)
class Line:
    """A straight line in a drawing, in pixels of the silhouette; heights are negative upwards."""

    x1: float
    y1: float
    x2: float
    y2: float


@dataclass(frozen=True)
class Drawing:
    """A silhouette with what was fitted to it, in pixels of the silhouette.

    Parameters
    ----------
    path : str
        Outline as an SVG path; the plate is at y = 0 and heights are negative.
    half_width, height : int
        Extent of the drawing.
    fitted, wanted : tuple of Line
        The fitted lines, and through their middles lines at the target.
    walls : tuple of Line
        Walls of the apparatus; without any, the ground is a line at y = 0.
    pixel_size : float or None
        Size of a pixel, m; None where it is no length.
    """

    path: str
    half_width: int
    height: int
    fitted: tuple[Line, ...] = ()
    wanted: tuple[Line, ...] = ()
    walls: tuple[Line, ...] = ()
    pixel_size: float | None = None


def draw(silhouette: Silhouette, view: View | None = None, target: float | None = None) -> Drawing:
    """Draw a silhouette, fitted flanks and, through them, lines at a measured angle, degrees."""
    size = silhouette.pixel_size
    x = silhouette.columns / size
    heights = np.nan_to_num(silhouette.outline(), nan=0.0) / size
    kept = simplified(heights, _TOLERANCE)
    points = " ".join(f"{x[i]:.0f},{-heights[i]:.0f}" for i in kept)
    covered = np.flatnonzero(heights)
    reach = float(np.abs(x[covered]).max()) if len(covered) else float(np.abs(x).max())
    flanks = [flank for flank in (view.left, view.right) if flank is not None] if view else []
    return Drawing(
        path=f"M{x[0]:.0f},0 L{points} L{x[-1]:.0f},0Z",
        half_width=math.ceil(reach) + 12,
        height=math.ceil(float(heights.max())) + 12,
        fitted=tuple(_line(flank, size) for flank in flanks),
        wanted=tuple(_through(_line(flank, size), target) for flank in flanks if target),
        pixel_size=size,
    )


@dataclass(frozen=True)
class CurveScale:
    """Scale of a drawing of a curve: its largest values, and half the width of the drawing, pixels.

    Parameters
    ----------
    x, y : float
        The largest values along the axes, which begin at zero.
    half_width : int
        Half the width of the drawing, pixels.
    """

    x: float
    y: float
    half_width: int = 300

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Return a point in pixels."""
        across = (2 * x / self.x - 1) * self.half_width
        return round(across, 1), round(-y / self.y * CURVE_HEIGHT, 1)

    def line(self, start: tuple[float, float], end: tuple[float, float]) -> Line:
        """Return a line between two points."""
        return Line(*self.place(*start), *self.place(*end))

    def drawing(
        self,
        curves: Sequence[tuple[ArrayLike, ArrayLike]],
        fitted: Sequence[Line] = (),
        wanted: Sequence[Line] = (),
        walls: Sequence[Line] = (),
    ) -> Drawing:
        """Draw curves, one after the other, with lines as of a `Drawing`."""
        places = [self.place(*point) for curve in curves for point in _thinned(*curve)]
        points = " ".join(f"{x:.0f},{y:.0f}" for x, y in places)
        return Drawing(
            path=f"M{places[0][0]:.0f},0 L{points} L{places[-1][0]:.0f},0Z",
            half_width=self.half_width + _SPACE,
            height=CURVE_HEIGHT + _SPACE,
            fitted=tuple(fitted),
            wanted=tuple(wanted),
            walls=tuple(walls),
        )


def _thinned(x: ArrayLike, y: ArrayLike) -> Iterator[tuple[float, float]]:
    xs, ys = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    kept = np.linspace(0, len(xs) - 1, min(len(xs), _MOST_POINTS)).astype(int)
    return zip(xs[kept].tolist(), ys[kept].tolist(), strict=True)


def surface_path(
    x: NDArray[np.float64], heights: NDArray[np.float64], ground: float, pixel: float
) -> str:
    """Return the area between a ground and a surface above it as an SVG path.

    Lengths are in m, and the size of a pixel, too.
    """
    kept = simplified(heights / pixel, _TOLERANCE)
    points = " ".join(f"{x[i] / pixel:.0f},{-(ground + heights[i]) / pixel:.0f}" for i in kept)
    base = f"{-ground / pixel:.0f}"
    return f"M{x[0] / pixel:.0f},{base} L{points} L{x[-1] / pixel:.0f},{base}Z"


def wall_line(start: tuple[float, float], end: tuple[float, float], pixel: float) -> Line:
    """Return a line between two points in the plane of a drawing, m, in pixels of a size, m."""
    return Line(*(round(value / pixel, 1) for value in (start[0], -start[1], end[0], -end[1])))


def fitted_lines(
    flanks: Sequence[Flank], ground: float, pixel: float, target: float | None
) -> tuple[tuple[Line, ...], tuple[Line, ...]]:
    """Return fitted flanks as lines of a drawing, and through them lines at a target, degrees.

    Heights of flanks are those from the ground, which has a height in the drawing, m.
    """
    lines = []
    for flank in flanks:
        (x1, y1), (x2, y2) = flank.start, flank.end
        lines.append(_line(Flank(flank.angle, (x1, y1 + ground), (x2, y2 + ground)), pixel))
    return tuple(lines), tuple(_through(line, target) for line in lines if target)


def simplified(heights: NDArray[np.float64], tolerance: float) -> list[int]:
    """Select points of an outline to keep, so that the others are near lines between them.

    References
    ----------
    Ramer (1972), Comput. Graph. Image Process. 1, 244-256, with vertical distances.
    """
    kept = {0, len(heights) - 1}
    open_parts = [(0, len(heights) - 1)]
    while open_parts:
        first, last = open_parts.pop()
        if last - first < 2:
            continue
        line = np.linspace(heights[first], heights[last], last - first + 1)
        distance = np.abs(heights[first : last + 1] - line)
        worst = first + int(np.argmax(distance))
        if distance[worst - first] > tolerance:
            kept.add(worst)
            open_parts += [(first, worst), (worst, last)]
    return sorted(kept)


def _line(flank: Flank, size: float) -> Line:
    (x1, y1), (x2, y2) = flank.start, flank.end
    return Line(*(round(value / size, 1) for value in (x1, -y1, x2, -y2)))


def _through(line: Line, angle: float) -> Line:
    """A line at an angle through the middle of a flank, a little longer than that."""
    side = math.copysign(1.0, line.x1 - line.x2)
    along = np.array([side * math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    middle = np.array([line.x1 + line.x2, line.y1 + line.y2]) / 2
    reach = 0.6 * math.hypot(line.x1 - line.x2, line.y1 - line.y2)
    (x1, y1), (x2, y2) = middle + reach * along, middle - reach * along
    return Line(*(round(float(value), 1) for value in (x1, y1, x2, y2)))
