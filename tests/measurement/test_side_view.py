"""Pictures of particles from the side."""

from __future__ import annotations

import numpy as np
from synthetic_heaps import heap

from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.side_view import SideView

FLANK = np.array([0xD5, 0x5E, 0x00])
WALL = np.array([0x61, 0x6E, 0x7C])


def share(image: object, colour: np.ndarray) -> float:
    pixels = np.asarray(image.convert("RGB")).astype(int)  # type: ignore[attr-defined]
    return float((pixels == colour).all(axis=2).mean())


def test_particles_walls_and_fitted_lines_are_seen() -> None:
    flank = Flank(25.0, (0.15, 0.0), (0.0, 0.07))
    floor = (-1.0, -0.01, 1.0, 0.0)
    view = SideView(heap(25, 7, 1), (-0.2, -0.01, 0.2, 0.1), [floor], [flank])
    panel = view.panel(600)
    pixels = np.asarray(panel).astype(int)

    assert panel.size == (600, 165)
    assert share(panel, FLANK) > 0.003
    assert share(panel, WALL) > 0.05
    # The heap is about a quarter of the view, and white is around it.
    assert 0.15 < ((pixels < 250).any(axis=2)).mean() < 0.6
    assert (pixels[5, 5] == 255).all()


def test_view_without_particles_is_empty() -> None:
    nothing = heap(25, 7, 1).select(np.zeros(len(heap(25, 7, 1)), dtype=bool))
    panel = SideView(nothing, (-0.1, 0.0, 0.1, 0.1), []).panel(200)

    assert (np.asarray(panel) == 255).all()
