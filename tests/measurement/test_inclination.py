"""Inclination of piles and wedges in a slice of periodic depth, cut from random packings."""

from __future__ import annotations

import math

import numpy as np
import pytest
from synthetic_heaps import DIAMETER, packing, particles_of

from grainfit.errors import NotMeasurableError
from grainfit.measurement import messages
from grainfit.measurement.height_map import HeightMap, height_map
from grainfit.measurement.inclination import inclination_of_pile, inclination_of_wedges
from grainfit.measurement.particles import Particles
from grainfit.messages import Message

#: The random packing repeats after this many diameters.
DEPTH = 12.0


def cut(seed: int, half: float, surface: object) -> Particles:
    """Spheres of a random packing that lie below a surface over x, in diameters."""
    assert callable(surface)
    centres, radii = packing(1.5 * half + DEPTH, 14.0, seed)
    # Turned packings do not repeat along y: the edges of the slice are free here.
    slice_ = (np.abs(centres[:, 0]) < half) & (np.abs(centres[:, 1]) < DEPTH / 2)
    centres, radii = centres[slice_], radii[slice_]
    inside = (centres[:, 2] < surface(centres[:, 0])) & (centres[:, 2] > radii)
    return particles_of(centres[inside] + [0.0, DEPTH / 2, 0.0], radii[inside])


def surface_of(particles: Particles, half: float) -> HeightMap:
    limit = half * DIAMETER
    return height_map(particles, -limit, limit, DEPTH * DIAMETER, 0.0)


def pile(angle: float, seed: int) -> HeightMap:
    slope = math.tan(math.radians(angle))
    return surface_of(cut(seed, 26.0, lambda x: 9.0 - slope * np.abs(x)), 26.0)


def wedges(angle: float, seed: int) -> HeightMap:
    slope = math.tan(math.radians(angle))
    return surface_of(cut(seed, 12.0, lambda x: slope * (np.abs(x) - 2.5)), 12.0)


@pytest.mark.parametrize("angle", [20.0, 27.0, 35.0])
def test_pile_has_the_inclination_it_was_cut_at(angle: float) -> None:
    found = [inclination_of_pile(pile(angle, seed), DIAMETER) for seed in range(5)]

    assert np.mean([f.value for f in found]) == pytest.approx(angle, abs=0.7)
    assert all(0 < f.standard_error < 2 for f in found)
    left, right = found[0].flanks
    assert left.start[0] < left.end[0] < 0 < right.end[0] < right.start[0]
    assert min(left.end[1], right.end[1]) > max(left.start[1], right.start[1])


@pytest.mark.parametrize("angle", [22.0, 30.0, 40.0])
def test_wedges_have_the_inclination_they_were_cut_at(angle: float) -> None:
    slot = 5 * DIAMETER
    found = [inclination_of_wedges(wedges(angle, seed), slot, DIAMETER) for seed in range(5)]

    assert np.mean([f.value for f in found]) == pytest.approx(angle, abs=1.0)
    left, right = found[0].flanks
    assert left.end[0] < left.start[0] < 0 < right.start[0] < right.end[0]


def test_standard_error_covers_the_scatter_between_piles() -> None:
    found = [inclination_of_pile(pile(27.0, seed), DIAMETER) for seed in range(16)]
    scatter = np.std([f.value for f in found], ddof=1)
    stated = math.sqrt(np.mean([f.standard_error**2 for f in found]))

    assert 0.6 < stated / scatter < 2.5


def test_height_map_shows_the_top_of_spheres_across_the_period() -> None:
    ball = particles_of(np.array([[0.0, 0.1, 3.0]]), np.array([0.5]))
    heights = height_map(ball, -0.02, 0.02, 0.04, 0.005)

    assert heights.heights.max() == pytest.approx(0.03, abs=2e-4)
    # Half of it is seen at the other end of the depth.
    assert heights.heights[-1].max() > 0.02
    assert (heights.heights > 0).mean() == pytest.approx(math.pi / 4 / 16, rel=0.1)


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        (lambda x: 0.01 + 0 * x, messages.LOW_PILE),
        (lambda x: np.where(np.abs(x) < 0.05, 0.08, 0.0), messages.STEPS),
    ],
)
def test_surface_without_flanks_is_not_measurable(heights: object, message: Message) -> None:
    assert callable(heights)
    x = np.linspace(-0.2, 0.2, 321)
    surface = HeightMap(np.tile(heights(x), (80, 1)), x, 0.1)

    with pytest.raises(NotMeasurableError, match=message.pattern):
        inclination_of_pile(surface, DIAMETER)
