"""Line charts: lines, axes, ticks, legend."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from grainfit.measurement.line_panel import PlottedLine, line_panel

RED, BLUE = "#ff0000", "#0000ff"
SIZE = (600, 400)


def places(panel: Image.Image, colour: str) -> np.ndarray:
    """Rows and columns of the pixels of a colour."""
    wanted = [int(colour[at : at + 2], 16) for at in (1, 3, 5)]
    return np.argwhere((np.asarray(panel) == wanted).all(axis=2))


def drawn(*lines: PlottedLine, **options: object) -> Image.Image:
    return line_panel(lines, "time, s", "mass, kg", SIZE, **options)


def test_lines_are_drawn_to_one_scale_from_lower_left_to_upper_right() -> None:
    panel = drawn(PlottedLine([0, 2], [0, 4], colour=RED), PlottedLine([1, 2], [2, 2], colour=BLUE))
    rising, level = places(panel, RED), places(panel, BLUE)

    assert panel.size == SIZE
    assert rising[np.argmin(rising[:, 1]), 0] > rising[np.argmax(rising[:, 1]), 0]
    # The level line begins where the rising one has its height, and they end in one column.
    before = rising[np.abs(rising[:, 1] - level[:, 1].min() + 5) < 5]
    assert abs(before[:, 0].mean() - level[:, 0].mean()) < 6
    assert abs(rising[:, 1].max() - level[:, 1].max()) <= 2


def test_a_label_is_written_in_the_colour_of_its_line() -> None:
    line = PlottedLine([0, 1], [1, 2], colour=RED)
    plain, labelled = drawn(line), drawn(PlottedLine([0, 1], [1, 2], "fitted: 1 kg/s", RED))
    assert len(places(labelled, RED)) > len(places(plain, RED))


def test_an_axis_without_zero_shows_small_changes() -> None:
    line = PlottedLine([0, 1, 2], [30, 31, 30], colour=RED)
    near, far = (places(drawn(line, from_zero=zero), RED) for zero in (False, True))
    assert np.ptp(near[:, 0]) > 10 * np.ptp(far[:, 0])


def test_marks_are_lines_across_the_plot() -> None:
    line = PlottedLine([0, 1], [0, 1], colour=RED)
    changed = np.asarray(drawn(line)) != np.asarray(drawn(line, marks=[0.5]))
    rows, columns = np.nonzero(changed.any(axis=2))
    assert np.ptp(rows) > SIZE[1] / 2
    assert np.ptp(columns) < 5


@pytest.mark.parametrize("value", [0.0, 5.0, -3.0, 1e-9, 1e9])
def test_a_level_line_is_drawn(value: float) -> None:
    for zero in (True, False):
        line = PlottedLine([0, 1], [value, value], colour=RED)
        assert len(places(drawn(line, from_zero=zero), RED)) > 100
    assert len(places(drawn(PlottedLine([0, 0], [0, value], colour=RED)), RED))
