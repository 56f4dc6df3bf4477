"""Edges of heaps between the pixels of a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.photographs.upright import Upright, mirrored
from tests.photographs.drawn_pictures import usable
from tests.photographs.rendered_pictures import save, true_angle

SLOPE = 0.07


def sloping(parts: int) -> Upright:
    """Return what is below a line that rises slowly from left to right, not turned."""
    columns, rows = np.arange(300), np.arange(60)
    field = rows[:, None] - (40.3 - SLOPE * columns[None, :])
    return Upright(field.astype(np.float32), np.eye(3), (300, 60), parts)


@pytest.mark.parametrize("stretch", [1.0, 1.37])
def test_an_edge_runs_between_pixels(stretch: float) -> None:
    silhouette = sloping(4).silhouette(stretch, 60.0, 12.0)

    # Lengths begin at edges of pixels, places at their middles.
    line = 60.0 + stretch * (SLOPE * (silhouette.columns + 12.0 - 0.5) - 40.3 - 0.5)
    within = slice(4, -4)
    assert np.abs(silhouette.outline() - line)[within].max() < 0.2
    assert np.abs(mirrored(silhouette).outline()[::-1] - line)[within].max() < 0.2


def test_places_go_there_and_back() -> None:
    upright = sloping(4)
    there = np.array([upright.place((30.0, 11.0))])

    assert there[0] == pytest.approx([30.5, 11.5])
    assert upright.back(there)[0] == pytest.approx([30.0, 11.0])


def test_a_flat_heap_has_no_steps_of_pixels(tmp_path: Path) -> None:
    # 67 pixels high: with an edge that jumped from pixel to pixel the angle was 0.7 degrees wrong.
    shot, path = usable(20061), tmp_path / "heap.jpg"
    save(shot, path, exif=True)

    assert gf.photo(path).heaps[0][0].angle == pytest.approx(true_angle(shot), abs=0.25)
