from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_heaps import DIAMETER, Kind, heap, packing, particles_of

from grainfit.errors import NotMeasurableError
from grainfit.measurement import messages
from grainfit.measurement.angle_of_repose import (
    AngleOfRepose,
    angle_of_repose,
    angle_of_repose_in,
    outline_depth,
)
from grainfit.measurement.particles import Particles
from grainfit.measurement.silhouette import Silhouette
from grainfit.messages import Message

WIDE_PLATE = 60 * DIAMETER
ANGLES = (10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0)


def measure(particles: Particles) -> float:
    return angle_of_repose(particles, DIAMETER, WIDE_PLATE).value


def spheres(centres: object) -> Particles:
    points = np.asarray(centres, dtype=float).reshape(-1, 3)
    return particles_of(points, np.full(len(points), 0.5))


def moved(particles: Particles, shift: tuple[float, float, float]) -> Particles:
    positions = particles.positions + np.array(shift) * DIAMETER
    return Particles(positions, particles.radii, particles.masses)


def joined(*parts: Particles) -> Particles:
    return Particles(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.radii for part in parts]),
        np.concatenate([part.masses for part in parts]),
    )


def height_of(angle: float) -> float:
    """Height of a heap of 2,000 to 8,000 particles: fewer leave more than 0.2 degrees open."""
    return max(7.0, 20.0 * math.tan(math.radians(angle)))


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("plateau", [0.0, 5.0], ids=["cone", "truncated"])
def test_known_angle_is_measured_within_half_a_degree(angle: float, plateau: float) -> None:
    height = height_of(angle) * (0.8 if plateau else 1.0)
    assert measure(heap(angle, height, 1, plateau)) == pytest.approx(angle, abs=0.5)


@pytest.mark.parametrize("angle", [12.0, 22.0, 32.0, 42.0])
@pytest.mark.parametrize("kind", ["polydisperse", "lattice"])
def test_other_packings_give_the_same_angle(angle: float, kind: Kind) -> None:
    assert measure(heap(angle, height_of(angle), 2, kind=kind)) == pytest.approx(angle, abs=0.5)


@pytest.fixture(scope="module")
def small_heaps() -> list[AngleOfRepose]:
    return [angle_of_repose(heap(22.0, 6.0, s), DIAMETER, WIDE_PLATE) for s in range(16)]


def test_small_heaps_are_right_on_average(small_heaps: list[AngleOfRepose]) -> None:
    """Without the depth of the outline they are measured 0.5 degrees too flat."""
    angles = [measured.value for measured in small_heaps]
    error = np.std(angles, ddof=1) / math.sqrt(len(angles))
    assert error < 0.12
    assert np.mean(angles) == pytest.approx(22.0, abs=0.25)


def test_standard_error_is_the_scatter_from_heap_to_heap(small_heaps: list[AngleOfRepose]) -> None:
    scatter = np.std([measured.value for measured in small_heaps], ddof=1)
    stated = math.sqrt(np.mean([measured.standard_error**2 for measured in small_heaps]))
    # 95 % of all scatters of 16 normal values are 0.65 to 1.35 times the truth.
    assert 1 / 1.35 < stated / scatter < 1 / 0.65


def test_more_views_of_the_same_heap_do_not_shrink_its_standard_error() -> None:
    one = heap(25.0, 6.0, 1)
    few = angle_of_repose(one, DIAMETER, WIDE_PLATE, views=12)
    many = angle_of_repose(one, DIAMETER, WIDE_PLATE, views=48)
    assert many.standard_error == pytest.approx(few.standard_error, rel=0.2)
    assert len(many.views) == 48


def test_angle_does_not_depend_on_length_unit_or_order_of_particles() -> None:
    one = heap(25.0, 6.0, 3)
    order = np.random.default_rng(0).permutation(len(one))
    small = Particles(one.positions[order] / 8, one.radii[order] / 8, one.masses[order])
    measured = angle_of_repose(small, DIAMETER / 8, WIDE_PLATE / 8)
    assert measured.value == pytest.approx(measure(one), abs=1e-9)


def test_particles_that_fell_off_or_flew_away_do_not_count() -> None:
    one = heap(25.0, 6.0, 3)
    strays = spheres([[0, 0, -3], [70, 0, 0.5], [20, 0, -0.4]])
    assert measure(joined(one, strays)) == measure(one)
    flown = spheres([[1e4, 0, 0.5], [0, 0, 1e4]])
    measured = angle_of_repose(joined(one, flown), DIAMETER, plate_radius=1e6)
    assert measured.value == pytest.approx(measure(one), abs=0.01)


def test_particles_stacked_on_the_foot_of_a_flank_hardly_tilt_it() -> None:
    """Least squares without weights would be 0.7 degrees off."""
    one = heap(25.0, 7.0, 0)
    stacked = spheres([[10.0, 0.0, 2.6], [10.0, 0.0, 3.6]])
    assert measure(joined(one, stacked)) == pytest.approx(measure(one), abs=0.25)


def test_flank_that_ends_at_the_plate_edge_is_measured_without_the_edge() -> None:
    cut = angle_of_repose(heap(15.0, 6.0, 2), DIAMETER, plate_radius=14 * DIAMETER)
    assert cut.value == pytest.approx(15.0, abs=0.7)


def test_fitted_lines_lie_on_the_flanks_and_have_their_angle() -> None:
    measured = angle_of_repose(heap(25.0, 8.0, 3), DIAMETER, WIDE_PLATE)
    slope = math.tan(math.radians(25))
    for view in measured.views:
        assert view.left is not None
        assert view.right is not None
        assert view.left.end[0] < 0 < view.right.end[0]
        for flank in (view.left, view.right):
            (x1, z1), (x2, z2) = flank.start, flank.end
            inclination = math.degrees(math.atan2(z2 - z1, abs(x1) - abs(x2)))
            assert inclination == pytest.approx(flank.angle)
            surface = 8.0 * DIAMETER - slope * (abs(x1) + abs(x2)) / 2
            assert surface - DIAMETER < (z1 + z2) / 2 < surface


def layer(radius: float, thickness: int) -> Particles:
    n = math.ceil(radius)
    points = np.mgrid[-n : n + 1, -n : n + 1, 0:thickness].reshape(3, -1).T + 0.0
    points[:, 2] += 0.5
    return spheres(points[np.hypot(points[:, 0], points[:, 1]) < radius])


def column() -> Particles:
    centres, radii = packing(6.0, 11.0, 1)
    above = centres[:, 2] > 0.5
    return particles_of(centres[above], radii[above])


def half(particles: Particles) -> Particles:
    return particles.select(particles.positions[:, 0] > 0)


def ridge(particles: Particles) -> Particles:
    return particles.select(np.abs(particles.positions[:, 1]) < 3 * DIAMETER)


def stump_on_a_foot() -> Particles:
    """A cone of 50 degrees that stands in one of 12 degrees."""
    steep, flat = heap(50, 10, 1), heap(12, 5, 2)
    x, y, z = flat.positions.T / DIAMETER
    outside = z > 10 - math.tan(math.radians(50)) * np.hypot(x, y)
    return joined(steep, flat.select(outside))


@pytest.mark.parametrize(
    ("particles", "message"),
    [
        (spheres([]), messages.NOT_ON_PLATE),
        (spheres([[0, 0, -5], [80, 0, 0.5]]), messages.NOT_ON_PLATE),
        (spheres([0, 0, 0.5]), messages.NO_HEAP),
        (layer(20, 1), messages.NO_HEAP),
        (layer(30, 2), messages.NO_HEAP),
        (heap(25, 2, 1), messages.NO_HEAP),
        (layer(15, 5), messages.COLUMN_OR_LAYER),
        (column(), messages.COLUMN_OR_LAYER),
        (half(heap(25, 8, 1)), messages.ONE_SIDED_HEAP),
        (moved(heap(25, 8, 1), (15, 0, 0)), messages.ONE_SIDED_HEAP),
        (ridge(heap(25, 8, 1)), None),
        (joined(moved(heap(25, 4, 1), (-9, 0, 0)), moved(heap(25, 4, 2), (9, 0, 0))), None),
        (heap(70, 16, 1), messages.FEW_FLANKS),
        (
            stump_on_a_foot(),
            messages.TWO_SLOPES,
        ),
    ],
    ids=[
        "nothing",
        "all fell off",
        "one particle",
        "single layer",
        "double layer",
        "low heap",
        "thick layer",
        "column",
        "one flank",
        "off the axis",
        "ridge",
        "two heaps",
        "too steep",
        "two slopes",
    ],
)
@pytest.mark.parametrize("ground", [0.0, DIAMETER])
def test_odd_heap_is_not_measurable_and_says_why(
    particles: Particles, ground: float, message: Message | None
) -> None:
    with pytest.raises(NotMeasurableError, match=r"^angle of repose: ") as caught:
        angle_of_repose(particles, ground, WIDE_PLATE)
    reason = str(caught.value)
    assert message.is_in(reason) if message else "flanks" in reason


def photograph(left: float, right: float) -> Silhouette:
    """A triangle 10 cm high with flanks of these angles, 0.5 mm a pixel, its axis at 0."""
    size, width, height = 0.0005, 1200, 220
    x = (np.arange(width) + 0.5) * size - width * size / 2
    slope = np.tan(np.radians(np.where(x < 0, left, right)))
    rows = (np.arange(height)[::-1] + 0.5) * size
    return Silhouette(rows[:, None] < 0.1 - np.abs(x) * slope, size, left=-width * size / 2)


def test_photograph_is_measured_like_a_rendered_silhouette() -> None:
    measured = angle_of_repose_in([photograph(30, 32)], [0.0], ground=0.0, diameter=0.001)
    view = measured.views[0]
    # The outline's depth for 1 mm particles adds 0.1 degrees.
    assert view.left is not None
    assert view.left.angle == pytest.approx(30, abs=0.2)
    assert view.right is not None
    assert view.right.angle == pytest.approx(32, abs=0.2)
    assert measured.value == pytest.approx(31, abs=0.2)


def test_photograph_with_one_flank_is_not_measurable() -> None:
    one_flank = photograph(30, 30)
    image = one_flank.image.copy()
    image[:, : image.shape[1] // 2] = False
    with pytest.raises(NotMeasurableError, match=messages.ONE_SIDED_HEAP.pattern):
        angle_of_repose_in([Silhouette(image, 0.0005, one_flank.left)], [0.0], 0.0, 0.001)


def test_blank_photograph_is_not_measurable() -> None:
    blank = Silhouette(np.zeros((100, 200), dtype=bool), 0.001, left=-0.1)
    with pytest.raises(NotMeasurableError, match=messages.NO_HEAP.pattern):
        angle_of_repose_in([blank], [0.0], 0.0, 0.001)


@pytest.mark.parametrize(("angle", "distance"), [(15.0, 12.0), (25.0, 8.0), (40.0, 5.0)])
def test_outline_depth_agrees_with_spheres_thrown_under_a_cone(
    angle: float, distance: float
) -> None:
    rng = np.random.default_rng(5)
    depths = [_thrown_depth(rng, angle, distance) for _ in range(4000)]
    expected = float(outline_depth(np.array([distance]), angle, 1.0)[0])
    error = np.std(depths) / math.sqrt(len(depths))
    # Four standard errors and 5 % for the parabolas that the closed form has for circles.
    assert np.mean(depths) == pytest.approx(expected, abs=4 * error + 0.05 * expected)


def _thrown_depth(rng: np.random.Generator, angle: float, distance: float) -> float:
    """Depth of the outline at one distance, of points at random under a cone."""
    slope, steepness = math.tan(math.radians(angle)), math.cos(math.radians(angle))
    low, high = np.array([-1.5, -6.0, -2.5]), np.array([1.5, 6.0, 1.5])
    count = rng.poisson(0.6 / (math.pi / 6) * float(np.prod(high - low)))
    x, y, z = rng.uniform(low, high, (count, 3)).T
    under = z < (distance - np.hypot(distance + x, y)) * slope
    x, z = x[under], z[under]
    near = np.abs(x) < 0.5
    tops: NDArray[np.float64] = z[near] + np.sqrt(0.25 - x[near] ** 2)
    return 0.5 / steepness - float(tops.max())
