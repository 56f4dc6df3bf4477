"""Picture of a shear test: the bed with its velocity profile, and stress ratio over strain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from grainfit.bulk_tests.shear.flow import Record
from grainfit.bulk_tests.shear.view import ShearView
from grainfit.evaluation import Response
from grainfit.measurement.sheet import (
    FLANK,
    INK,
    OVERSAMPLING,
    PAPER,
    QUIET_INK,
    TEXT_SIZE,
    font,
    sheet,
)

_PANEL_WIDTH = 560 * OVERSAMPLING
_HEIGHT = 420 * OVERSAMPLING
_MARGIN = 60 * OVERSAMPLING
#: Records of so many are averaged, or the curve would be a cloud.
_SMOOTHED = 10


def draw_shear(
    path: Path, view: ShearView, records: Sequence[Record], transient: int, angle: Response
) -> None:
    """Write a PNG of the bed, and of shear stress over normal stress against strain.

    Parameters
    ----------
    path : Path
        File to write; ends in ``.png``.
    view : ShearView
        The bed at the end.
    records : sequence of Record
        Of all stages in which the bed is sheared.
    transient : int
        So many of them are thrown away.
    angle : Response
        Angle of internal friction, degrees.
    """
    title = f"Angle of internal friction {angle.value:.1f} ± {angle.standard_error:.1f}°"
    subtitle = (
        "± standard error; left, the bed with its plates (grey) and the velocity from 0 to that of "
        "the upper plate; right, shear stress over normal stress against shear strain, and its "
        "mean after the transient"
    )
    panels = [
        view.side_view().panel(_PANEL_WIDTH),
        _ratio_panel(records, transient, view.profile.gap, math.tan(math.radians(angle.value))),
    ]
    sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)


def _ratio_panel(records: Sequence[Record], transient: int, gap: float, mean: float) -> Image.Image:
    panel = Image.new("RGB", (_PANEL_WIDTH, _HEIGHT), PAPER)
    draw = ImageDraw.Draw(panel)
    start = records[0].travels[0]
    strains = np.concatenate([(r.travels - start) / gap for r in records])
    averaged = float(records[transient].travels[0] - start) / gap
    normal = np.mean([r.normal_stresses.mean() for r in records[transient:]])
    ratios = np.concatenate([r.shear_stresses for r in records]) / normal
    used = len(ratios) - len(ratios) % _SMOOTHED
    strains, ratios = (
        values[:used].reshape(-1, _SMOOTHED).mean(axis=1) for values in (strains, ratios)
    )
    longest, highest = float(strains[-1]), 1.15 * max(float(ratios.max()), mean)

    def place(strain: float, ratio: float) -> tuple[float, float]:
        across = _MARGIN + strain / longest * (_PANEL_WIDTH - 1.5 * _MARGIN)
        return across, _HEIGHT - _MARGIN - max(ratio, 0) / highest * (_HEIGHT - 2 * _MARGIN)

    used_font = font(TEXT_SIZE)
    draw.line([place(0, highest), place(0, 0), place(longest, 0)], fill=INK, width=OVERSAMPLING)
    draw.line([place(*p) for p in zip(strains, ratios, strict=True)], QUIET_INK, 2 * OVERSAMPLING)
    draw.line([place(averaged, mean), place(longest, mean)], FLANK, 4 * OVERSAMPLING)
    below = _HEIGHT - _MARGIN + TEXT_SIZE / 3
    for strain in range(int(longest) + 1):
        draw.text((place(strain, 0)[0], below), f"{strain}", QUIET_INK, used_font, "ma")
    for tick in np.arange(0, highest, 0.1 if highest < 1 else 0.5):
        at = place(0, float(tick))
        draw.text((at[0] - TEXT_SIZE / 3, at[1]), f"{tick:.1f}", QUIET_INK, used_font, "rm")
    draw.text((_MARGIN, _MARGIN - TEXT_SIZE), "stress ratio over strain", INK, used_font, "ls")
    beside = (place(longest, 0)[0], _MARGIN - TEXT_SIZE)
    draw.text(beside, f"mean {mean:.3f}", FLANK, used_font, "rs")
    return panel
