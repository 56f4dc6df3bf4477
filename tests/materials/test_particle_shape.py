"""Shapes of particles: what is refused, and what is part of an identity."""

from __future__ import annotations

import pytest

from grainfit.errors import InputError
from grainfit.materials.particle_shape import ParticleShape, aspect_ratio_faults
from grainfit.materials.sizes import ParticleSizes


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "neither a family nor spheres"),
        ({"family": "cube"}, "'cube' is no family"),
        ({"family": "two_spheres", "aspect_ratio": 2.1}, "is 2.1 for two_spheres"),
        ({"family": "grain", "aspect_ratio": float("nan")}, "is nan for grain"),
        ({"spheres": ((0, 0, 0, 1),)}, "has 1 spheres"),
        ({"spheres": ((0, 0, 0, 1), (0, 0, 2.1, 1))}, "sphere 2 is apart"),
        ({"spheres": ((0, 0, 0, 1), (1, 0, 0, 0))}, "are impossible"),
        ({"spheres": ((0, 0, 0, 1), (1, 0, 0, 0.001))}, "below 0.01 of the largest"),
    ],
)
def test_impossible_shapes_are_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        ParticleShape(**given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "shape", [ParticleShape("lens"), ParticleShape(spheres=((0, 0, 0, 1), (1, 0, 0, 0.7)))]
)
def test_a_definition_gives_the_shape_back_without_its_aspect_ratio(shape: ParticleShape) -> None:
    again = ParticleShape.from_definition(shape.with_aspect_ratio(1.5).definition())

    assert again == shape


def test_an_aspect_ratio_needs_a_family_that_has_it() -> None:
    own = ParticleShape(spheres=((0, 0, 0, 1), (1, 0, 0, 1)))

    assert not aspect_ratio_faults(None, 1.0)
    assert not aspect_ratio_faults(ParticleShape("cylinder"), 2.5)
    for shape, ratio in ((None, 1.5), (own, 1.5), (ParticleShape("two_spheres"), 2.5)):
        (fault,) = aspect_ratio_faults(shape, ratio)
        assert fault.key == "particle.aspect_ratio"


def test_sizes_of_clumps_are_those_of_spheres_of_equal_volume() -> None:
    sizes = ParticleSizes((0.01, 0.005), (0.5, 0.5), shape=ParticleShape("two_spheres"))
    slender = sizes.with_aspect_ratio(2.0)

    assert sizes.clump is None
    assert slender.number_fractions == sizes.number_fractions
    # Two touching spheres of half the volume each.
    assert slender.smallest_radius == pytest.approx(0.0025 / 2 ** (1 / 3), rel=1e-4)
    assert slender.outer_diameters == pytest.approx(
        [0.02 / 2 ** (1 / 3), 0.01 / 2 ** (1 / 3)], rel=1e-4
    )
    assert sizes.outer_diameters == sizes.diameters


@pytest.mark.parametrize("inside", [(0, 0, 0, 1), (0.1, 0, 0, 0.5)])
def test_a_sphere_inside_another_is_refused(inside: tuple[float, float, float, float]) -> None:
    with pytest.raises(InputError, match="sphere 2 inside sphere 1"):
        ParticleShape(spheres=((0, 0, 0, 1), inside))
    with pytest.raises(InputError, match=r"sphere \d inside sphere \d"):
        ParticleShape(spheres=(inside, (0, 0, 0, 1)))


def test_the_smallest_spheres_of_clumps_have_their_diameters() -> None:
    own = ParticleShape(spheres=((0, 0, 0, 1), (1, 0, 0, 0.2)))
    sizes = ParticleSizes((0.01, 0.005), (0.5, 0.5), shape=own)

    assert sizes.sphere_diameters[1] / sizes.sphere_diameters[0] == pytest.approx(0.5)
    # The small sphere adds a thousandth of the volume.
    assert sizes.sphere_diameters[0] == pytest.approx(0.002, rel=0.01)
    assert ParticleSizes((0.01,)).sphere_diameters == (0.01,)
