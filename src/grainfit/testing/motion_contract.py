# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of programs that simulate scenes: walls that move, turn and press."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.errors import RunFailedError
from grainfit.scenes.conditions import Elapsed, Loaded
from grainfit.scenes.glued import Glued
from grainfit.scenes.records import Force, Recorded, Series, Travel
from grainfit.scenes.scene import Box, Load, Rotation, Stage, Velocity, Wall
from grainfit.scenes.shapes import Block, Cylinder, Disc, Plane, Shape
from grainfit.testing.simulated_scenes import (
    DAMPED,
    FLOOR,
    GRAVITY,
    MASS,
    RADIUS,
    WEIGHT,
    Run,
    SimulatedScenes,
    final_velocities,
    frames,
    material,
    means,
    resting_overlap,
    scene_of,
    settle,
    spheres,
)


class MotionContract(SimulatedScenes):
    """Motions of walls against closed forms."""

    def test_a_wall_moves_at_its_velocity_and_stays_where_it_was_left(self, run: Run) -> None:
        travel = Series({"way": Travel("floor")}, 0.002)
        up, down = Velocity("z", 0.05), Velocity("z", -0.02)
        stages = [
            Stage("lift", Elapsed(0.1), motions={"floor": up}, series=travel, snapshot="lifted"),
            Stage("hold", Elapsed(0.05), series=travel, snapshot="held"),
            Stage("lower", Elapsed(0.1), motions={"floor": down}, series=travel, snapshot="low"),
        ]
        scene = scene_of(spheres([(0, 0, RADIUS)]), FLOOR, stages, DAMPED)
        out = run(scene)

        ends = [0.0, *(end.time for end in out.stages)]
        ways = [0.05 * ends[1]] * 2 + [0.05 * ends[1] - 0.02 * (ends[3] - ends[2])]
        lift, hold, lower = (out.series(stage.name) for stage in stages)
        assert lift["way"] == pytest.approx(0.05 * lift["time"], abs=1e-9)
        assert hold["way"] == pytest.approx(ways[1], abs=1e-9)
        assert lower["way"] == pytest.approx(ways[1] - 0.02 * (lower["time"] - ends[2]), abs=1e-9)
        heights = [out.snapshot(stage.snapshot).positions[0, 2] for stage in stages]
        assert heights == pytest.approx([self.rests_at(DAMPED) + way for way in ways], abs=1e-5)

    @pytest.mark.parametrize("axis", ["x", "y"])
    def test_a_block_that_moves_sideways_pushes_a_particle(self, run: Run, axis: str) -> None:
        number, speed, restitution = "xyz".index(axis), 0.1, 0.3
        high = [0.02, 0.02, 0.02]
        high[number] = -RADIUS - 0.001
        walls = {**FLOOR, "ram": Wall(Block((-0.04, -0.04, 0.002), (high[0], high[1], high[2])))}
        stages = [
            Stage("push", Elapsed(0.05), motions={"ram": Velocity(axis, speed)}, snapshot="pushed"),
            Stage("more", Elapsed(0.02), snapshot="later"),
        ]
        rests = self.rests_at(DAMPED)
        scene = scene_of(spheres([(0, 0, rests)]), walls, stages, DAMPED)
        found = final_velocities(run(scene), scene)[0]

        expected = np.zeros(3)
        expected[number] = (1 + restitution) * speed
        assert found == pytest.approx(expected, abs=0.02 * speed)

    @pytest.mark.parametrize("axis", ["x", "y"])
    def test_a_particle_rests_in_a_tube_that_lies(self, run: Run, axis: str) -> None:
        radius, number = 0.05, "xyz".index(axis)
        low, high, place = [-0.1] * 3, [0.1] * 3, [0.0] * 3
        low[number], high[number], place[number] = 0.0, 0.03, 0.01
        box = Box((low[0], low[1], low[2]), (high[0], high[1], high[2]), periodic=axis)
        below, curve = self.tube_floor(radius)
        place[2] = RADIUS - below
        walls = {"drum": Wall(Cylinder(radius, 0.0, 0.03, axis))}
        hold = Stage("hold", Elapsed(0.1), snapshot="held")
        out = run(scene_of(spheres([place]), walls, [settle(), hold], DAMPED, box=box))

        # LIGGGHTS takes the tube for a plane there, LAMMPS for one of twice the radius.
        overlap = resting_overlap(DAMPED, curve=1 / (1 - RADIUS / curve))
        place[2] -= overlap
        assert out.snapshot("held").positions[0] == pytest.approx(place, abs=0.04 * overlap)

    @pytest.mark.parametrize("speed", [-10.0, 10.0])
    def test_a_turning_drum_drags_a_particle_up(self, run: Run, speed: float) -> None:
        # It slides all the time, so friction is constant: a pendulum that swings about its angle.
        radius, depth, friction, time = 0.05, 0.03, 0.2, 0.03
        box = Box((0.0, -0.1, -0.1), (depth, 0.1, 0.1), periodic="x")
        below, curve = self.tube_floor(radius)
        overlap = resting_overlap(DAMPED, curve=1 / (1 - RADIUS / curve))
        particle = spheres([(0.01, 0.0, RADIUS - below - overlap)])
        turn = Stage(
            "turn",
            Elapsed(time),
            motions={"drum": Rotation("x", speed)},
            series=Series({"angle": Travel("drum")}, 0.001),
            snapshot="dragged",
        )
        drum = {"drum": Wall(Cylinder(radius, 0.0, depth, "x"))}
        out = run(scene_of(particle, drum, [turn], material(0.3, friction), box=box))

        series = out.series("turn")
        moved = out.snapshot("dragged").positions[0] - particle.positions[0]
        length, time = curve - RADIUS, out.stages[0].time
        swing = GRAVITY * time**2 / 2
        if math.isfinite(length):
            swing = length * (1 - math.cos(math.sqrt(GRAVITY / length) * time))
        way = friction * swing
        # By the right-hand rule, the lowest point of the drum goes towards positive y.
        expected = [0.0, math.copysign(way, speed), way**2 / (2 * length)]
        assert moved == pytest.approx(expected, abs=0.01 * way + self.slide_kick * time)
        assert series["angle"] == pytest.approx(speed * series["time"], abs=1e-9)

    @pytest.mark.parametrize(
        "shape",
        [Plane("z", 0.0), Block((-0.06, -0.06, -0.02), (0.06, 0.06, 0.0)), Disc(0.06, 0.0)],
        ids=lambda shape: type(shape).__name__.lower(),
    )
    def test_a_floor_that_turns_drags_a_particle_along(self, run: Run, shape: Shape) -> None:
        # It slides all the time, away from the axis: friction is constant, along y.
        friction, time, centre = 0.2, 0.03, (0.01, 0.01, 0.0)
        values = material(0.3, friction)
        turn = {"table": Rotation("z", 20.0, centre)}
        stage = Stage("turn", Elapsed(time), motions=turn, snapshot="dragged")
        particle = spheres([(0.04, 0.01, self.rests_at(values))])
        out = run(scene_of(particle, {"table": Wall(shape)}, [stage], values))

        moved = out.snapshot("dragged").positions[0] - particle.positions[0]
        way = friction * GRAVITY * out.stages[0].time ** 2 / 2
        expected = [0.0, way, 0.0]
        assert moved == pytest.approx(expected, abs=0.01 * way + self.slide_kick * time)

    def test_a_wall_turns_and_stays_as_it_was_left(self, run: Run) -> None:
        # A particle that falls on the turned block rebounds from the slope.
        angle, drop, restitution, time = math.radians(20), 0.02, 0.6, 0.05
        through = (0.01, 0.0, -0.02)
        walls = {"block": Wall(Block((-0.06, -0.03, -0.03), (0.06, 0.03, 0.0)))}
        normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
        # The middle of the upper side, beside which the block stands still.
        arm = np.array([-through[0], 0.0, -through[2]])
        turned = np.array(
            [
                through[0] + math.cos(angle) * arm[0] + math.sin(angle) * arm[2],
                0.0,
                through[2] - math.sin(angle) * arm[0] + math.cos(angle) * arm[2],
            ]
        )
        fall = drop + GRAVITY * time**2 / 2
        start = turned + RADIUS * normal + np.array([0.0, 0.0, fall])
        turn = Rotation("y", angle / time, through)
        until = math.sqrt(2 * fall / GRAVITY) - time + 0.01
        stages = [
            Stage("turn", Elapsed(time), motions={"block": turn}),
            *frames(until),
            Stage("more", Elapsed(0.004), snapshot="later"),
        ]
        values = {**material(restitution), "particle.youngs_modulus": 1e8}
        scene = scene_of(spheres([start.tolist()]), walls, stages, values)
        out = run(scene)

        speed = math.sqrt(2 * GRAVITY * fall)
        after = np.array([0, 0, -speed]) + (1 + restitution) * speed * normal[2] * normal
        after[2] -= GRAVITY * (until + time + 0.002 - speed / GRAVITY)
        assert final_velocities(out, scene)[0] == pytest.approx(after, abs=0.02 * speed)

    def test_a_loaded_plane_presses_with_its_force(self, run: Run) -> None:
        load, travel = 5 * WEIGHT, 0.001
        top = 2 * RADIUS + travel
        walls = {**FLOOR, "piston": Wall(Plane("z", top, upwards=False))}
        stiffness = 1.5 * load / resting_overlap(DAMPED, load)
        piston = Load("z", -load, largest_speed=0.1, gain=1 / (stiffness * 0.02))
        columns: dict[str, Recorded] = {
            "floor": Force("floor", "z"),
            "piston": Force("piston", "z"),
            "way": Travel("piston"),
        }
        stages = [
            Stage("press", Loaded("piston", 0.002, 3.0), motions={"piston": piston}),
            Stage(
                "hold",
                Elapsed(0.02),
                motions={"piston": piston},
                series=Series(columns, 0.001),
                snapshot="held",
            ),
        ]
        out = run(scene_of(spheres([(0, 0, RADIUS)]), walls, stages, DAMPED))
        pressed, _ = out.require_complete(["press", "hold"], "press")

        below = resting_overlap(DAMPED, load + WEIGHT, self.wall_radius)
        above = resting_overlap(DAMPED, load, self.wall_radius)
        series = means(out, "hold")
        assert pressed.end == "done"
        assert series["piston"] == pytest.approx(load, rel=1e-2)
        assert series["floor"] == pytest.approx(-load - WEIGHT, rel=1e-2)
        assert RADIUS - out.snapshot("held").positions[0, 2] == pytest.approx(below, rel=1e-2)
        assert -series["way"] - travel == pytest.approx(below + above, rel=1e-2)

    def test_a_wall_that_has_moved_can_be_loaded(self, run: Run) -> None:
        walls = {**FLOOR, "piston": Wall(Plane("z", 0.03, upwards=False))}
        down = {"piston": Velocity("z", -0.1)}
        piston = Load("z", -5 * WEIGHT, 0.1, 0.1 / (5 * WEIGHT))
        travel = Series({"way": Travel("piston")}, 0.001)
        stages = [
            Stage("approach", Elapsed(0.1), motions=down, series=travel),
            Stage("press", Loaded("piston", 0.01, 3.0), motions={"piston": piston}, series=travel),
        ]
        out = run(scene_of(spheres([(0, 0, RADIUS)]), walls, stages, DAMPED))

        approach, pressed = out.series("approach"), out.series("press")
        assert approach["way"] == pytest.approx(-0.1 * approach["time"], abs=2e-5)
        assert out.stages[-1].end == "done"
        assert pressed["way"][0] == pytest.approx(approach["way"][-1], abs=3e-4)
        assert 0.03 + pressed["way"][-1] == pytest.approx(2 * RADIUS, abs=1e-3)

    def test_a_load_on_an_area_follows_the_distance_of_its_walls(self, run: Run) -> None:
        load, width, speed = 5 * WEIGHT, 0.06, 0.1
        walls = {
            **FLOOR,
            "left": Wall(Plane("x", -width / 2)),
            "right": Wall(Plane("x", width / 2, upwards=False)),
            "piston": Wall(Plane("z", 2 * RADIUS + 0.0005, upwards=False)),
        }
        gain = resting_overlap(DAMPED, load) / load / 0.005
        piston = Load("z", -load, 0.1, gain, across=(("left", "right"),))
        columns: dict[str, Recorded] = {"piston": Force("piston", "z"), "way": Travel("right")}
        series = Series(columns, 0.001)
        motions: dict[str, Load | Velocity] = {
            "piston": piston,
            "right": Velocity("x", speed),
        }
        pressed = Stage("press", Loaded("piston", 0.01, 3.0), motions={"piston": piston})
        wider = Stage("widen", Elapsed(0.3), motions=motions, series=series)
        again = Stage("again", Loaded("piston", 0.01, 3.0), motions={"piston": piston})
        held = Stage("held", Elapsed(0.01), motions={"piston": piston}, series=series)
        stages = [pressed, wider, again, held]
        out = run(scene_of(spheres([(0, 0, RADIUS)]), walls, stages, DAMPED))

        assert [end.end for end in out.stages] == ["done"] * 4
        found = out.series("widen")
        assert found["way"][-1] == pytest.approx(speed * 0.3, rel=0.02)
        expected = load * (1 + found["way"] / width)
        # The piston follows with a small lag.
        assert found["piston"] == pytest.approx(expected, rel=0.02)
        assert means(out, "held")["piston"] == pytest.approx(1.5 * load, rel=0.015)

    def test_a_stage_has_a_friction_of_its_own(self, run: Run) -> None:
        # A sphere between two others that move aside: friction alone drags it along.
        friction, time, speed, pull = 0.5, 0.001, 0.1, 50.0
        values = {**material(1.0, friction), "particle.youngs_modulus": 1e8}
        load = pull * MASS / (2 * friction)
        overlap = hertz_overlap(load, particle_moduli(values, "particle"), RADIUS / 2)
        reach = 2 * RADIUS - overlap
        places = np.array([[0.0, 0.0, -reach], [0.0, 0.0, reach]])
        jaws = {"jaws": Glued(places, np.zeros(2, dtype=np.int64))}
        forth, back = Velocity("y", speed), Velocity("y", -speed)
        stages = [
            Stage(
                "smooth",
                Elapsed(time),
                motions={"jaws": forth},
                snapshot="smooth",
                sliding_friction=0.0,
            ),
            Stage("rough", Elapsed(time), motions={"jaws": back}, snapshot="rough"),
            Stage(
                "less",
                Elapsed(time),
                motions={"jaws": back},
                snapshot="less",
                sliding_friction=0.0,
            ),
        ]
        scene = scene_of(spheres([(0, 0, 0)]), {}, stages, values, gravity=0.0, glued=jaws)
        out = run(scene)

        first, second, third = (out.snapshot(s.snapshot).positions[0, 1] for s in stages)
        way = -pull * time**2 / 2
        assert abs(first) < 0.05 * abs(way)
        assert second - first == pytest.approx(way, rel=0.08)
        # It goes on with its velocity.
        assert third - second == pytest.approx(2 * way, rel=0.08)

    def test_a_load_that_is_not_reached_fails_the_run(self, run: Run) -> None:
        walls = {**FLOOR, "piston": Wall(Plane("z", 0.08, upwards=False))}
        piston = Load("z", -WEIGHT, largest_speed=0.1, gain=1.0)
        press = Stage("press", Loaded("piston", 0.01, 0.1), motions={"piston": piston})
        out = run(scene_of(spheres([(0, 0, RADIUS)]), walls, [press], DAMPED))

        assert [end.end for end in out.stages] == ["unloaded"]
        with pytest.raises(RunFailedError, match="load was not reached"):
            out.require_complete(["press"], "pot")
