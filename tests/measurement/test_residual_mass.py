"""Mass that stays in a vessel, and its error."""

from __future__ import annotations

import numpy as np
import pytest

from grainfit.measurement.particles import Particles
from grainfit.measurement.residual_mass import residual_mass


def ring(count: int, masses: np.ndarray) -> Particles:
    """Particles all around the axis, half of them below the outlet."""
    angle = 2 * np.pi * (np.arange(count) + 0.5) / count
    above = np.column_stack((np.cos(angle), np.sin(angle), np.full(count, 0.1)))
    places = np.concatenate((above, above * [1, 1, -1]))
    return Particles(places, np.full(2 * count, 0.01), np.concatenate((masses, masses)))


def test_mass_below_the_outlet_does_not_count() -> None:
    found = residual_mass(ring(80, np.full(80, 0.5)), None, 0.5)

    # Even all around: one particle is the least error.
    assert (found.value, found.standard_error) == (pytest.approx(40.0), 0.5)


def test_the_error_is_the_scatter_between_sectors() -> None:
    masses = np.repeat([1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0], 10)
    for depth in (None, 3.0):
        found = residual_mass(ring(80, masses), depth, 1.0)
        assert found.value == pytest.approx(120.0)
    assert residual_mass(ring(80, masses), None, 1.0).standard_error == pytest.approx(
        np.std([10.0, 20.0] * 4, ddof=1) * 8**0.5
    )


def test_an_empty_vessel_has_no_mass_within_a_particle() -> None:
    found = residual_mass(ring(8, np.ones(8)).select(np.arange(8, 16)), None, 1.0)

    assert (found.value, found.standard_error) == (0.0, 1.0)
