"""Line charts as panels of a sheet: axes with units, ticks, a grid, and a legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from grainfit.measurement.sheet import INK, OVERSAMPLING, PAPER, QUIET_INK, TEXT_SIZE, font

_GRID = "#e4e7eb"
_MOST_TICKS = 6
#: Room above the highest value, over the range.
_ROOM = 0.08
_GAP = TEXT_SIZE // 2
_ROW = round(1.5 * TEXT_SIZE)


@dataclass(frozen=True)
class PlottedLine:
    """A line of a chart.

    Parameters
    ----------
    x, y : array_like of shape (n,)
        Its points, in the units of the axes.
    label : str
        Its entry in the legend; empty for none.
    colour : str
        Its colour.
    width : int
        Its width, pixels of the finished picture.
    """

    x: ArrayLike
    y: ArrayLike
    label: str = ""
    colour: str = QUIET_INK
    width: int = 2


@dataclass(frozen=True)
class _Range:
    """Interval of an axis, and where it is on the panel, pixels."""

    low: float
    high: float
    start: float
    end: float

    def place(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return values as pixels."""
        shares = (np.asarray(values, dtype=float) - self.low) / (self.high - self.low)
        return self.start + shares * (self.end - self.start)

    @property
    def ticks(self) -> list[float]:
        """Round numbers within the interval."""
        least = (self.high - self.low) / _MOST_TICKS
        power = 10.0 ** math.floor(math.log10(least))
        step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [step * number for number in range(first, last + 1)]


def line_panel(
    lines: Sequence[PlottedLine],
    x_label: str,
    y_label: str,
    size: tuple[float, float],
    *,
    from_zero: bool = True,
    across_from_zero: bool = True,
    marks: Sequence[float] = (),
) -> Image.Image:
    """Draw lines over common axes.

    Parameters
    ----------
    lines : sequence of PlottedLine
        Those behind first.
    x_label, y_label : str
        Quantities of the axes with their units.
    size : tuple of float
        Width and height, pixels, oversampled.
    from_zero, across_from_zero : bool
        Whether the vertical and the horizontal axis have zero.
    marks : sequence of float
        Places of thin vertical lines, in the unit of the horizontal axis.
    """
    width, height = (round(side) for side in size)
    panel = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(panel)
    across = _interval([line.x for line in lines], 0.0, across_from_zero)
    up = _interval([line.y for line in lines], _ROOM, from_zero)
    top = _ROW * (2 if any(line.label for line in lines) else 1)
    vertical = _Range(*up, height - 2 * _ROW - _GAP, top)
    left = max(font(TEXT_SIZE).getlength(_shown(tick)) for tick in vertical.ticks) + 2 * _GAP
    horizontal = _Range(*across, left, width - 2 * _GAP)
    _draw_axes(draw, horizontal, vertical, x_label, y_label)
    for mark in horizontal.place(list(marks)).tolist():
        draw.line([(mark, vertical.start), (mark, vertical.end)], QUIET_INK, OVERSAMPLING)
    for line in lines:
        points = np.column_stack((horizontal.place(line.x), vertical.place(line.y))).ravel()
        draw.line(points.tolist(), line.colour, line.width * OVERSAMPLING, joint="curve")
    _draw_legend(draw, lines, left)
    return panel


def _interval(values: Sequence[ArrayLike], room: float, has_zero: bool) -> tuple[float, float]:
    """Return an interval of all values, with room at the ends that are not zero."""
    every = np.concatenate([np.asarray(some, dtype=float) for some in values])
    low, high = float(every.min()), float(every.max())
    if has_zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if high == low:
        high = low + (abs(low) or 1.0)
    extent = high - low
    return low - room * extent * (low != 0), high + room * extent * (high != 0)


def _shown(tick: float) -> str:
    return f"{tick:.4g}"


def _draw_axes(
    draw: ImageDraw.ImageDraw, across: _Range, up: _Range, x_label: str, y_label: str
) -> None:
    used = font(TEXT_SIZE)
    for tick, x in zip(across.ticks, across.place(across.ticks).tolist(), strict=True):
        draw.line([(x, up.start), (x, up.end)], _GRID, OVERSAMPLING)
        draw.text((x, up.start + _GAP), _shown(tick), QUIET_INK, used, "ma")
    for tick, y in zip(up.ticks, up.place(up.ticks).tolist(), strict=True):
        draw.line([(across.start, y), (across.end, y)], _GRID, OVERSAMPLING)
        draw.text((across.start - _GAP, y), _shown(tick), QUIET_INK, used, "rm")
    corner = (across.start, up.start)
    draw.line([(across.start, up.end), corner, (across.end, up.start)], INK, OVERSAMPLING)
    middle = ((across.start + across.end) / 2, up.start + _GAP + _ROW)
    draw.text(middle, x_label, INK, used, "ma")
    draw.text((across.start, up.end - _GAP), y_label, INK, used, "ls")


def _draw_legend(draw: ImageDraw.ImageDraw, lines: Sequence[PlottedLine], left: float) -> None:
    """Draw a sample and the label of each line that has one, in a row above the axes."""
    used, x, y = font(TEXT_SIZE), left, TEXT_SIZE / 2
    for line in lines:
        if line.label:
            draw.line([(x, y), (x + _ROW, y)], line.colour, line.width * OVERSAMPLING)
            draw.text((x + _ROW + _GAP, y), line.label, line.colour, used, "lm")
            x += _ROW + 3 * _GAP + used.getlength(line.label)
