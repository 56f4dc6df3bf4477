"""The random column: no contacts, all inside, right numbers, reproducible, few draws."""

import math

import numpy as np
import pytest
from scipy.spatial.distance import pdist, squareform

from grainfit.errors import InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes import messages
from grainfit.scenes.packing import (
    PeriodicRectangle,
    Rectangle,
    Round,
    column_height,
    particle_numbers,
    random_column,
    random_in_tube,
)

MONOSIZE = ParticleSizes((0.010,))
WIDE = ParticleSizes((0.020, 0.005, 0.010), (0.3, 0.2, 0.5))


def gaps(column, diameters):
    """Surface distance of every pair."""
    distance = squareform(pdist(column.positions))
    surface = distance - (diameters[:, None] + diameters) / 2
    return surface[np.triu_indices(len(diameters), 1)]


@pytest.mark.parametrize(
    ("sizes", "count", "radius"),
    [(MONOSIZE, 1500, 0.06), (WIDE, 1200, 0.06), (MONOSIZE, 60, 0.02), (MONOSIZE, 1, 0.02)],
)
def test_all_particles_are_inside_and_none_touches_another(sizes, count, radius):
    column = random_column(sizes, count, Round(radius), seed=3)
    diameters = np.array(sizes.diameters)[column.size_indices]
    assert len(column.positions) == count
    assert gaps(column, diameters).min(initial=1.0) > 0
    x, y, z = column.positions.T
    assert (np.hypot(x, y) + diameters / 2).max() < radius
    assert (z - diameters / 2).min() > 0
    assert (z + diameters / 2).max() < column.height


def test_numbers_follow_the_mass_fractions():
    numbers = particle_numbers(WIDE, 1000)
    assert sum(numbers) == 1000
    masses = np.array(numbers) * np.array(WIDE.diameters) ** 3
    # One particle of 20 mm is 0.7 % of the mass.
    assert masses / masses.sum() == pytest.approx(WIDE.mass_fractions, abs=0.01)
    column = random_column(WIDE, 1000, Round(0.06), seed=1)
    assert np.bincount(column.size_indices).tolist() == numbers


def test_sizes_are_mixed_over_the_height():
    sizes = ParticleSizes((0.012, 0.008), (0.5, 0.5))
    column = random_column(sizes, 1000, Round(0.06), seed=1)
    large = column.positions[column.size_indices == 0, 2]
    # Uniform over the height: standard error of the mean is height / sqrt(12 n).
    error = column.height / np.sqrt(12 * len(large))
    assert abs(large.mean() - column.height / 2) < 4 * error


def test_places_are_uniform_over_the_cross_section():
    column = random_column(MONOSIZE, 1500, Round(0.06), seed=1)
    inside = np.hypot(*column.positions.T[:2]) < (0.06 - 0.005) / np.sqrt(2)
    assert inside.mean() == pytest.approx(0.5, abs=4 * np.sqrt(0.25 / 1500))


def test_the_seed_decides_the_column():
    first, again, other = (random_column(WIDE, 300, Round(0.06), seed) for seed in (7, 7, 8))
    assert np.array_equal(first.positions, again.positions)
    assert np.array_equal(first.size_indices, again.size_indices)
    assert not np.array_equal(first.positions, other.positions)


def test_a_column_of_1500_takes_few_draws(monkeypatch):
    draws = []
    places = Round.places

    def counted(self, random, count, wall):
        draws.append(count)
        return places(self, random, count, wall)

    monkeypatch.setattr(Round, "places", counted)
    random_column(MONOSIZE, 1500, Round(0.06), seed=1)
    # All that are missing are drawn at a time, not one after another: 44 times, 12 each.
    assert len(draws) < 60
    assert sum(draws) < 15 * 1500


def test_height_is_that_of_a_loose_filling():
    solid = 1500 * np.pi / 6 * 0.010**3
    height = column_height(MONOSIZE, 1500, Round(0.06))
    assert 0.15 < solid / (np.pi * 0.06**2 * height) < 0.30


NARROW = messages.NARROW_CONTAINER
NOT_POSSIBLE = messages.TOO_MANY_PARTICLES
NO_LENGTH = messages.NO_LENGTH
NO_WHOLE = messages.NO_WHOLE_NUMBER
SHORT = messages.SHORT_PERIOD


@pytest.mark.parametrize(
    ("make", "key", "message"),
    [
        (lambda: random_column(MONOSIZE, 9, Round(0.06), -1), "seed", messages.NEGATIVE_SEED),
        (lambda: random_in_tube(MONOSIZE, 9, 0.05, 0.06, -1), "seed", messages.NEGATIVE_SEED),
        (lambda: random_column(MONOSIZE, 9, Round(0.06), 1.5), "seed", NO_WHOLE),
        (lambda: random_column(MONOSIZE, 9.5, Round(0.06), 1), "count", NO_WHOLE),
        (lambda: random_in_tube(MONOSIZE, "9", 0.05, 0.06, 1), "count", NO_WHOLE),
        (lambda: random_in_tube(MONOSIZE, 900, 0.05, 0.06, 1), "particle_count", messages.NO_ROOM),
        (lambda: random_column(MONOSIZE, 0, Round(0.06), 1), "particles", NOT_POSSIBLE),
        (lambda: random_column(MONOSIZE, -5, Round(0.06), 1), "particles", NOT_POSSIBLE),
        (lambda: random_column(MONOSIZE, 1_000_001, Round(0.06), 1), "particles", NOT_POSSIBLE),
        (lambda: random_column(MONOSIZE, 9, Round(0.004), 1), "particles", NARROW),
        (lambda: random_column(MONOSIZE, 9, Rectangle(0.009, 0.1), 1), "particles", NARROW),
        (lambda: random_column(MONOSIZE, 9, Rectangle(0.1, 0.015), 1), "particles", SHORT),
        (lambda: random_column(MONOSIZE, 9, PeriodicRectangle(0.015, 1), 1), "particles", SHORT),
        (lambda: random_in_tube(MONOSIZE, 9, 0.05, 0.015, 1), "particles", SHORT),
        (lambda: random_in_tube(MONOSIZE, 9, math.nan, 0.06, 1), "radius", NO_LENGTH),
        (lambda: Round(-0.1), "radius", NO_LENGTH),
        (lambda: Rectangle(0.1, 0.0), "depth", NO_LENGTH),
        (lambda: PeriodicRectangle(float("nan"), 0.1), "length", NO_LENGTH),
    ],
)
def test_what_cannot_be_packed_is_refused(make, key, message):
    with pytest.raises(InputError, match=f"{key}: {message.pattern}"):
        make()


def test_a_column_between_two_walls_is_periodic_in_depth():
    column = random_column(WIDE, 800, Rectangle(width=0.12, depth=0.06), seed=3)
    diameters = np.array(WIDE.diameters)[column.size_indices]
    x, y, z = column.positions.T
    assert (np.abs(x) + diameters / 2).max() < 0.06
    assert (z - diameters / 2).min() > 0
    assert y.min() >= 0
    assert y.max() < 0.06
    apart = np.abs(y[:, None] - y)
    apart = np.minimum(apart, 0.06 - apart)
    distance = np.sqrt((x[:, None] - x) ** 2 + apart**2 + (z[:, None] - z) ** 2)
    surface = distance - (diameters[:, None] + diameters) / 2
    assert surface[np.triu_indices(len(diameters), 1)].min() > 0
    # Some touch the images of others only: without periods they would overlap them.
    assert (y < diameters / 2).any()


@pytest.mark.parametrize(("sizes", "count"), [(MONOSIZE, 534), (MONOSIZE, 800), (WIDE, 300)])
def test_particles_in_a_tube_are_inside_and_touch_nothing(sizes, count):
    radius, length = 0.075, 0.06
    column = random_in_tube(sizes, count, radius, length, seed=2)
    diameters = np.array(sizes.diameters)[column.size_indices]

    assert np.bincount(column.size_indices).tolist() == particle_numbers(sizes, count)
    assert column.height == radius
    x, y, z = column.positions.T
    assert ((x >= 0) & (x < length)).all()
    assert (np.hypot(y, z) + diameters / 2 < radius).all()
    for shift in (0, length):
        other = column.positions + np.array([shift, 0.0, 0.0])
        distance = np.linalg.norm(column.positions[:, None] - other, axis=2)
        distance[distance < 1e-12] = np.inf
        assert (distance > (diameters[:, None] + diameters) / 2).all()


def test_particles_in_a_tube_follow_from_their_seed():
    first, again, other = (
        random_in_tube(MONOSIZE, 100, 0.05, 0.06, seed).positions for seed in (1, 1, 2)
    )
    assert (first == again).all()
    assert not np.allclose(first, other)
