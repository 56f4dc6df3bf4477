"""Drawings and curves of the report as parts of a PDF page."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Sequence
from io import BytesIO
from typing import Any

from reportlab.lib.utils import ImageReader
from reportlab.platypus import Flowable, Image

from grainfit.formatting import number, plain, unit_for_people
from grainfit.measurement.drawing import Drawing, Line
from grainfit.pdf import REGULAR
from grainfit.plots.style import BLUE, VERMILION
from grainfit.result import CurveResult
from grainfit.student import NORMAL_QUANTILE

_PARTICLES, _INK = "#b9bfc6", "#222222"
#: A point of a path, with a command before it where it is not another one of a line; or its end.
_POINT = re.compile(r"([ML]?)\s*(-?[\d.]+),(-?[\d.]+)|Z")
#: Room below and left of a curve for its axes, points.
_AXES = 24.0
_SMALL = 6.0


class DrawnTest(Flowable):  # type: ignore[misc]
    """A drawing of a test, as wide as given and at most as high."""

    def __init__(self, drawing: Drawing, width: float, height: float) -> None:
        super().__init__()
        self._drawing, self._top = drawing, drawing.height + 30
        self._scale = min(width / (2 * drawing.half_width), height / self._top)
        self.width, self.height = width, self._scale * self._top + 4

    def draw(self) -> None:
        """Draw particles, walls, and fitted and wanted lines."""
        canvas, drawing = self.canv, self._drawing
        # Single particles may lie beside what the drawing shows.
        clip = canvas.beginPath()
        clip.rect(0, 0, self.width, self.height)
        canvas.clipPath(clip, stroke=0, fill=0)
        path = canvas.beginPath()
        for command, x, y in _POINT.findall(drawing.path):
            if not x:
                path.close()
            elif command == "M":
                path.moveTo(*self._place(float(x), float(y)))
            else:
                path.lineTo(*self._place(float(x), float(y)))
        canvas.setFillColor(_PARTICLES)
        canvas.drawPath(path, stroke=0, fill=1)
        ground = (Line(-drawing.half_width, 0, drawing.half_width, 0),)
        self._lines(drawing.walls or ground, _INK, 0.8)
        self._lines(drawing.wanted, VERMILION, 1.2, (4, 2))
        self._lines(drawing.fitted, BLUE, 1.2)

    def _place(self, x: float, y: float) -> tuple[float, float]:
        return self.width / 2 + self._scale * x, 3 - self._scale * y

    def _lines(
        self, lines: Iterable[Line], colour: str, width: float, dashes: Sequence[float] = ()
    ) -> None:
        canvas = self.canv
        canvas.setStrokeColor(colour)
        canvas.setLineWidth(width)
        canvas.setDash(*([list(dashes)] if dashes else []))
        for line in lines:
            canvas.line(*self._place(line.x1, line.y1), *self._place(line.x2, line.y2))


class DrawnCurve(Flowable):  # type: ignore[misc]
    """A measured curve with its 95 % intervals, and the expected one as a line."""

    def __init__(self, curve: CurveResult, width: float, height: float) -> None:
        super().__init__()
        self._curve, self.width, self.height = curve, width, height
        half = [NORMAL_QUANTILE * one for one in curve.uncertainties]
        lows = [value - h for value, h in zip(curve.measured, half, strict=True)]
        highs = [value + h for value, h in zip(curve.measured, half, strict=True)]
        self._bars = list(zip(curve.coordinates, lows, highs, strict=True))
        self._x = min(curve.coordinates), max(curve.coordinates)
        self._y = min(*lows, *curve.expected), max(*highs, *curve.expected)

    def draw(self) -> None:
        """Draw the axes with their ends, the intervals, the points and the line."""
        canvas, curve = self.canv, self._curve
        canvas.setStrokeColor(_INK)
        canvas.setFillColor(_INK)
        canvas.setLineWidth(0.5)
        canvas.rect(_AXES, _AXES, self.width - _AXES, self.height - _AXES)
        canvas.setFont(REGULAR, _SMALL)
        below = _AXES - 1.2 * _SMALL
        canvas.drawString(_AXES, below, number(self._x[0], 3))
        canvas.drawRightString(self.width, below, number(self._x[1], 3))
        axis = _axis(curve.coordinate or "coordinate", curve.coordinate_unit)
        canvas.drawCentredString((self.width + _AXES) / 2, below - 1.2 * _SMALL, axis)
        canvas.saveState()
        canvas.rotate(90)
        canvas.drawString(_AXES, 1.4 * _SMALL - _AXES, number(self._y[0], 3))
        canvas.drawRightString(self.height, 1.4 * _SMALL - _AXES, number(self._y[1], 3))
        canvas.restoreState()
        canvas.setStrokeColor(VERMILION)
        canvas.setFillColor(VERMILION)
        for x, low, high in self._bars:
            canvas.line(*self._place(x, low), *self._place(x, high))
        for x, y in zip(curve.coordinates, curve.measured, strict=True):
            canvas.circle(*self._place(x, y), 1.2, stroke=0, fill=1)
        canvas.setStrokeColor(BLUE)
        canvas.setLineWidth(1.2)
        path = canvas.beginPath()
        for index, point in enumerate(zip(curve.coordinates, curve.expected, strict=True)):
            (path.lineTo if index else path.moveTo)(*self._place(*point))
        canvas.drawPath(path)

    def _place(self, x: float, y: float) -> tuple[float, float]:
        across = (x - self._x[0]) / ((self._x[1] - self._x[0]) or 1.0)
        up = (y - self._y[0]) / ((self._y[1] - self._y[0]) or 1.0)
        room = self.width - _AXES, self.height - _AXES
        return _AXES + (0.03 + 0.94 * across) * room[0], _AXES + (0.05 + 0.9 * up) * room[1]


def kept_picture(address: str, width: float, height: float) -> Any:
    """Return the kept picture of a run, given as the address of an image in a page."""
    file = BytesIO(base64.b64decode(address.partition(",")[2]))
    across, high = ImageReader(file).getSize()
    scale = min(width / across, height / high)
    return Image(file, width=scale * across, height=scale * high)


def _axis(words: str, unit: str) -> str:
    shown = unit_for_people(unit)
    return f"{plain(words)} ({shown})" if shown else plain(words)
