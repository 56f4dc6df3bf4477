"""Pictures of a measured heap: silhouettes with the fitted flanks, as PNG."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from grainfit.measurement.angle_of_repose import (
    AngleOfRepose,
    Flank,
    View,
    heap_silhouette,
    on_plate,
)
from grainfit.measurement.particles import Particles

#: Everything is drawn this much larger and then reduced, for smooth edges.
_OVERSAMPLING = 2
_PANEL_WIDTH = 640 * _OVERSAMPLING
_HIGHEST_PANEL = 480 * _OVERSAMPLING
_MARGIN = 24 * _OVERSAMPLING
_GAP = 44 * _OVERSAMPLING
_TITLE_SIZE = 30 * _OVERSAMPLING
_TEXT_SIZE = 17 * _OVERSAMPLING
_SHOWN_VIEWS = 4
_COLUMNS = 2

_PAPER = "#ffffff"
_INK = "#1f2933"
_QUIET_INK = "#616e7c"
_HEAP = "#b4bfca"
# Vermilion: distinct from grey and all other colours in any kind of colour blindness
# (Okabe & Ito, Color Universal Design).
_FLANK = "#d55e00"


def draw_heap(
    path: Path,
    particles: Particles,
    plate_radius: float,
    ground: float,
    measured: AngleOfRepose | str,
) -> None:
    """Write a PNG of a heap's silhouettes with the fitted flanks and the angle of repose.

    Parameters
    ----------
    path : Path
        File to write; ends in ``.png``.
    particles : Particles
        As given to `angle_of_repose`.
    plate_radius, ground : float
        As given to `angle_of_repose`, m.
    measured : AngleOfRepose or str
        The measurement, or the reason why there is none: then no flanks are drawn.
    """
    if isinstance(measured, str):
        title = "Angle of repose: not measurable"
        subtitle = measured.removeprefix("angle of repose: ")
        angles = np.arange(_SHOWN_VIEWS) * 180.0 / _SHOWN_VIEWS
        views = tuple(View(float(azimuth), None, None) for azimuth in angles)
    else:
        title = f"Angle of repose {measured.value:.1f}° ± {measured.standard_error:.1f}°"
        flanks = sum((v.left is not None) + (v.right is not None) for v in measured.views)
        shown = min(_SHOWN_VIEWS, len(measured.views))
        views = measured.views[:: len(measured.views) // shown][:shown]
        subtitle = (
            f"mean inclination of {flanks} flanks ± standard error; "
            f"{shown} of {len(measured.views)} views shown"
        )
    heap = on_plate(particles, plate_radius)
    panels = [_panel(heap, view, plate_radius, ground) for view in views] if len(heap) else []
    _sheet(title, subtitle, panels).save(path)


def _panel(heap: Particles, view: View, plate_radius: float, ground: float) -> Image.Image:
    silhouette = heap_silhouette(heap, view.azimuth, plate_radius)
    rows, columns = silhouette.image.shape
    scale = min(_PANEL_WIDTH / columns, _HIGHEST_PANEL / rows)
    height = math.ceil(rows * scale)
    mask = Image.fromarray(silhouette.image.astype(np.uint8) * 255)
    mask = mask.resize((round(columns * scale), height), Image.Resampling.LANCZOS)
    offset = (_PANEL_WIDTH - mask.width) // 2
    panel = Image.new("RGB", (_PANEL_WIDTH, height + 2 * _TEXT_SIZE), _PAPER)
    panel.paste(_HEAP, (offset, 0), mask)
    draw = ImageDraw.Draw(panel)

    def place(point: tuple[float, float]) -> tuple[float, float]:
        across = (point[0] - silhouette.left) / silhouette.pixel_size
        return offset + across * scale, height - point[1] / silhouette.pixel_size * scale

    plate = min(plate_radius, -silhouette.left)
    draw.line([place((-plate, 0)), place((plate, 0))], fill=_INK, width=2 * _OVERSAMPLING)
    _dashed_line(draw, place((-plate, ground)), place((plate, ground)))
    for flank in (view.left, view.right):
        if flank is not None:
            _draw_flank(draw, flank, place(flank.start), place(flank.end))
    label = f"azimuth {view.azimuth:.0f}°"
    draw.text(
        (_PANEL_WIDTH / 2, height + _TEXT_SIZE / 2),
        label,
        fill=_QUIET_INK,
        font=_font(_TEXT_SIZE),
        anchor="ma",
    )
    return panel


def _dashed_line(
    draw: ImageDraw.ImageDraw, start: tuple[float, float], end: tuple[float, float]
) -> None:
    dash = 6 * _OVERSAMPLING
    for x in np.arange(start[0], end[0], 2 * dash):
        line = [(x, start[1]), (min(x + dash, end[0]), start[1])]
        draw.line(line, fill=_QUIET_INK, width=_OVERSAMPLING)


def _draw_flank(
    draw: ImageDraw.ImageDraw,
    flank: Flank,
    start: tuple[float, float],
    end: tuple[float, float],
) -> None:
    draw.line([start, end], fill=_FLANK, width=3 * _OVERSAMPLING)
    # Beside the middle of the line, on the outer and upper side, where the heap is not.
    outward = math.copysign(1.0, start[0] - end[0])
    middle = (start[0] + end[0]) / 2 + outward * _TEXT_SIZE, (start[1] + end[1]) / 2 - _TEXT_SIZE
    draw.text(
        middle,
        f"{flank.angle:.1f}°",
        fill=_FLANK,
        font=_font(_TEXT_SIZE),
        anchor="ls" if outward > 0 else "rs",
    )


def _sheet(title: str, subtitle: str, panels: list[Image.Image]) -> Image.Image:
    columns = max(1, min(_COLUMNS, len(panels)))
    width = 2 * _MARGIN + columns * _PANEL_WIDTH + (columns - 1) * _GAP
    lines = _wrapped(subtitle, width - 2 * _MARGIN)
    top = _MARGIN + round(1.5 * _TITLE_SIZE) + round(1.4 * _TEXT_SIZE * len(lines)) + _MARGIN
    row_height = max((panel.height for panel in panels), default=0)
    sheet_rows = math.ceil(len(panels) / columns)
    sheet = Image.new("RGB", (width, top + sheet_rows * row_height + _MARGIN), _PAPER)
    draw = ImageDraw.Draw(sheet)
    draw.text((_MARGIN, _MARGIN), title, fill=_INK, font=_font(_TITLE_SIZE))
    for number, line in enumerate(lines):
        place = (_MARGIN, _MARGIN + 1.5 * _TITLE_SIZE + 1.4 * _TEXT_SIZE * number)
        draw.text(place, line, fill=_QUIET_INK, font=_font(_TEXT_SIZE))
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        lowered = top + (row + 1) * row_height - panel.height
        sheet.paste(panel, (_MARGIN + column * (_PANEL_WIDTH + _GAP), lowered))
    return sheet.reduce(_OVERSAMPLING)


def _wrapped(text: str, width: float) -> list[str]:
    font = _font(_TEXT_SIZE)
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and font.getlength(longer) > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)
