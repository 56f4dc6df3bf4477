"""Contacts of clumps, against spheres and spheres that coincide."""

from __future__ import annotations

import numpy as np
import pytest

from grainfit.materials.clump_contacts import touching_of
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes

#: Of a sphere of diameter 1, over its mass.
SPHERE = (0.1, 0.1, 0.1)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_n_spheres_that_coincide_touch_in_n_squared_pairs(count: int) -> None:
    found = touching_of(np.zeros((count, 3)), np.full(count, 0.5), SPHERE)
    # The stiffness of n^2 pairs is n^2 times as large; so is the sum of their dashpots.
    assert found.frequency == pytest.approx(count, rel=1e-5)
    assert found.damping == pytest.approx(count, rel=1e-5)


def test_the_contact_does_not_depend_on_the_order_of_the_spheres() -> None:
    clump = ParticleSizes((0.01,), shape=ParticleShape("grain", aspect_ratio=1.5)).clump
    assert clump is not None
    turned = touching_of(clump.positions[::-1], clump.radii[::-1], clump.moments)
    found = touching_of(clump.positions, clump.radii, clump.moments)
    assert turned == pytest.approx(found, rel=1e-9)


def test_spheres_in_a_row_touch_several_at_once_and_two_apart_touch_as_one() -> None:
    def damping(family: str, ratio: float) -> float:
        clump = ParticleSizes((0.01,), shape=ParticleShape(family, aspect_ratio=ratio)).clump
        assert clump is not None
        return clump.touching.damping

    assert damping("grain", 1.2) > damping("grain", 1.5) > damping("grain", 1.8) > 1.5
    assert damping("two_spheres", 1.5) < 1.3
