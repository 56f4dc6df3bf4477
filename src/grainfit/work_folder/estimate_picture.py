"""The picture of an estimate: how probable the values of every parameter are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.atlas.estimate import Estimate, EstimatedParameter
from grainfit.files import writing
from grainfit.formatting import unit_for_people
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.sheet import FLANK, OVERSAMPLING, save_picture, sheet

_WIDTH = 560 * OVERSAMPLING
_SIZE = (_WIDTH, 260 * OVERSAMPLING)
_BLUE = "#1f5fa8"
#: Points of a curve, and the width of the kernel that smooths it, shares of the interval.
_POINTS, _KERNEL = 160, 0.03


def draw_estimate(estimate: Estimate, path: Path) -> None:
    """Write a PNG of the probability density of every parameter over its given interval.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    panels = [_panel(estimate, axis, one) for axis, one in enumerate(estimate.parameters)]
    subtitle = (
        "blue: probability density by the atlas; orange: 95 % interval and most probable value. "
        "Not simulated: a calibration verifies it"
    )
    with writing(path):
        save_picture(sheet("Estimate of the parameters", subtitle, panels, _WIDTH), path)


def _panel(estimate: Estimate, axis: int, one: EstimatedParameter) -> Image.Image:
    shares = np.linspace(0.0, 1.0, _POINTS)
    places = estimate.points[:, axis]
    # Mirrored at the bounds, beyond which there is nothing.
    images = np.concatenate([places, -places, 2.0 - places])
    off = (shares[:, None] - images) / _KERNEL
    density = np.exp(-0.5 * off**2) @ np.tile(estimate.weights, 3)
    density /= density.max()
    values = [one.parameter.from_unit(float(share)) for share in shares]
    best = estimate.best[one.parameter.name]
    lines = [
        PlottedLine(values, density, "", _BLUE, 3),
        PlottedLine([one.low, one.high], [0.02, 0.02], "", FLANK, 6),
        PlottedLine([best, best], [0.0, 1.0], "", FLANK, 2),
    ]
    label = f"{one.parameter.name}, {unit_for_people(one.parameter.unit) or '1'}"
    up = "relative probability density"
    return line_panel(lines, label, up, _SIZE, across_from_zero=False)
