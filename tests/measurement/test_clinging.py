"""Particles that hang on a lifted cylinder are no part of a heap."""

from __future__ import annotations

import numpy as np

from grainfit.measurement.clinging import clinging
from grainfit.measurement.particles import Particles

RADIUS, CYLINDER = 0.005, 0.06


def beads(*centres: tuple[float, float, float]) -> Particles:
    """Beads at places in diameters."""
    positions = 2 * RADIUS * np.array(centres, dtype=float).reshape(-1, 3)
    return Particles(positions, np.full(len(positions), RADIUS), np.full(len(positions), 0.001))


def hanging(*centres: tuple[float, float, float]) -> list[int]:
    return np.flatnonzero(clinging(beads(*centres), CYLINDER)).tolist()


def test_a_chain_that_reaches_the_cylinder_and_not_the_plate_hangs() -> None:
    chain = ((5.5, 0, 12), (4.5, 0, 12), (3.5, 0, 12))
    assert hanging((0, 0, 0.5), (0, 0, 1.5), *chain) == [2, 3, 4]
    # Outside of the cylinder too.
    assert hanging((0, 0, 0.5), (6.5, 0, 12)) == [1]


def test_what_stands_on_the_plate_is_a_heap_however_high() -> None:
    column = [(5.5, 0, 0.5 + n) for n in range(15)]
    assert hanging(*column) == []
    # A gap in it: the upper part hangs.
    assert hanging(*column[:7], *column[8:]) == list(range(7, 14))


def test_what_touches_neither_is_on_its_way() -> None:
    assert hanging((0, 0, 0.5), (2, 0, 12)) == []
    assert hanging() == []
