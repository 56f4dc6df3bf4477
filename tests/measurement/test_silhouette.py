from __future__ import annotations

import math

import numpy as np
import pytest

from grainfit.measurement.particles import Particles
from grainfit.measurement.silhouette import Silhouette, render_silhouette


def random_spheres(count: int, seed: int = 0) -> Particles:
    rng = np.random.default_rng(seed)
    positions = rng.uniform([-1, -1, 0], [1, 1, 0.6], (count, 3))
    return Particles(positions, rng.uniform(0.02, 0.12, count), np.ones(count))


@pytest.mark.parametrize("azimuth", [0.0, 37.0, 90.0, 165.0])
def test_pixel_is_covered_when_its_middle_lies_in_a_disc(azimuth: float) -> None:
    """Some discs stick out of the picture on every side."""
    particles = random_spheres(60)
    seen = render_silhouette(particles, azimuth, half_width=0.9, height=0.5, pixel_size=0.01)
    angle = math.radians(azimuth)
    across = particles.positions[:, 0] * math.cos(angle) + particles.positions[:, 1] * math.sin(
        angle
    )
    rows = seen.image.shape[0]
    heights = (np.arange(rows)[::-1] + 0.5) * 0.01
    expected = np.zeros_like(seen.image)
    for u, z, r in zip(across, particles.positions[:, 2], particles.radii, strict=True):
        expected |= (seen.columns - u) ** 2 + (heights[:, None] - z) ** 2 <= r**2
    assert 0.2 < expected.mean() < 0.98
    np.testing.assert_array_equal(seen.image, expected)


def test_silhouette_of_a_sphere_has_the_area_of_its_disc() -> None:
    one = Particles(np.array([[0.3, 0.1, 0.5]]), np.array([0.2]), np.ones(1))
    seen = render_silhouette(one, 30.0, half_width=1.0, height=1.0, pixel_size=0.005)
    area = seen.image.sum() * 0.005**2
    assert area == pytest.approx(math.pi * 0.2**2, rel=0.005)


def test_outline_is_the_upper_edge_and_nan_where_there_is_nothing() -> None:
    image = np.zeros((5, 4), dtype=bool)
    image[0, 0] = True
    image[[1, 4], 1] = True
    image[4, 3] = True
    seen = Silhouette(image, pixel_size=0.1, left=-0.2, bottom=1.0)
    np.testing.assert_allclose(seen.outline(), [1.5, 1.4, np.nan, 1.1])
    np.testing.assert_allclose(seen.columns, [-0.15, -0.05, 0.05, 0.15])


def test_outline_of_a_sphere_is_a_circle_to_a_pixel() -> None:
    one = Particles(np.array([[0.0, 0.0, 0.5]]), np.array([0.3]), np.ones(1))
    seen = render_silhouette(one, 0.0, half_width=0.5, height=1.0, pixel_size=0.01)
    inside = np.abs(seen.columns) < 0.29
    circle = 0.5 + np.sqrt(0.3**2 - seen.columns[inside] ** 2)
    np.testing.assert_allclose(seen.outline()[inside], circle, atol=0.01)
    assert np.isnan(seen.outline()[np.abs(seen.columns) > 0.3]).all()
