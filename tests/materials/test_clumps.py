"""Volume, centre and inertia of overlapping spheres."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grainfit.materials.clumps import body_of, clump_of
from grainfit.materials.particle_shape import FAMILIES, ParticleShape


def capped_sphere(radius: float, cut: float) -> tuple[float, float, float]:
    """Return volume, and second moments along and across x, of a sphere up to x = cut.

    Integrals of 1, x^2 and y^2 over slices from -radius to cut.
    """

    def between(primitive) -> float:
        return primitive(cut) - primitive(-radius)

    volume = between(lambda x: math.pi * (radius**2 * x - x**3 / 3))
    along = between(lambda x: math.pi * (radius**2 * x**3 / 3 - x**5 / 5))
    # A slice has y^2 of pi s^4 / 4, with s^2 = radius^2 - x^2.
    across = between(lambda x: math.pi / 4 * (radius**4 * x - 2 * radius**2 * x**3 / 3 + x**5 / 5))
    return volume, along, across


@pytest.mark.parametrize("distance", [0.2, 0.6, 1.0])
def test_two_overlapping_spheres_have_the_volume_and_inertia_of_two_caps(distance: float) -> None:
    radius = 0.5
    volume, centre, inertia = body_of(
        np.array([[-distance / 2, 0.2, -0.1], [distance / 2, 0.2, -0.1]]), np.full(2, radius)
    )

    cap, along, across = capped_sphere(radius, distance / 2)
    # The first moment of a cap about the centre of its sphere.
    first = math.pi * (radius**2 * (distance / 2) ** 2 / 2 - (distance / 2) ** 4 / 4)
    first -= math.pi * (radius**4 / 2 - radius**4 / 4)
    half = distance / 2
    x2 = 2 * (along - 2 * half * first + half**2 * cap)
    y2 = 2 * across
    assert volume == pytest.approx(2 * cap, rel=2e-5)
    assert centre == pytest.approx([0.0, 0.2, -0.1], abs=1e-9)
    expected = np.diag([2 * y2, x2 + y2, x2 + y2])
    assert inertia == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_spheres_apart_add_up_by_the_theorem_of_steiner() -> None:
    places, radii = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 0.5]]), np.array([0.5, 0.3])
    volume, centre, inertia = body_of(places, radii)

    masses = 4 / 3 * math.pi * radii**3
    middle = masses @ places / masses.sum()
    expected = sum(
        (0.4 * m * r**2 + m * arm @ arm) * np.eye(3) - m * np.outer(arm, arm)
        for m, r, arm in zip(masses, radii, places - middle, strict=True)
    )
    assert volume == pytest.approx(masses.sum(), rel=2e-4)
    assert centre == pytest.approx(middle, abs=1e-4)
    assert inertia == pytest.approx(expected, rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_is_a_body_of_unit_volume_about_its_centre(family: str) -> None:
    clump = ParticleShape(family, aspect_ratio=1.7).clump
    assert clump is not None
    volume, centre, inertia = body_of(clump.positions, clump.radii)

    assert volume == pytest.approx(math.pi / 6, rel=1e-4)
    assert centre == pytest.approx([0, 0, 0], abs=1e-4)
    assert inertia / volume == pytest.approx(np.diag(clump.moments), rel=2e-3, abs=2e-4)
    extent = np.ptp(np.vstack([clump.positions[:, 0] + s * clump.radii for s in (-1, 1)]))
    if family != "tetrahedron":
        assert extent / (2 * clump.radii.max()) == pytest.approx(1.7, rel=1e-6)


@pytest.mark.parametrize("family", FAMILIES)
def test_an_aspect_ratio_near_one_is_nearly_a_sphere(family: str) -> None:
    clump = ParticleShape(family, aspect_ratio=1.001).clump
    assert clump is not None

    assert 2 * clump.outer_radius == pytest.approx(1.0, abs=2e-3)
    assert clump.moments == pytest.approx([0.1] * 3, rel=5e-3)
    assert ParticleShape(family, aspect_ratio=1.0).clump is None


def test_spheres_of_the_user_are_turned_to_their_principal_axes_in_any_unit() -> None:
    spheres = ((1.0, 1.0, 0.0, 1.0), (2.0, 2.0, 0.0, 0.8), (2.6, 2.7, 0.5, 0.5))
    large = tuple(tuple(1000 * value for value in sphere) for sphere in spheres)
    clump, same = (ParticleShape(spheres=given).clump for given in (spheres, large))
    assert clump is not None
    assert same is not None
    _, _, inertia = body_of(clump.positions, clump.radii)

    products = inertia - np.diag(np.diag(inertia))
    assert np.abs(products).max() < 1e-3 * inertia.max()
    assert same.radii == pytest.approx(clump.radii, rel=1e-9)
    assert same.moments == pytest.approx(clump.moments, rel=1e-6)
    # Turned, not mirrored.
    arms = np.array(spheres)[:, :3] - spheres[0][:3], clump.positions - clump.positions[0]
    assert np.linalg.norm(arms[1], axis=1) == pytest.approx(
        np.linalg.norm(arms[0], axis=1) * clump.radii[0], rel=1e-9
    )


def radius_ratio(family: str, aspect_ratio: float) -> float:
    """Return the radius that limits the time step over that of the smallest sphere."""
    clump = ParticleShape(family, aspect_ratio=aspect_ratio).clump
    assert clump is not None
    return clump.rayleigh_radius / clump.smallest_radius


@pytest.mark.parametrize(("family", "spheres"), [("two_spheres", 2), ("lens", 7), ("grain", 7)])
def test_the_time_step_knows_that_spheres_which_nearly_coincide_touch_at_once(
    family: str, spheres: int
) -> None:
    # n spheres against n have n^2 contacts, so that the clump swings n times as fast.
    assert radius_ratio(family, 1.0001) == pytest.approx(1.5 / spheres, rel=0.01)
    ratios = [radius_ratio(family, 1 + excess) for excess in (0.01, 0.05, 0.1, 0.2)]
    assert ratios == sorted(ratios)


@pytest.mark.parametrize(
    ("family", "aspect_ratio"),
    [("two_spheres", 1.25), ("cylinder", 3.0), ("tetrahedron", 1.5), ("lens", 2.0), ("grain", 1.5)],
)
def test_slender_clumps_have_the_time_step_of_their_smallest_sphere(
    family: str, aspect_ratio: float
) -> None:
    assert radius_ratio(family, aspect_ratio) == 1.0


def test_small_spheres_about_a_large_one_stiffen_a_clump_by_the_root_of_their_radius() -> None:
    # On one side, many small spheres nearly coincide and reach as far as the large one.
    small = [(0.8, 1e-4 * n, 0.0, 0.2) for n in range(1, 21)]
    nest = clump_of(((0.0, 0.0, 0.0, 1.0), *small))

    # Of two clumps in contact there: 20 x 20 pairs of small spheres (radius 0.2), twice 20 with the
    # large one (2 * 0.2 / 1.2), and the two large ones, each with the same overlap.
    stiffness = 400 * math.sqrt(0.2) + 40 * math.sqrt(1 / 3) + 1
    # At a diameter of 1, stiffness and radii have half of that; a sphere swings with 8 * 0.5.
    ratio = 0.5 * 0.2 * math.sqrt(8 * 0.5 * stiffness)
    assert nest.rayleigh_radius / nest.smallest_radius == pytest.approx(1.5 / ratio, rel=0.02)
