from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from synthetic_heaps import DIAMETER, heap

from grainfit.measurement.angle_of_repose import AngleOfRepose, angle_of_repose
from grainfit.measurement.heap_picture import draw_heap
from grainfit.measurement.particles import Particles

PLATE = 20 * DIAMETER
FLANK = np.array([0xD5, 0x5E, 0x00])
HEAP = np.array([0xB4, 0xBF, 0xCA])


def draw(path: Path, particles: Particles, measured: AngleOfRepose | str) -> np.ndarray:
    draw_heap(path, particles, PLATE, DIAMETER, measured)
    with Image.open(path) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGB")).astype(int)


def share(picture: np.ndarray, colour: np.ndarray) -> float:
    return float((picture == colour).all(axis=2).mean())


def test_picture_shows_the_heap_and_the_fitted_flanks(tmp_path: Path) -> None:
    particles = heap(25, 7, 1)
    measured = angle_of_repose(particles, DIAMETER, PLATE)
    picture = draw(tmp_path / "heap.png", particles, measured)
    assert share(picture, HEAP) > 0.1
    assert share(picture, FLANK) > 0.002


def test_one_view_fills_one_panel(tmp_path: Path) -> None:
    particles = heap(25, 7, 1)
    four = draw(tmp_path / "4.png", particles, angle_of_repose(particles, DIAMETER, PLATE))
    one = draw(tmp_path / "1.png", particles, angle_of_repose(particles, DIAMETER, PLATE, views=1))
    assert one.shape[1] < four.shape[1] / 1.8


def test_picture_of_what_is_not_measurable_has_no_flanks(tmp_path: Path) -> None:
    picture = draw(tmp_path / "heap.png", heap(25, 7, 1), "angle of repose: there is no heap")
    assert share(picture, HEAP) > 0.1
    assert share(picture, FLANK) == 0


def test_long_reason_is_wrapped_and_not_cut(tmp_path: Path) -> None:
    particles = heap(25, 7, 1)
    short = draw(tmp_path / "short.png", particles, "too flat")
    long = draw(tmp_path / "long.png", particles, "the heap is much too flat, " * 20)
    assert long.shape[0] > short.shape[0]
    assert long.shape[1] == short.shape[1]
    assert (long[:, -10:] == 255).all()


def test_empty_plate_is_drawn_too(tmp_path: Path) -> None:
    nothing = heap(25, 7, 1).select(np.zeros(len(heap(25, 7, 1)), dtype=bool))
    picture = draw(tmp_path / "heap.png", nothing, "none of 1500 particles is left on the plate")
    assert (picture < 128).any()
    assert share(picture, HEAP) < 0.001
