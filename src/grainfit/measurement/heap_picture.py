"""Pictures of a measured heap: silhouettes with the fitted flanks, as PNG."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from grainfit.measurement.angle_of_repose import AngleOfRepose, View, heap_silhouette, on_plate
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import (
    INK,
    OVERSAMPLING,
    PAPER,
    QUIET_INK,
    TEXT_SIZE,
    draw_flank,
    font,
    sheet,
)

_PANEL_WIDTH = 640 * OVERSAMPLING
_HIGHEST_PANEL = 480 * OVERSAMPLING
_SHOWN_VIEWS = 4
_HEAP = "#b4bfca"


def draw_heap(
    path: Path,
    particles: Particles,
    plate_radius: float,
    ground: float,
    measured: AngleOfRepose | str,
) -> None:
    """Write a PNG of a heap's silhouettes with the fitted flanks and the angle of repose.

    Of a heap that is not measurable, it has the reason, and no flanks. Lengths are those that
    `angle_of_repose` takes.
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
    sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)


def _panel(heap: Particles, view: View, plate_radius: float, ground: float) -> Image.Image:
    silhouette = heap_silhouette(heap, view.azimuth, plate_radius)
    rows, columns = silhouette.image.shape
    scale = min(_PANEL_WIDTH / columns, _HIGHEST_PANEL / rows)
    height = math.ceil(rows * scale)
    mask = Image.fromarray(silhouette.image.astype(np.uint8) * 255)
    mask = mask.resize((round(columns * scale), height), Image.Resampling.LANCZOS)
    offset = (_PANEL_WIDTH - mask.width) // 2
    panel = Image.new("RGB", (_PANEL_WIDTH, height + 2 * TEXT_SIZE), PAPER)
    panel.paste(_HEAP, (offset, 0), mask)
    draw = ImageDraw.Draw(panel)

    def place(point: tuple[float, float]) -> tuple[float, float]:
        across = (point[0] - silhouette.left) / silhouette.pixel_size
        return offset + across * scale, height - point[1] / silhouette.pixel_size * scale

    plate = min(plate_radius, -silhouette.left)
    draw.line([place((-plate, 0)), place((plate, 0))], fill=INK, width=2 * OVERSAMPLING)
    _dashed_line(draw, place((-plate, ground)), place((plate, ground)))
    for flank in (view.left, view.right):
        if flank is not None:
            draw_flank(draw, flank, place(flank.start), place(flank.end))
    label = f"azimuth {view.azimuth:.0f}°"
    draw.text(
        (_PANEL_WIDTH / 2, height + TEXT_SIZE / 2),
        label,
        fill=QUIET_INK,
        font=font(TEXT_SIZE),
        anchor="ma",
    )
    return panel


def _dashed_line(
    draw: ImageDraw.ImageDraw, start: tuple[float, float], end: tuple[float, float]
) -> None:
    dash = 6 * OVERSAMPLING
    for x in np.arange(start[0], end[0], 2 * dash):
        line = [(x, start[1]), (min(x + dash, end[0]), start[1])]
        draw.line(line, fill=QUIET_INK, width=OVERSAMPLING)
