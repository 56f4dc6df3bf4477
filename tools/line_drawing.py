"""Line drawings with dimensions as small SVG files: points in m, offsets in pixels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]
Segments = NDArray[np.float64]
Side = Literal["left", "right", "above", "below"]

#: Classes: walls that stand, move and are put later have the colours of `grainfit preview`; blue
#: are options of the file, purple what is measured. The ground is pale in light and dark pages.
STYLE = """
text{font:12px monospace}.title{font:bold 13px sans-serif;fill:#222}.words{font:12px sans-serif}
path,circle{fill:none;stroke-linejoin:round}
.sand{fill:#e2d2a6}.ghost{stroke:#8a7a4a;stroke-dasharray:4 3}.grain{fill:#b9c1c9;stroke:#5b6b77}
.still{stroke:#4d5b68;stroke-width:2.5}.moving{stroke:#d55e00;stroke-width:2.5}
.later{stroke:#009e73;stroke-width:2.5}.axis{stroke:#9aa5af;stroke-dasharray:8 3 2 3}
.border{stroke:#9aa5af;stroke-dasharray:4 4}.frame{stroke:#5b6b77}
.option{stroke:#1f5fa8}text.option{fill:#1f5fa8;stroke:none}
.found{stroke:#8e2a80}text.found{fill:#8e2a80;stroke:none}
.push{stroke:#d55e00;stroke-width:1.6}text.push{fill:#b34700;stroke:none}
text.note{fill:#444}
"""
_CHARACTER, _LINE = 7.25, 15
_TICK = 4.0
_MARGIN = 14.0
_SPACE = 26.0


@dataclass(frozen=True)
class _Text:
    at: Point
    shift: Point
    words: str
    style: str
    anchor: str


@dataclass(frozen=True)
class _Line:
    points: tuple[Point, ...]
    shift: Point
    style: str
    is_closed: bool = False
    lengthened: Point = (0.0, 0.0)


@dataclass
class Panel:
    """One state of an apparatus. The second coordinate of a point is its height.

    Parameters
    ----------
    title : str
        What is shown.
    """

    title: str
    bodies: list[str | _Line | _Text | tuple[Point, float, str]] = field(default_factory=list)
    dimensions: list[_Line | _Text] = field(default_factory=list)

    def area(self, *points: Point, style: str = "sand") -> None:
        """Draw a closed shape."""
        self.bodies.append(_Line(points, (0, 0), style, is_closed=True))

    def line(self, *points: Point, style: str = "still") -> None:
        """Draw a line through points."""
        self.bodies.append(_Line(points, (0, 0), style))

    def circle(self, centre: Point, radius: float, style: str = "grain") -> None:
        """Draw a circle."""
        self.bodies.append((centre, radius, style))

    def size(
        self,
        start: Point,
        end: Point,
        name: str,
        off: float = 0.0,
        side: Side | None = None,
        style: str = "option",
    ) -> None:
        """Draw a horizontal or vertical distance, at an offset upwards or to the right."""
        is_level = start[1] == end[1]
        out = (0.0, -off) if is_level else (off, 0.0)
        tick = (0.0, _TICK) if is_level else (_TICK, 0.0)
        for point in (start, end):
            if off:
                sign = math.copysign(1, off)
                beyond = (out[0] + sign * tick[0], out[1] - sign * tick[1])
                self.dimensions.append(_Line((point, point), (0, 0), style, lengthened=beyond))
            else:
                ends = (-2 * tick[0], -2 * tick[1])
                self.dimensions.append(_Line((point, point), tick, style, lengthened=ends))
        self.dimensions.append(_Line((start, end), out, style))
        self._name(start, end, out, name, side or ("above" if is_level else "right"), style)

    def _name(
        self, start: Point, end: Point, out: Point, name: str, side: Side, style: str
    ) -> None:
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        if side in ("above", "below"):
            rows = (len(name.split("\n")) - 1) / 2 * _LINE
            down = -6 - rows if side == "above" else 15 + rows
            self._words(middle, (out[0], out[1] + down), name, style)
        else:
            left, right = sorted((start, end))
            at = middle if start[0] == end[0] else left if side == "left" else right
            move = (-9.0, "end") if side == "left" else (9.0, "start")
            self._words(at, (out[0] + move[0], out[1] + 4), name, style, move[1])

    def _words(
        self, at: Point, shift: Point, name: str, style: str, anchor: str = "middle"
    ) -> None:
        rows = name.split("\n")
        for row, words in enumerate(rows):
            down = (row - (len(rows) - 1) / 2) * _LINE
            self.dimensions.append(_Text(at, (shift[0], shift[1] + down), words, style, anchor))

    def angle(
        self,
        apex: Point,
        radius: float,
        first: float,
        last: float,
        name: str,
        style: str = "option",
        shift: Point = (6.0, 4.0),
        anchor: str = "start",
    ) -> None:
        """Draw an angle between two directions, degrees from the right, with its two legs."""
        arc = tuple(
            (
                apex[0] + radius * math.cos(math.radians(a)),
                apex[1] + radius * math.sin(math.radians(a)),
            )
            for a in np.linspace(first, last, 9)
        )
        self.dimensions.append(_Line(arc, (0, 0), style))
        for end in (arc[0], arc[-1]):
            reach = (apex[0] + 1.25 * (end[0] - apex[0]), apex[1] + 1.25 * (end[1] - apex[1]))
            self.dimensions.append(_Line((apex, reach), (0, 0), style))
        self._words(arc[4], shift, name, style, anchor)

    def arrow(self, at: Point, way: Point, name: str, side: Side, style: str = "push") -> None:
        """Draw an arrow of a way in pixels that ends at a point, and words at its beginning."""
        length = math.hypot(*way)
        along = (way[0] / length, way[1] / length)
        self.dimensions.append(_Line((at, at), (-way[0], -way[1]), style, lengthened=way))
        for turn in (-1, 1):
            barb = (
                -7 * along[0] - 4 * turn * along[1],
                -7 * along[1] + 4 * turn * along[0],
            )
            self.dimensions.append(_Line((at, at), (0, 0), style, lengthened=barb))
        begin = (-way[0], -way[1])
        move = {"left": (-6, 4), "right": (6, 4), "above": (0, -5), "below": (0, 15)}[side]
        anchor = {"left": "end", "right": "start"}.get(side, "middle")
        self._words(at, (begin[0] + move[0], begin[1] + move[1]), name, style, anchor)

    def note(
        self,
        at: Point,
        words: str,
        style: str = "note",
        shift: Point = (0.0, 0.0),
        anchor: str = "middle",
    ) -> None:
        """Write words at a point."""
        self._words(at, shift, words, style, anchor)


def section(triangles: Segments, axis: int, at: float) -> Segments:
    """Return the section of triangles by a plane across the x or the y axis, joined lines.

    Its points are places on the other horizontal axis and heights, shape (n, 2, 2), m.
    """
    found = []
    for corners in triangles:
        away = corners[:, axis] - at
        crossing = [
            corners[i] + (corners[j] - corners[i]) * away[i] / (away[i] - away[j])
            for i, j in ((0, 1), (1, 2), (2, 0))
            if (away[i] > 0) != (away[j] > 0)
        ]
        if len(crossing) == 2:
            found.append([point[[1 - axis, 2]] for point in crossing])
    return _joined(np.array(found).reshape(-1, 2, 2))


def _joined(segments: Segments) -> Segments:
    """Return segments of one line as one where they meet."""
    lines: dict[tuple[float, ...], list[tuple[float, float, Segments]]] = {}
    for ends in segments:
        way = ends[1] - ends[0]
        length = float(np.hypot(*way))
        if length < 1e-9:
            continue
        along = way / length
        along = -along if along[0] < -1e-9 or (abs(along[0]) <= 1e-9 and along[1] < 0) else along
        offset = float(along[0] * ends[0][1] - along[1] * ends[0][0])
        key = (*(round(float(a), 4) + 0.0 for a in along), round(offset, 6) + 0.0)
        low, high = sorted(float(along @ end) for end in ends)
        lines.setdefault(key, []).append((low, high, along))
    found = []
    for (*_, offset), parts in lines.items():
        parts.sort(key=lambda part: part[:2])
        low, high, along = parts[0]
        across = np.array([-along[1], along[0]]) * offset
        for next_low, next_high, _ in parts[1:]:
            if next_low > high + 1e-6:
                found.append([along * low + across, along * high + across])
                low = next_low
            high = max(high, next_high)
        found.append([along * low + across, along * high + across])
    return np.array(found).reshape(-1, 2, 2)


def drawing(
    title: str, panels: Sequence[Panel], scale: float, words: str = "", columns: int = 3
) -> str:
    """Return panels in rows as SVG.

    Parameters
    ----------
    title : str
        For those who do not see it.
    panels : sequence of Panel
        From left to right, with their heights of zero on one line.
    scale : float
        Pixels per m.
    words : str
        Line below the picture.
    columns : int
        Number of panels in a row.
    """
    width, height, found = 2 * _MARGIN + 6.2 * len(words), _MARGIN, []
    for first in range(0, len(panels), columns):
        row, wide, high = _row(panels[first : first + columns], scale, height)
        found += row
        width, height = max(width, wide), height + high + _MARGIN
    if words:
        found.append(
            f'<text class="words note" x="{_MARGIN:g}" y="{height + 8:.0f}">{words}</text>'
        )
        height += 20
    return _svg(title, width, height, found)


def _row(panels: Sequence[Panel], scale: float, down: float) -> tuple[list[str], float, float]:
    """Return the SVG of panels beside each other, with its width and its height."""
    parts, left, high, low = [], _MARGIN, 0.0, 0.0
    for panel in panels:
        marks = _Marks(scale)
        marks.draw(panel.bodies)
        marks.draw(panel.dimensions)
        middle = max((marks.high - marks.low) / 2, len(panel.title) * 3.9)
        shift = left + middle - (marks.low + marks.high) / 2
        parts.append((shift, left + middle, marks, panel.title))
        left += 2 * middle + _SPACE
        high, low = min(high, marks.top), max(low, marks.bottom)
    found = []
    ground = down + 22 - high
    for shift, middle, marks, title in parts:
        found.append(
            f'<text class="title" x="{middle:.0f}" y="{down + 8:.0f}" '
            f'text-anchor="middle">{title}</text>'
            f'<g transform="translate({shift:.1f} {ground:.1f})">{"".join(marks.found)}</g>'
        )
    return found, left - _SPACE + _MARGIN, 22 - high + low


def overview(title: str, panels: Sequence[tuple[str, Sequence[str], Panel]], columns: int) -> str:
    """Return panels without their dimensions in rows, each with a name and lines of words."""
    wide, high, room = 190, 178, 96
    found = []
    for number, (name, lines, panel) in enumerate(panels):
        probe = _Marks(1000.0)
        probe.draw(panel.bodies)
        scale = 1000 * min(140 / (probe.high - probe.low), room / (probe.bottom - probe.top))
        marks = _Marks(scale)
        marks.draw(panel.bodies)
        x = (number % columns + 0.5) * wide
        y = number // columns * high + 18
        across = x - (marks.low + marks.high) / 2
        found.append(
            f'<g transform="translate({across:.1f} {y + room - marks.bottom:.1f})">'
            f"{''.join(marks.found)}</g>"
            f'<text class="option" x="{x:g}" y="{y + room + 22}" text-anchor="middle">{name}</text>'
        )
        found += [
            f'<text class="words note" x="{x:g}" y="{y + room + 39 + 15 * row}" '
            f'text-anchor="middle">{line}</text>'
            for row, line in enumerate(lines)
        ]
    return _svg(title, columns * wide, math.ceil(len(panels) / columns) * high, found)


def _svg(title: str, width: float, height: float, bodies: Sequence[str]) -> str:
    size = f'width="{width:.0f}" height="{height:.0f}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" {size}>',
        f"<title>{title}</title><style>{STYLE}</style>",
        f'<rect {size} rx="8" fill="#fbfbf9"/>',
        *bodies,
        "</svg>\n",
    ]
    return "\n".join(lines)


class _Marks:
    """SVG of marks at a scale, and how far they reach, pixels."""

    def __init__(self, scale: float) -> None:
        self.scale = scale
        self.found: list[str] = []
        self.low = self.top = math.inf
        self.high = self.bottom = -math.inf

    def draw(self, marks: Sequence[str | _Line | _Text | tuple[Point, float, str]]) -> None:
        """Add marks; lines of one class that follow each other become one path."""
        style, data = "", ""
        for mark in marks:
            if isinstance(mark, _Line):
                if mark.style != style:
                    self._path(style, data)
                    style, data = mark.style, ""
                data += self._line(mark)
                continue
            self._path(style, data)
            style, data = "", ""
            if isinstance(mark, _Text):
                self._text(mark)
            elif isinstance(mark, tuple):
                self._circle(*mark)
        self._path(style, data)

    def _place(self, point: Point, shift: Point = (0.0, 0.0)) -> Point:
        x = point[0] * self.scale + shift[0]
        y = -point[1] * self.scale + shift[1]
        self._reach(x, x, y, y)
        return x, y

    def _reach(self, low: float, high: float, top: float, bottom: float) -> None:
        self.low, self.high = min(self.low, low), max(self.high, high)
        self.top, self.bottom = min(self.top, top), max(self.bottom, bottom)

    def _path(self, style: str, data: str) -> None:
        if data:
            self.found.append(f'<path class="{style}" d="{data}"/>')

    def _line(self, line: _Line) -> str:
        *before, last = (self._place(point, line.shift) for point in line.points)
        last = (last[0] + line.lengthened[0], last[1] + line.lengthened[1])
        self._reach(last[0], last[0], last[1], last[1])
        places = [f"{_short(x)} {_short(y)}" for x, y in (*before, last)]
        return "M" + "L".join(places) + ("Z" if line.is_closed else "")

    def _text(self, text: _Text) -> None:
        x, y = self._place(text.at, text.shift)
        font = "words " if text.style == "note" and "_" not in text.words else ""
        width = len(text.words) * (6.3 if font else _CHARACTER)
        begin = x - {"start": 0.0, "middle": 0.5, "end": 1.0}[text.anchor] * width
        self._reach(begin, begin + width, y - 10, y + 4)
        self.found.append(
            f'<text class="{font}{text.style}" x="{_short(x)}" y="{_short(y)}" '
            f'text-anchor="{text.anchor}">{text.words}</text>'
        )

    def _circle(self, centre: Point, radius: float, style: str) -> None:
        x, y = self._place(centre)
        r = radius * self.scale
        self._reach(x - r, x + r, y - r, y + r)
        self.found.append(
            f'<circle class="{style}" cx="{_short(x)}" cy="{_short(y)}" r="{_short(r)}"/>'
        )


def _short(pixels: float) -> str:
    return f"{round(pixels, 1) + 0.0:g}"
