"""Where particles begin: a column below its gate or beside its vessel is found, others are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grainfit.bulk_tests.own_scene.checks import beside_all_tubes, without_wall_below
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Round, random_column
from grainfit.scenes.scene import Box, Scene, Wall
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Plane
from grainfit.testing.simulated_scenes import DAMPED, scene_of, settle

SIZES = ParticleSizes((0.01,))
BOX = Box((-0.1, -0.1, -0.1), (0.3, 0.1, 0.6))
TUBE = Wall(Cylinder(0.03, 0.0, 0.5))


def scene(walls: dict[str, Wall], shift: tuple[float, float, float] = (0, 0, 0)) -> Scene:
    column = random_column(SIZES, 100, Round(0.03), 1)
    moved = replace(column, positions=column.positions + np.array(shift))
    return scene_of(moved, walls, [settle()], DAMPED, sizes=SIZES, box=BOX)


@pytest.mark.parametrize(
    "floor",
    [
        Plane("z", 0.0),
        Disc(0.03, 0.0),
        Block((-0.05, -0.05, -0.02), (0.05, 0.05, 0.0)),
        Cylinder(0.05, -0.1, 0.3, "x"),
        Cone(0.0005, 0.05, -0.05, 0.0),
    ],
    ids=lambda shape: type(shape).__name__.lower(),
)
def test_a_column_over_its_floor_is_held(floor) -> None:
    assert without_wall_below(scene({"floor": Wall(floor), "tube": TUBE})) < 0.05


def test_a_column_below_its_gate_is_found() -> None:
    gate = Wall(Disc(0.03, 0.55))
    assert without_wall_below(scene({"gate": gate, "tube": TUBE})) == 1.0
    half = scene({"gate": Wall(Disc(0.03, 0.07)), "tube": TUBE})
    below = float((half.particles.positions[:, 2] < 0.07).mean())
    assert without_wall_below(half) == pytest.approx(below, abs=0.02)


def test_a_hole_catches_nothing() -> None:
    ring = scene({"ring": Wall(Annulus(0.02, 0.03, 0.0)), "tube": TUBE})
    over_hole = np.hypot(*ring.particles.positions[:, :2].T) < 0.02
    assert without_wall_below(ring) == pytest.approx(over_hole.mean(), abs=0.05)


def test_a_column_beside_its_vessel_is_found() -> None:
    walls = {"floor": Wall(Plane("z", 0.0)), "tube": TUBE}
    assert beside_all_tubes(scene(walls)) == 0.0
    assert beside_all_tubes(scene(walls, (0.1, 0, 0))) == 1.0
    assert beside_all_tubes(scene({**walls, "pipe": Wall(Cylinder(0.004, 0.0, 0.5))})) == 0.0
