"""The picture of a size study: every response over the number of particles, with its trend."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.analysis.size_study import SizesOfTest, SizeStudy
from grainfit.files import writing
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.sheet import FLANK, OVERSAMPLING, save_picture, sheet
from grainfit.problem import Target

_WIDTH = 560 * OVERSAMPLING
_SIZE = (_WIDTH, 360 * OVERSAMPLING)
_BLUE = "#1f5fa8"
#: Sizes at which a trend is drawn.
_POINTS = 40
#: Half the width of the ends of an interval, over the largest size.
_END = 0.01


def draw_sizes(study: SizeStudy, path: Path) -> None:
    """Write a PNG of every response over the size, and of the trend to the goal.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    panels = [_panel(test, target) for test in study.tests for target in test.targets]
    subtitle = (
        "blue: simulated, mean ± standard error; orange: the trend, and its 95 % interval at the "
        "size that was asked for. Size: cube root of the number of particles"
    )
    title = "Responses over the size of the apparatus"
    with writing(path):
        save_picture(sheet(title, subtitle, panels, _WIDTH), path)


def _panel(test: SizesOfTest, target: Target) -> Image.Image:
    lines = []
    largest = max(test.goal.particles, *(row.particles for row in test.rows))
    for row in test.rows:
        if (found := row.responses.get(target.name)) is not None:
            error = found.standard_error or 0.0
            lines += _bar(row.particles, found.mean, error, largest, _BLUE)
    predicted = test.prediction(target)
    if predicted is not None:
        lines += _bar(test.goal.particles, predicted.value, predicted.half_width, largest, FLANK)
        lines.insert(0, _trend(test, target))
    label = f"{test.name}: {target.name.removeprefix(f'{test.name}.')}, {target.unit or '1'}"
    return line_panel(lines, "cube root of the number of particles", label, _SIZE, from_zero=False)


def _bar(particles: int, value: float, half: float, largest: int, colour: str) -> list[PlottedLine]:
    """Return an interval with its ends and a line at its value."""
    place, reach = math.cbrt(particles), _END * math.cbrt(largest)
    ends = [
        PlottedLine([place - reach, place + reach], [y, y], "", colour, 2)
        for y in (value - half, value + half)
    ]
    middle = PlottedLine([place - reach, place + reach], [value, value], "", colour, 4)
    return [*ends, middle, PlottedLine([place, place], [value - half, value + half], "", colour, 2)]


def _trend(test: SizesOfTest, target: Target) -> PlottedLine:
    sizes = [*(row.times for row in test.rows), test.goal.times]
    times = np.geomspace(min(sizes), max(sizes), _POINTS)
    count = test.rows[0].particles / test.rows[0].times
    found = [test.at(float(t)).prediction(target) for t in times]
    values = [math.nan if one is None else one.value for one in found]
    return PlottedLine(np.cbrt(count * times), values, "", FLANK, 2)
