"""Picture of a shear test: the bed with its velocity profile, and stress ratio over strain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.bulk_tests.shear.flow import Record
from grainfit.bulk_tests.shear.view import ShearView
from grainfit.evaluation import Response
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.sheet import FLANK, OVERSAMPLING, sheet

_PANEL_WIDTH = 560 * OVERSAMPLING
_RATIO_SIZE = _PANEL_WIDTH, 420 * OVERSAMPLING
#: Records of so many are averaged, or the curve would be a cloud.
_SMOOTHED = 10


def draw_shear(
    path: Path, view: ShearView, records: Sequence[Record], transient: int, angle: Response
) -> None:
    """Write a PNG of the bed, and of shear stress over normal stress against strain.

    The first records are the transient, which is thrown away.
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
    start = records[0].travels[0]
    strains = np.concatenate([(r.travels - start) / gap for r in records])
    averaged = float(records[transient].travels[0] - start) / gap
    normal = np.mean([r.normal_stresses.mean() for r in records[transient:]])
    ratios = np.concatenate([r.shear_stresses for r in records]) / normal
    used = len(ratios) - len(ratios) % _SMOOTHED
    strains, ratios = (
        values[:used].reshape(-1, _SMOOTHED).mean(axis=1) for values in (strains, ratios)
    )
    ends = [averaged, float(strains[-1])]
    lines = [
        PlottedLine(strains, ratios),
        PlottedLine(ends, 2 * [mean], f"mean after the transient {mean:.3f}", FLANK, 4),
    ]
    return line_panel(lines, "shear strain", "shear stress over normal stress", _RATIO_SIZE)
