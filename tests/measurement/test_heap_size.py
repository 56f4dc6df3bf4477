"""Base radius and height of heaps whose shape is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from synthetic_heaps import DIAMETER, heap, particles_of

from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement import messages
from grainfit.measurement.angle_of_repose import heap_silhouettes, on_plate
from grainfit.measurement.heap_size import base_radius, heap_height, heap_profile, reaches_edge
from grainfit.measurement.particles import Particles
from grainfit.measurement.silhouette import Silhouette

WIDE_PLATE = 60 * DIAMETER
ANGLES = (15.0, 22.0, 30.0, 40.0)


def radius_of(particles: Particles, ground: float = DIAMETER, views: int = 12) -> Response:
    return base_radius(heap_silhouettes(particles, WIDE_PLATE, views), ground, DIAMETER)


def height_of(particles: Particles, views: int = 12) -> Response:
    return heap_height(heap_silhouettes(particles, WIDE_PLATE, views), DIAMETER)


def with_spheres(particles: Particles, centres: list[list[float]]) -> Particles:
    more = particles_of(np.array(centres), np.full(len(centres), 0.5))
    return Particles(
        np.concatenate([particles.positions, more.positions]),
        np.concatenate([particles.radii, more.radii]),
        np.concatenate([particles.masses, more.masses]),
    )


def half_width(angle: float, height: float, above: float) -> float:
    """Of a cone, at a height above its base."""
    return (height - above) / math.tan(math.radians(angle)) * DIAMETER


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("ground", [1.0, 2.0])
def test_base_radius_of_a_cone_is_half_its_width_at_the_ground(angle: float, ground: float) -> None:
    """The outline lies up to half a particle diameter below the cone that envelops the spheres."""
    found = radius_of(heap(angle, 8.0, 1), ground * DIAMETER)
    highest = half_width(angle, 8.0, ground)

    assert half_width(angle, 8.0, ground + 0.5) - DIAMETER < found.value < highest


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("plateau", [0.0, 5.0], ids=["cone", "truncated"])
def test_height_is_that_of_the_cone(angle: float, plateau: float) -> None:
    found = height_of(heap(angle, 8.0, 1, plateau))

    # No sphere fills the tip of a cone, the less the steeper it is.
    blunt = 0.8 if plateau else 1.5
    assert 8.0 - blunt < found.value / DIAMETER < 8.0


@pytest.mark.parametrize("angle", ANGLES)
def test_profile_of_a_cone_falls_with_its_inclination(angle: float) -> None:
    """The outline lies up to half a particle diameter below the cone that envelops the spheres."""
    silhouettes = heap_silhouettes(heap(angle, 8.0, 1), WIDE_PLATE, 12)

    profile = heap_profile(silhouettes, DIAMETER, WIDE_PLATE)

    radii = np.array(profile.coordinates)
    cone = 8.0 * DIAMETER - radii * math.tan(math.radians(angle))
    flank = (cone > 1.5 * DIAMETER) & (cone < 5 * DIAMETER)
    below = cone[flank] - np.array(profile.values)[flank]
    assert flank.sum() > 7
    assert below.min() > -0.1 * DIAMETER
    assert below.max() < 0.6 * DIAMETER
    assert profile.values[-1] == 0
    assert profile.stays


def test_profile_is_zero_beyond_the_edge_of_the_plate() -> None:
    plate = 6 * DIAMETER
    silhouettes = heap_silhouettes(heap(22.0, 8.0, 1), plate, 12)

    profile = heap_profile(silhouettes, DIAMETER, plate)

    assert profile.coordinates[-1] == pytest.approx(plate + DIAMETER / 2)
    assert profile.values[-2] > 3 * DIAMETER
    assert profile.values[-1] == 0


@pytest.fixture(scope="module")
def small_heaps() -> list[tuple[Response, Response]]:
    heaps = [heap(22.0, 6.0, seed) for seed in range(16)]
    return [(radius_of(one), height_of(one)) for one in heaps]


@pytest.mark.parametrize("response", [0, 1], ids=["base_radius", "heap_height"])
def test_standard_error_is_the_scatter_from_heap_to_heap(
    small_heaps: list[tuple[Response, Response]], response: int
) -> None:
    found = [responses[response] for responses in small_heaps]
    scatter = np.std([one.value for one in found], ddof=1)
    stated = math.sqrt(np.mean([one.standard_error**2 for one in found]))

    # 95 % of all scatters of 16 normal values are 0.65 to 1.35 times the truth.
    assert 1 / 1.35 < stated / scatter < 1 / 0.65


def test_particles_beside_the_heap_and_on_its_top_count_little() -> None:
    one = heap(25.0, 7.0, 0)
    scattered = with_spheres(one, [[20, 0, 0.5], [0, 18, 0.5], [19, 1.5, 0.5], [-17, 3, 0.5]])
    top = float((one.positions[:, 2] + one.radii).max()) / DIAMETER
    perched = with_spheres(one, [[0.0, 0.0, top + 0.5]])

    assert radius_of(scattered).value == pytest.approx(radius_of(one).value, abs=0.1 * DIAMETER)
    assert height_of(perched).value - height_of(one).value < 0.6 * DIAMETER


def test_length_unit_does_not_matter() -> None:
    one = heap(25.0, 6.0, 3)
    small = Particles(one.positions / 8, one.radii / 8, one.masses)
    silhouettes = heap_silhouettes(small, WIDE_PLATE / 8, 12)
    radius = base_radius(silhouettes, DIAMETER / 8, DIAMETER / 8)

    assert 8 * radius.value == pytest.approx(radius_of(one).value)
    assert 8 * radius.standard_error == pytest.approx(radius_of(one).standard_error)
    height = heap_height(silhouettes, DIAMETER / 8)
    assert 8 * height.value == pytest.approx(height_of(one).value)


def test_more_views_of_the_same_heap_do_not_shrink_the_standard_error() -> None:
    one = heap(25.0, 6.0, 1)

    assert radius_of(one, views=48).standard_error == pytest.approx(
        radius_of(one, views=12).standard_error, rel=0.2
    )


def photograph(left: float, right: float, height: float = 0.1) -> Silhouette:
    """A triangle with feet at these distances from the axis, 0.5 mm a pixel."""
    size, width, rows = 0.0005, 1200, 220
    x = (np.arange(width) + 0.5) * size - width * size / 2
    outline = height * np.minimum(1 + x / left, 1 - x / right)
    above = (np.arange(rows)[::-1] + 0.5) * size
    return Silhouette(above[:, None] < outline, size, left=-width * size / 2)


def test_photographs_are_measured_like_rendered_silhouettes() -> None:
    radius = base_radius([photograph(0.15, 0.17)], ground=0.001, diameter=0.001)
    height = heap_height([photograph(0.15, 0.17)], diameter=0.001)

    assert radius.value == pytest.approx(0.16 * 0.99, abs=0.001)
    assert radius.standard_error == pytest.approx(0.01 * 0.99, abs=0.001)
    assert height.value == pytest.approx(0.1, abs=0.001)


def test_a_heap_that_leaves_the_picture_is_as_wide_as_the_picture() -> None:
    whole = photograph(0.2, 0.2)
    cut = Silhouette(whole.image[:, 400:-400], whole.pixel_size, left=-0.1)

    assert base_radius([cut], 0.001, 0.001).value == pytest.approx(0.1)


@pytest.mark.parametrize(("beyond", "is_decided"), [(-3.0, True), (0.9, True), (1.6, False)])
def test_a_heap_whose_foot_is_at_the_edge_of_the_plate_reaches_it(
    beyond: float, is_decided: bool
) -> None:
    one = heap(30.0, 8.0, 1)
    free = base_radius(heap_silhouettes(one, WIDE_PLATE, 12), DIAMETER, DIAMETER)
    plate = free.value + beyond * DIAMETER
    silhouettes = heap_silhouettes(on_plate(one, plate), plate, 12)

    assert reaches_edge(silhouettes, DIAMETER, DIAMETER, plate) == is_decided


def test_a_heap_that_reaches_the_edge_on_one_side_only_keeps_its_size() -> None:
    one = heap(30.0, 8.0, 1)
    silhouettes = heap_silhouettes(one, WIDE_PLATE, 12)
    plate = base_radius(silhouettes, DIAMETER, DIAMETER).value + 2.5 * DIAMETER
    tongue = with_spheres(
        one, [[plate / DIAMETER - x, 0, z] for x in (1, 2, 3) for z in (0.5, 1.4)]
    )

    for particles, reaches in ((one, False), (tongue, False)):
        found = heap_silhouettes(on_plate(particles, plate), plate, 12)
        assert reaches_edge(found, DIAMETER, DIAMETER, plate) == reaches


def test_nothing_above_the_ground_reaches_no_edge() -> None:
    assert not reaches_edge([], DIAMETER, DIAMETER, WIDE_PLATE)


def test_blank_photographs_are_not_measurable() -> None:
    blank = Silhouette(np.zeros((100, 200), dtype=bool), 0.001, left=-0.1)
    for silhouettes in ([], [blank]):
        with pytest.raises(NotMeasurableError, match=messages.NO_BASE.pattern):
            base_radius(silhouettes, 0.0, 0.01)
        with pytest.raises(NotMeasurableError, match=messages.BLANK(quantity="heap height")):
            heap_height(silhouettes, 0.01)
        with pytest.raises(NotMeasurableError, match=messages.BLANK(quantity="heap profile")):
            heap_profile(silhouettes, 0.01, 0.1)
