"""Scenes as data: names, energies, concepts, and the triangles of walls."""

import math
from dataclasses import is_dataclass, replace

import numpy as np
import pytest

from grainfit import scenes
from grainfit.errors import InputError
from grainfit.scenes import conditions, packing, records, scene, shapes
from grainfit.scenes.conditions import Clear, Elapsed, Loaded
from grainfit.scenes.glued import Glued
from grainfit.scenes.records import Force, Frames, KineticEnergy, RadialForce, Series, Travel
from grainfit.scenes.scene import Box, Load, Rotation, Stage, Velocity, Wall
from grainfit.scenes.shapes import Block, Cylinder, Plane
from grainfit.scenes.triangles import triangles_of
from grainfit.testing.scene_contract import MASS, RADIUS, WEIGHT, frames, scene_of, spheres

FLOOR = Wall(Plane("z", 0.0))
LIFT = Velocity("z", 1.0)
ONE = spheres([(0, 0, 0.1)])
PLATE = Glued(np.array([(0.0, 0.0, 0.2)]), np.array([0]))


@pytest.mark.parametrize("module", [conditions, packing, records, scene, shapes])
def test_all_words_of_a_scene_are_in_one_place(module):
    words = {
        name
        for name, found in vars(module).items()
        if is_dataclass(found) and found.__module__ == module.__name__
    }
    assert words
    assert words <= vars(scenes).keys()


@pytest.mark.parametrize(
    ("walls", "stage", "key", "message"),
    [
        ({"front wall": FLOOR}, Stage("fall", Elapsed(1.0)), "walls", "'front wall' is not one"),
        ({}, Stage("fall down", Elapsed(1.0)), "stages", "'fall down' is not one word"),
        ({}, Stage("fall", Elapsed(1.0), snapshot="../x"), "snapshots", "'../x' is not one word"),
        (
            {},
            Stage("fall", Elapsed(1.0), series=Series({"a,b": KineticEnergy()}, 0.1)),
            "columns",
            "'a,b' is not one word",
        ),
        ({"floor": FLOOR}, Stage("fall", Elapsed(1.0), put={"floor": FLOOR}), "walls", "twice"),
        (
            {},
            Stage("fall", Elapsed(1.0), frames=Frames("end", 0.1), snapshot="end"),
            "snapshots",
            "'end' is there twice",
        ),
    ],
)
def test_a_name_that_a_deck_would_misread_is_refused(walls, stage, key, message):
    with pytest.raises(InputError) as caught:
        scene_of(ONE, walls, [stage])
    (fault,) = caught.value.faults
    assert fault.key == key
    assert message in fault.message
    assert fault.remedy


def test_the_name_of_a_surface_is_one_word():
    stage = Stage("fall", Elapsed(1.0))
    with pytest.raises(InputError, match=r"surfaces: 'a \"b\"' is not one word"):
        replace(scene_of(ONE, {}, [stage]), surfaces={'a "b"': {}})


@pytest.mark.parametrize(
    ("key", "name"),
    [
        *(("walls", name) for name in ("gravity", "motion", "series", "walls", "above")),
        *(("walls", name) for name in ("all", "loose", "glued", "surplus")),
        ("walls", "youngs_modulus"),
        *(("stages", name) for name in ("end", "restless", "broken", "unstable", "unloaded")),
        ("columns", "time"),
    ],
)
def test_a_name_that_decks_use_themselves_is_refused(key, name):
    walls = {name if key == "walls" else "floor": FLOOR}
    series = Series({name if key == "columns" else "energy": KineticEnergy()}, 0.1)
    stage = Stage(name if key == "stages" else "fall", Elapsed(1.0), series=series)
    with pytest.raises(InputError) as caught:
        scene_of(ONE, walls, [stage])
    (fault,) = caught.value.faults
    assert fault.key == key
    assert f"'{name}' has another meaning in decks" in fault.message


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        (Stage("open", Elapsed(1.0), take_away=("door",)), "takes away the wall 'door'"),
        (
            Stage("open", Elapsed(1.0), motions={"door": Velocity("z", 1.0)}),
            "moves the wall 'door'",
        ),
        (
            Stage(
                "open", Elapsed(1.0), take_away=("floor",), motions={"floor": Velocity("z", 1.0)}
            ),
            "moves the wall 'floor', which is not there",
        ),
        (
            Stage("open", Elapsed(1.0), series=Series({"force": Force("door", "z")}, 0.1)),
            "records the wall 'door'",
        ),
        (Stage("open", Clear("floor", 1.0)), "'floor' is clear, which is no upright Cylinder"),
        (Stage("open", Clear("tube", 1.0)), "'tube' is clear, which is no upright Cylinder"),
        (Stage("open", Loaded("floor", 0.1, 1.0)), "puts no load on it"),
    ],
)
def test_a_stage_without_the_wall_that_it_needs_is_refused(stage, message):
    with pytest.raises(InputError) as caught:
        scene_of(ONE, {"floor": FLOOR}, [stage])
    (fault,) = caught.value.faults
    assert fault.key == "stage open"
    assert message in fault.message
    assert fault.remedy


@pytest.mark.parametrize(
    ("others", "message"),
    [
        (Velocity("y", 0.1), "turns about an axis, and moves in another way"),
        (Rotation("y", 1.0, (0.1, 0.0, 0.0)), "turns about an axis, and moves in another way"),
        (Rotation("y", 0.0), "turns with a speed of 0"),
    ],
)
def test_a_wall_turns_about_one_axis_and_does_nothing_else(others, message):
    turned = Stage("turn", Elapsed(1.0), motions={"drum": Rotation("y", 1.0)})
    other = Stage("other", Elapsed(1.0), motions={"drum": others})
    drum = {"drum": Wall(Cylinder(0.1, -0.1, 0.1, "y"))}
    assert scene_of(ONE, drum, [turned]).concepts() == {"cylinder", "lying cylinder", "rotation"}
    with pytest.raises(InputError) as caught:
        scene_of(ONE, drum, [turned, other])
    (fault,) = caught.value.faults
    assert fault.key == "drum"
    assert message in fault.message


def test_only_an_upright_tube_is_lifted_clear():
    lift = Stage("lift", Clear("drum", 1.0))
    with pytest.raises(InputError, match="'drum' is clear, which is no upright Cylinder"):
        scene_of(ONE, {"drum": Wall(Cylinder(0.1, -0.1, 0.1, "y"))}, [lift])


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("is_periodic", [True, False])
def test_triangles_of_a_tube_are_about_its_axis(axis, is_periodic):
    number, length, radius = "xyz".index(axis), 0.03, 0.05
    low, high = [-0.2] * 3, [0.2] * 3
    low[number], high[number] = 0.0, length
    box = Box(tuple(low), tuple(high), periodic=axis if is_periodic and axis != "z" else "")
    triangles = triangles_of(Cylinder(radius, 0.0, length, axis), box, 0.01)

    around = np.delete(triangles, number, axis=2)
    assert np.linalg.norm(around, axis=2) == pytest.approx(radius, rel=5e-3)
    along = triangles[:, :, number]
    assert (along.min(), along.max()) == pytest.approx((0.0, length))
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(sides, axis=1).sum() / 2
    assert area == pytest.approx(2 * np.pi * radius * length, rel=5e-3)
    if box.periodic:
        assert np.ptp(along, axis=1).max() < 0.3 * length


PRESS, PUSH = Load("z", -1.0, 0.1, 0.1), Load("x", 1.0, 0.1, 0.1)


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        (Stage("go", Elapsed(1.0), motions={"floor": (LIFT, PUSH)}), "by 2 motions"),
        (Stage("go", Elapsed(1.0), motions={"plate": (LIFT, PRESS)}), "twice along one axis"),
        (
            Stage("go", Elapsed(1.0), motions={"plate": (PRESS, PUSH)}),
            "two loads on 'plate'",
        ),
        (Stage("go", Elapsed(1.0), motions={"lid": LIFT}), "'lid', which is not there"),
        (Stage("go", Elapsed(1.0), take_away=("plate",)), "takes away the wall 'plate'"),
        (
            Stage("go", Elapsed(1.0), series=Series({"way": Travel("plate")}, 0.1)),
            "along no axis",
        ),
        (
            Stage("go", Elapsed(1.0), series=Series({"out": RadialForce("plate")}, 0.1)),
            "records the wall 'plate'",
        ),
        (
            Stage("go", Loaded("plate", 0.1, 1.0), motions={"plate": LIFT}),
            "puts no load on it",
        ),
    ],
)
def test_a_motion_or_record_that_a_glued_set_or_wall_cannot_have_is_refused(stage, message):
    with pytest.raises(InputError) as caught:
        scene_of(ONE, {"floor": FLOOR}, [stage], glued={"plate": PLATE})
    (fault,) = caught.value.faults
    assert fault.key == "stage go"
    assert message in fault.message
    assert fault.remedy


def test_a_glued_set_and_a_wall_of_one_name_are_refused():
    with pytest.raises(InputError, match="'floor' is there twice"):
        scene_of(ONE, {"floor": FLOOR}, frames(0.1), glued={"floor": PLATE})


def test_glued_particles_need_a_size_each():
    with pytest.raises(ValueError, match="1 sizes and positions of shape"):
        Glued(np.zeros((2, 3)), np.array([0]))
    with pytest.raises(ValueError, match="0 sizes"):
        Glued(np.zeros((0, 3)), np.array([], dtype=int))


def test_glued_sets_add_their_work_and_no_mass():
    still = scene_of(ONE, {}, frames(0.1), gravity=0.0)
    stage = Stage("go", Elapsed(1.0), motions={"plate": (replace(LIFT, along="x"), PRESS)})
    moved = scene_of(ONE, {}, [stage], gravity=0.0, glued={"plate": PLATE})
    assert still.energy_limit == 0.0
    assert moved.mass == still.mass
    # A load of 1 N across 0.3 m, and the particle at three times 1 m/s.
    assert moved.energy_limit == pytest.approx(0.3 + 9 * MASS / 2)
    assert moved.concepts() == {"velocity", "load", "glued"}


def test_two_stages_of_one_name_are_refused():
    with pytest.raises(InputError, match="'fall' is there twice"):
        scene_of(ONE, {}, [Stage("fall", Elapsed(1.0)), Stage("fall", Elapsed(1.0))])


def test_the_energy_limit_is_that_of_the_fall_and_of_the_start():
    still = scene_of(ONE, {}, frames(0.1))
    moving = replace(still, particles=replace(ONE, velocities=np.array([[3.0, 0.0, 4.0]])))
    assert still.initial_energy == 0.0
    assert still.energy_limit == pytest.approx(WEIGHT * (0.1 + RADIUS + 0.1))
    # Programs round it, and find a little more.
    assert moving.energy_limit - still.energy_limit == pytest.approx(1.01 * MASS * 25 / 2)


@pytest.mark.parametrize(
    ("motion", "speed"), [(Velocity("z", -2.0), 2.0), (Rotation("z", 4.0), 4.0 * math.sqrt(0.02))]
)
def test_the_energy_limit_is_that_of_a_throw_by_a_wall_if_no_fall_gives_more(motion, speed):
    stage = Stage("go", Elapsed(1.0), motions={"floor": motion})
    thrown = scene_of(ONE, {"floor": FLOOR}, [stage], gravity=0.0)
    assert thrown.energy_limit == pytest.approx(MASS * (3 * speed) ** 2 / 2)
    # Decks in which walls are slow are those of earlier versions.
    falling = scene_of(ONE, {"floor": FLOOR}, [stage], gravity=1e4)
    assert falling.energy_limit == replace(falling, stages=tuple(frames(1.0))).energy_limit


def test_a_scene_names_the_concepts_it_needs():
    stage = Stage("lift", Elapsed(1.0), motions={"floor": Velocity("z", 0.1)})
    scene = scene_of(ONE, {"floor": FLOOR}, [stage], box=Box((0, 0, 0), (1, 1, 1), "y"))
    assert scene.concepts() == {"plane", "velocity", "periodic y"}


@pytest.mark.parametrize("shape", [Plane("z", 0.0), Block((-0.1, 0, -0.1), (0.1, 1, 0.0))])
def test_triangles_are_shorter_than_the_period_and_cover_the_wall(shape):
    box = Box((-0.2, 0.0, -0.2), (0.2, 0.03, 0.2), periodic="y")
    triangles = triangles_of(shape, box, 0.01)
    edges = triangles - np.roll(triangles, 1, axis=1)
    assert np.linalg.norm(edges, axis=2).max() < 0.03
    top = triangles[(triangles[:, :, 2] == 0).all(axis=1)]
    sides = np.cross(top[:, 1] - top[:, 0], top[:, 2] - top[:, 0])
    width = 0.4 if isinstance(shape, Plane) else 0.2
    assert np.linalg.norm(sides, axis=1).sum() / 2 == pytest.approx(width * 0.03)
