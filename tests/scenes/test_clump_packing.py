"""Random columns and tubes of clumps."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.errors import InputError
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes import messages
from grainfit.scenes.clump_packing import place_clumps
from grainfit.scenes.packing import (
    Column,
    PeriodicRectangle,
    Rectangle,
    Round,
    mean_particle_volume,
    random_column,
    random_in_tube,
)
from grainfit.scenes.spheres import ClumpSpheres, random_orientations

DIAMETERS = (0.010, 0.006)
SIZES = ParticleSizes(DIAMETERS, (0.6, 0.4), shape=ParticleShape("grain", aspect_ratio=2.0))


def outlines(column: Column) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return centres and radii of all spheres, and the number of each clump's."""
    assert SIZES.clump is not None
    places, radii = column.outlines(ClumpSpheres(SIZES.clump, DIAMETERS))
    return places, radii, len(SIZES.clump)


def smallest_gap(column: Column, period: tuple[float, float, float]) -> float:
    """Return the smallest distance between surfaces of different clumps, across sides, too."""
    places, radii, each = outlines(column)
    between = places[:, None] - places[None]
    lengths = np.array(period)
    span = np.where(lengths > 0, lengths, 1.0)
    between -= np.where(lengths > 0, lengths * np.round(between / span), 0.0)
    gaps = np.linalg.norm(between, axis=2) - radii[:, None] - radii[None]
    owners = np.arange(len(radii)) // each
    return float(gaps[owners[:, None] != owners[None]].min())


@pytest.mark.parametrize(
    ("footprint", "period"),
    [
        (Round(0.04), (0.0, 0.0, 0.0)),
        (Rectangle(0.08, 0.04), (0.0, 0.04, 0.0)),
        (PeriodicRectangle(0.06, 0.04), (0.06, 0.04, 0.0)),
    ],
    ids=["round", "rectangle", "periodic"],
)
def test_clumps_of_a_column_touch_neither_each_other_nor_walls(footprint, period) -> None:
    column = random_column(SIZES, 150, footprint, seed=2)
    places, radii, _ = outlines(column)

    assert len(column.positions) == 150
    assert smallest_gap(column, period) > 0
    assert (places[:, 2] - radii > 0).all()
    assert (places[:, 2] + radii < column.height).all()
    if isinstance(footprint, Round):
        assert (np.hypot(places[:, 0], places[:, 1]) + radii < footprint.radius).all()
    elif isinstance(footprint, Rectangle):
        assert (np.abs(places[:, 0]) + radii < footprint.width / 2).all()


@pytest.mark.parametrize("family", ["grain", "two_spheres"], ids=["unequal", "equal"])
def test_the_first_of_the_clumps_that_touch_keep_their_places(family: str) -> None:
    sizes = ParticleSizes((0.01,), shape=ParticleShape(family, aspect_ratio=2.0))
    assert sizes.clump is not None
    side, clearance, count = 0.05, 0.01, 70
    spheres = ClumpSpheres(sizes.clump, sizes.diameters)

    def draw(number: int, diameter: float) -> NDArray[np.float64]:
        return drawn.random((number, 3)) * side

    drawn = np.random.default_rng(1)
    period = (side, 0.0, 0.0)
    placed = place_clumps(drawn, sizes, [count], draw, period, clearance, grow=lambda: None)

    drawn = np.random.default_rng(1)
    radii = spheres.radii(np.zeros(1, dtype=np.int64))[0]
    reach = (1 + clearance) * (radii[:, None] + radii[None])
    found: list[NDArray[np.float64]] = []
    while len(found) < count:
        tried = 4 * (count - len(found)) + 50
        none = np.zeros(tried, dtype=np.int64)
        centres = draw(tried, 0.01)
        for one in spheres.places(centres, random_orientations(drawn, tried), none):
            between = np.array(found).reshape(-1, 1, len(radii), 3) - one[None, :, None]
            between[..., 0] -= side * np.round(between[..., 0] / side)
            if len(found) < count and not (np.linalg.norm(between, axis=-1) < reach.T).any():
                found.append(one)
    assert spheres.places(placed.positions, placed.orientations, placed.size_indices) == (
        pytest.approx(np.array(found), rel=1e-12)
    )


def test_orientations_are_random_and_follow_from_the_seed() -> None:
    column, same, other = (random_column(SIZES, 400, Round(0.05), seed) for seed in (1, 1, 2))

    assert column.orientations is not None
    assert same.orientations is not None
    assert (column.orientations == same.orientations).all()
    assert other.orientations is not None
    assert not (column.orientations == other.orientations).any()
    # The long axis has no preferred direction: a third of its square along each axis.
    places, _, each = outlines(column)
    ends = places.reshape(-1, each, 3)
    axes = ends[:, -1] - ends[:, 0]
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    assert (axes**2).mean(axis=0) == pytest.approx([1 / 3] * 3, abs=0.06)


def test_a_tube_takes_clumps_up_to_what_it_holds() -> None:
    radius, length = 0.05, 0.05
    tube = np.pi * radius**2 * length
    count = int(0.2 * tube / mean_particle_volume(SIZES))
    column = random_in_tube(SIZES, count, radius, length, seed=3)
    places, radii, _ = outlines(column)

    assert smallest_gap(column, (length, 0.0, 0.0)) > 0
    assert (np.hypot(places[:, 1], places[:, 2]) + radii < radius).all()
    with pytest.raises(InputError, match=messages.NO_ROOM.pattern):
        random_in_tube(SIZES, 4 * count, radius, length, seed=3)
