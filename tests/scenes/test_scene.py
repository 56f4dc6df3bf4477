"""Scenes as data: names, energies, concepts, and the triangles of walls."""

import math
from dataclasses import fields as dataclass_fields
from dataclasses import is_dataclass, replace
from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Rotated

from grainfit import scenes
from grainfit.errors import InputError
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes import conditions, messages, packing, records, scene, shapes
from grainfit.scenes.conditions import Clear, Elapsed, Loaded
from grainfit.scenes.glued import Glued
from grainfit.scenes.records import (
    Force,
    Frames,
    KineticEnergy,
    MassAbove,
    RadialForce,
    Series,
    Travel,
)
from grainfit.scenes.scene import Box, Load, Rotation, Stage, Velocity, Wall
from grainfit.scenes.scene_faults import scene_faults
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Plane, Prism
from grainfit.scenes.triangles import triangles_of
from grainfit.testing.simulated_scenes import MASS, RADIUS, WEIGHT, frames, scene_of, spheres
from grainfit.validation import SMALLEST

FLOOR = Wall(Plane("z", 0.0))
LIFT = Velocity("z", 1.0)
ONE = spheres([(0, 0, 0.1)])
PLATE = Glued(np.array([(0.0, 0.0, 0.2)]), np.array([0]))


@pytest.mark.parametrize("module", [conditions, packing, records, scene, shapes])
def test_all_names_of_a_scene_are_in_one_place(module):
    names = {
        name
        for name, found in vars(module).items()
        if is_dataclass(found) and found.__module__ == module.__name__
    }
    assert names
    assert names <= set(dir(scenes))


DRUM = Wall(Cylinder(0.1, -0.1, 0.1, "y"))
PRESS, PUSH = Load("z", -1.0, 0.1, 0.1), Load("x", 1.0, 0.1, 0.1)


def stage(until=None, name="go", **given):
    return Stage(name, until or Elapsed(1.0), **given)


def recorded(name, quantity):
    return stage(series=Series({name: quantity}, 0.1))


def turning(motion):
    return [stage(motions={"drum": Rotation("y", 1.0)}), stage(name="on", motions={"drum": motion})]


def no_wall(does, name, known):
    return messages.NO_WALL.fault("stage go", does=does, name=name, known=known)


@pytest.mark.parametrize(
    ("stages", "fault"),
    [
        ([stage(put={"front wall": FLOOR})], messages.NOT_A_WORD.fault("walls", name="front wall")),
        ([stage(name="fall down")], messages.NOT_A_WORD.fault("stages", name="fall down")),
        ([stage(snapshot="../x")], messages.NOT_A_WORD.fault("snapshots", name="../x")),
        ([recorded("a,b", KineticEnergy())], messages.NOT_A_WORD.fault("columns", name="a,b")),
        ([stage(put={"floor": FLOOR})], messages.NAME_TWICE.fault("walls", name="floor")),
        ([stage(put={"plate": FLOOR})], messages.NAME_TWICE.fault("walls", name="plate")),
        ([stage(), stage()], messages.NAME_TWICE.fault("stages", name="go")),
        (
            [stage(frames=Frames("end", 0.1), snapshot="end")],
            messages.NAME_TWICE.fault("snapshots", name="end"),
        ),
        ([stage(take_away=("door",))], no_wall("takes away", "door", "floor, drum")),
        ([stage(take_away=("plate",))], no_wall("takes away", "plate", "floor, drum")),
        ([stage(motions={"door": LIFT})], no_wall("moves", "door", "floor, drum, plate")),
        (
            [stage(take_away=("floor",), motions={"floor": LIFT})],
            no_wall("moves", "floor", "drum, plate"),
        ),
        ([recorded("f", Force("door", "z"))], no_wall("records", "door", "floor, drum, plate")),
        ([recorded("f", RadialForce("plate"))], no_wall("records", "plate", "floor, drum")),
        (
            [recorded("way", Travel("plate"))],
            messages.TRAVEL_WITHOUT_AXIS.fault("stage go", name="plate"),
        ),
        *(
            ([stage(Clear(wall, 1.0))], messages.NOT_CLEARED.fault("stage go", wall=wall))
            for wall in ("floor", "tube", "drum")
        ),
        (
            [stage(Loaded("floor", 0.1, 1.0))],
            messages.NOT_LOADED.fault("stage go", wall="floor"),
        ),
        (
            [stage(Loaded("plate", 0.1, 1.0), motions={"plate": LIFT})],
            messages.NOT_LOADED.fault("stage go", wall="plate"),
        ),
        (turning(Velocity("y", 0.1)), messages.TURNS_AND_MOVES.fault("drum")),
        (turning(Rotation("y", 1.0, (0.1, 0.0, 0.0))), messages.TURNS_AND_MOVES.fault("drum")),
        (turning(Rotation("y", 0.0)), messages.NO_TURN.fault("drum")),
        (
            [stage(motions={"floor": (LIFT, PUSH)})],
            messages.SEVERAL_MOTIONS.fault("stage go", name="floor", count=2),
        ),
        (
            [stage(motions={"plate": (LIFT, PRESS)})],
            messages.MOVED_TWICE.fault("stage go", name="plate"),
        ),
        (
            [stage(motions={"plate": (PRESS, PUSH)})],
            messages.TWO_LOADS.fault("stage go", name="plate"),
        ),
    ],
)
def test_a_stage_that_a_deck_would_misread_is_refused(stages, fault):
    with pytest.raises(InputError) as caught:
        scene_of(ONE, {"floor": FLOOR, "drum": DRUM}, stages, glued={"plate": PLATE})
    assert caught.value.faults == (fault,)


def test_the_name_of_a_surface_is_one_word():
    stage = Stage("fall", Elapsed(1.0))
    with pytest.raises(InputError, match=messages.NOT_A_WORD.pattern):
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
    assert fault == messages.TAKEN_NAME.fault(key, name=name)


def test_a_drum_is_a_lying_cylinder_that_rotates():
    turned = scene_of(ONE, {"drum": DRUM}, [stage(motions={"drum": Rotation("y", 1.0)})])
    assert turned.concepts() == {"cylinder", "lying cylinder", "rotation"}


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


def test_glued_particles_need_a_size_each():
    for count, sizes in ((2, 1), (0, 0)):
        with pytest.raises(ValueError, match=messages.GLUED_COUNT.pattern):
            Glued(np.zeros((count, 3)), np.zeros(sizes, dtype=int))


def test_glued_sets_add_their_work_and_no_mass():
    still = scene_of(ONE, {}, frames(0.1), gravity=0.0)
    stage = Stage("go", Elapsed(1.0), motions={"plate": (replace(LIFT, along="x"), PRESS)})
    moved = scene_of(ONE, {}, [stage], gravity=0.0, glued={"plate": PLATE})
    assert still.energy_limit == 0.0
    assert moved.mass == still.mass
    # A load of 1 N across 0.3 m, and the particle at three times 1 m/s.
    assert moved.energy_limit == pytest.approx(0.3 + 9 * MASS / 2)
    assert moved.concepts() == {"velocity", "load", "glued"}


def test_a_scene_and_its_particles_show_themselves_in_a_line():
    shown = [repr(part) for part in (scene_of(ONE, {}, frames(0.1)), ONE, PLATE)]
    assert all(text.startswith("<") and "1 particles" in text for text in shown)
    assert all("\n" not in text and len(text) < 100 for text in shown)


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


@pytest.mark.parametrize("shift", [-0.28, 0.04])
def test_triangles_of_a_prism_are_shorter_than_the_period_and_close_its_section(shift):
    box = Box((-0.2, 0.0, -0.2), (0.2, 0.03, 0.2), periodic="y")
    low, high, depth = (-0.05, 0.0, 0.0), (0.05, 1.0, 0.05), 0.03
    triangles = triangles_of(Prism(low, high, shift), box, 0.01)
    edges = triangles - np.roll(triangles, 1, axis=1)
    assert np.linalg.norm(edges, axis=2).max() < depth
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    outline = 2 * 0.1 + 2 * math.hypot(0.05, shift)
    assert np.linalg.norm(sides, axis=1).sum() / 2 == pytest.approx(outline * depth)
    top = triangles[triangles[:, :, 2] == 0.05]
    assert (top[:, 0].min(), top[:, 0].max()) == pytest.approx((shift - 0.05, shift + 0.05))


@pytest.mark.parametrize("axes", ["x", "xy", "z"])
def test_a_slope_that_does_not_repeat_is_refused(axes):
    slope = Wall(Prism((0.0, 0.0, 0.0), (0.1, 0.1, 0.1), 0.1))
    box = Box((-0.2, -0.2, -0.2), (0.2, 0.2, 0.2), axes)
    faults = scene_faults(scene_of(ONE, {"slope": slope}, frames(0.1), box=box))
    assert messages.PRISM_PERIOD.fault("wall slope", axes=axes) in faults


def test_a_load_on_an_area_needs_two_parallel_planes_in_their_order():
    walls = {
        "left": Wall(Plane("x", -0.1)),
        "right": Wall(Plane("x", 0.1, upwards=False)),
        "floor": FLOOR,
        "tube": Wall(Cylinder(0.1, -0.1, 0.1)),
    }

    def loaded(*pair):
        load = Load("z", 1.0, 0.1, 0.1, across=(pair,))
        press = Stage("press", Elapsed(0.1), motions={"floor": load}, sliding_friction=0.0)
        return scene_of(ONE, walls, [press])

    right = loaded("left", "right")
    assert right.first_distance("left", "right") == pytest.approx(0.2)
    assert right.concepts() >= {"load", "load on an area", "friction of a stage"}
    for pair in (("right", "left"), ("left", "floor"), ("left", "tube"), ("left", "nothing")):
        with pytest.raises(InputError, match=messages.NO_AREA.pattern):
            loaded(*pair)


def test_a_servo_is_no_fault_of_a_scene():
    pressed = stage(Loaded("lid", 0.02, 3.0), motions={"lid": replace(PRESS, across=(("a", "b"),))})
    walls = {
        "floor": FLOOR,
        "lid": Wall(Plane("z", 0.3, upwards=False)),
        "a": Wall(Plane("x", -0.3)),
        "b": Wall(Plane("x", 0.3, upwards=False)),
    }

    assert scene_faults(replace(scene_of(ONE, walls, frames(0.1)), stages=(pressed,))) == ()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"particle_wall.sliding_frction": 0.9}, messages.SURFACE_PARAMETER),
        ({"sliding_friction": 0.9}, messages.SURFACE_PARAMETER),
        ({"particle_wall.sliding_friction": math.nan}, messages.SURFACE_VALUE),
    ],
)
def test_a_surface_has_parameters_of_walls_alone(values, message):
    plain = scene_of(
        ONE, {"floor": Wall(FLOOR.shape, "rough")}, frames(0.1), surfaces={"rough": {}}
    )

    [fault] = scene_faults(replace(plain, surfaces={"rough": values}))

    assert message.is_in(str(fault), name=next(iter(values)))


def test_a_first_look_is_at_a_time():
    looked = stage(conditions.AtRest(3.0, math.nan))
    [fault] = scene_faults(replace(scene_of(ONE, {"floor": FLOOR}, frames(0.1)), stages=(looked,)))

    assert messages.NO_FIRST_LOOK.is_in(str(fault))


@pytest.mark.parametrize(
    ("shape", "good", "bad"),
    [
        (Plane("z", 0.0), (0, 0, RADIUS), (0, 0, -0.05)),
        (Plane("z", 0.0, upwards=False), (0, 0, -RADIUS), (0, 0, 0.9 * RADIUS)),
        (Block((-0.1, -0.1, -0.1), (0.1, 0.1, 0.0)), (0, 0, RADIUS), (0, 0, -0.05)),
        # Beside an edge, a radius away from neither face.
        (Block((-0.1, -0.1, -0.1), (0.0, 0.1, 0.0)), (0.004, 0, 0.004), (0.003, 0, 0.003)),
        (Prism((-0.02, -0.1, 0.0), (0.0, 0.1, 0.04), 0.04), (0.0, 0, 0.035), (0.0, 0, 0.01)),
        (Cylinder(0.05, 0.0, 0.1), (0.045, 0, 0.05), (0.05, 0, 0.05)),
        (Cylinder(0.05, -0.05, 0.05, "x"), (0.0, 0, 0.056), (0.0, 0, 0.051)),
        (Cone(0.01, 0.05, 0.0, 0.04), (0.0, 0, 0.02), (0.03, 0, 0.02)),
        (Disc(0.05, 0.0), (0.056, 0, 0.0), (0.052, 0, 0.0)),
        (Annulus(0.02, 0.05, 0.0), (0.0, 0, 0.0), (0.03, 0, 0.002)),
    ],
)
@pytest.mark.parametrize("is_put", [True, False])
def test_particles_begin_on_the_right_side_of_a_wall(shape, good, bad, is_put):
    wall = {"wall": Wall(shape)}

    def faults(place):
        begin = stage(put=wall if is_put else {})
        return scene_faults(scene_of(spheres([place]), {} if is_put else wall, [begin]))

    assert faults(good) == ()
    [fault] = faults(bad)
    assert fault.key == "wall wall"
    assert messages.IN_WALL.is_in(str(fault), caught=1, count=1, first=list(map(float, bad)))


def test_a_block_goes_on_through_a_period_and_a_wall_taken_away_at_first_holds_nothing():
    block = {"block": Wall(Block((-0.1, 0.5, -0.1), (0.1, 0.6, 0.0)))}
    inside, box = spheres([(0, 0, -0.05)]), replace(scene_of(ONE, {}, []).box, periodic="y")

    assert scene_faults(scene_of(inside, block, frames(0.1))) == ()
    assert scene_faults(scene_of(inside, block, frames(0.1), box=box))
    gone = [stage(take_away=("block",))]
    assert scene_faults(scene_of(inside, block, gone, box=box)) == ()


def test_a_sphere_of_a_clump_counts_as_its_particle():
    sizes = ParticleSizes((2 * RADIUS,), shape=ParticleShape("two_spheres", aspect_ratio=1.5))
    scene = scene_of(spheres([(0, 0, RADIUS)]), {"floor": FLOOR}, frames(0.1), sizes=sizes)

    def standing_along(axis):
        turn, _ = Rotated.align_vectors([axis], [scene.clumps.clump.positions[0]])
        return replace(scene.particles, orientations=turn.as_quat()[None])

    assert scene_faults(replace(scene, particles=standing_along((1, 0, 0)))) == ()
    [fault] = scene_faults(replace(scene, particles=standing_along((0, 0, 1))))
    assert messages.IN_WALL.is_in(str(fault), caught=1, count=1)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_wall_that_does_not_repeat_with_its_box_is_refused(axis):
    box = replace(scene_of(ONE, {}, []).box, periodic=axis)
    lying = "y" if axis == "x" else "x"

    def faults(shape):
        return scene_faults(scene_of(ONE, {"wall": Wall(shape)}, frames(0.1), box=box))

    across, beyond = messages.ACROSS_PERIOD, messages.BEYOND_PERIOD
    assert faults(Plane(axis, -0.05)) == (across.fault("wall wall", axis=axis),)
    assert faults(Cylinder(0.21, -0.1, 0.1, lying)) == (beyond.fault("wall wall", axis=axis),)
    assert faults(Cylinder(0.05, -0.01, 0.01, lying)) == ()
    assert faults(Cylinder(0.05, -5.0, 5.0, axis)) == ()
    assert bool(faults(Disc(0.15, 0.0))) is bool(faults(Annulus(0.05, 0.15, 0.0))) is (axis != "z")
    assert bool(faults(Cone(0.02, 0.05, -0.5, -0.05))) is (axis == "z")


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("shape", [None, ParticleShape("two_spheres", aspect_ratio=1.5)])
def test_particles_overlap_across_a_periodic_side(axis, shape):
    sizes = ParticleSizes((2 * RADIUS,), shape=shape)
    box = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1))
    places = np.zeros((2, 3))
    places[:, "xyz".index(axis)] = (-0.098, 0.098)
    both = scene_of(spheres(places), {}, frames(0.1), box=box, sizes=sizes)

    assert messages.OVERLAPS.fault("particles", pairs=1) not in scene_faults(both)
    [fault] = scene_faults(replace(both, box=replace(box, periodic="xyz")))
    assert messages.OVERLAPS.is_in(str(fault), pairs=1)


def full_scene():
    """A scene with every kind of part that has a number."""
    walls = {
        "floor": Plane("z", 0.0),
        "lid": Plane("z", 0.19, upwards=False),
        "tube": Cylinder(0.09, -0.05, 0.19),
        "block": Block((-0.09, -0.09, -0.05), (0.09, 0.09, -0.01)),
        "slope": Prism((-0.09, -0.09, -0.05), (-0.05, 0.09, -0.01), 0.01),
        "funnel": Cone(0.01, 0.02, -0.05, -0.02),
        "plate": Disc(0.05, -0.01),
        "ring": Annulus(0.01, 0.05, -0.01),
    }
    columns = {"held": MassAbove(0.1), "force": Force("floor", "z"), "way": Travel("lid", "z")}
    stages = [
        stage(
            conditions.AtRest(1.0, 0.1),
            strike_off=0.3,
            sliding_friction=0.5,
            motions={"lid": Velocity("z", -0.1), "plate": Rotation("z", 1.0)},
            series=Series(columns, 0.1),
            frames=Frames("film", 0.1),
        ),
        stage(Loaded("lid", 0.02, 3.0), "press", motions={"lid": Load("z", -1.0, 0.1, 0.01)}),
        stage(conditions.Drained(0.05, 0.5, 1.0, 0.1), "flow"),
        stage(Elapsed(1.0), "wait"),
        stage(Clear("tube", 1.0), "lift"),
    ]
    walls = {name: Wall(shape) for name, shape in walls.items()}
    return scene_of(ONE, walls, stages, film_interval=0.1)


def numbers_of(part, path, put_back):
    """Yield each number of a part of a scene, and how to make the scene with another one."""
    if isinstance(part, float):
        yield path, put_back
    elif is_dataclass(part) and not isinstance(part, ParticleSizes):
        for field in dataclass_fields(part):
            at, name = f"{path} {type(part).__name__}.{field.name}", field.name
            changed = partial(lambda name, new: put_back(replace(part, **{name: new})), name)
            yield from numbers_of(getattr(part, name), at, changed)
    elif isinstance(part, tuple | dict):
        entries = dict(enumerate(part)) if isinstance(part, tuple) else part
        for key, entry in entries.items():
            changed = partial(
                lambda key, new: (
                    put_back(type(part)({**entries, key: new}.values()))
                    if isinstance(part, tuple)
                    else put_back({**part, key: new})
                ),
                key,
            )
            yield from numbers_of(entry, f"{path} {key}", changed)


NUMBERS = dict(numbers_of(full_scene(), "", lambda scene: scene))
OF_NO_SCENE = {"Round", "Rectangle", "Square", "PeriodicRectangle", "Mesh"}


@pytest.mark.parametrize("place", NUMBERS)
def test_each_number_of_a_scene_is_a_number(place):
    assert scene_faults(full_scene()) == ()
    for wrong in (math.nan, math.inf, -math.inf, True, "1"):
        assert len(scene_faults(NUMBERS[place](wrong))) == 1, wrong


def test_the_numbers_of_all_parts_of_a_scene_are_looked_at():
    parts = {
        name
        for name in set(dir(scenes)) - OF_NO_SCENE
        if is_dataclass(part := getattr(scenes, name))
        and any("float" in field.type.split("[")[0] for field in dataclass_fields(part))
    }
    assert parts
    assert {name for name in parts if not any(f" {name}." in place for place in NUMBERS)} == set()


@pytest.mark.parametrize(
    ("name", "least"),
    [
        *((name, 0.0) for name in ("Stage.sliding_friction", "lower_radius", "upper_radius")),
        *((name, SMALLEST) for name in ("within", "largest_speed", "gain", "film_interval")),
    ],
)
def test_some_numbers_of_a_scene_are_not_negative(name, least):
    [with_value] = [make for place, make in NUMBERS.items() if place.endswith(name)]

    assert scene_faults(with_value(least)) == ()
    [fault] = scene_faults(with_value(-1.0))
    assert "-1.0" in str(fault)
    assert bool(scene_faults(with_value(0.0))) is (least > 0)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"box": Box((0, 0), (1, 1, 1))}, messages.BOX_CORNERS),
        ({"walls": {"block": Wall(Block((0, 0), (1, 1, 1)))}}, messages.NO_NUMBERS),
        ({"walls": {"plane": Wall(Plane("z", (0, 0, 0)))}}, messages.NO_NUMBERS),
        (
            {
                "walls": {"floor": FLOOR},
                "stages": (stage(motions={"floor": Rotation("x", 1.0, (0, 0))}),),
            },
            messages.MOTION_NUMBERS,
        ),
        (
            {"walls": {"floor": FLOOR}, "stages": (recorded("way", Travel("floor", "w")),)},
            messages.RECORD_AXIS,
        ),
    ],
)
def test_a_vector_has_three_components_and_a_record_an_axis(changed, message):
    [fault] = scene_faults(replace(scene_of(ONE, {}, frames(0.1)), **changed))

    assert message.is_in(str(fault))
