# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of programs that simulate glued sets, as tests to inherit: closed forms.

Use it like `grainfit.testing.scene_contract.SceneContract`::

    class TestMyProgram(SceneContract, GluedContract):
        @pytest.fixture
        def solver(self):
            return MyProgram(Heap(diameter="10 mm"), {})
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import read_frames
from grainfit.scenes.conditions import AtRest, Elapsed, Loaded
from grainfit.scenes.film import FILM, Film
from grainfit.scenes.glued import Glued
from grainfit.scenes.records import (
    Force,
    Frames,
    KineticEnergy,
    MassAbove,
    Recorded,
    Series,
    Travel,
)
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Box, Load, Rotation, Stage, Velocity, Wall, time_step
from grainfit.scenes.shapes import Plane
from grainfit.testing.simulated_scenes import (
    DAMPED,
    ELASTIC,
    FLOOR,
    GRAVITY,
    MASS,
    RADIUS,
    STIFF,
    WEIGHT,
    Run,
    SimulatedScenes,
    final_velocities,
    frames,
    material,
    means,
    scene_of,
    settle,
    spheres,
)

#: Square that particles glued at its corners make a nest for another one, m.
_NEST = 0.012
_SINE = math.sqrt(1 - (_NEST / math.sqrt(2) / (2 * RADIUS)) ** 2)


def glued(positions: Sequence[Sequence[float]]) -> Glued:
    """Return equal particles glued together at these positions."""
    return Glued(np.array(positions, dtype=float), np.zeros(len(positions), dtype=np.int64))


def nest(height: float) -> Glued:
    """Return four particles that carry a fifth one above or below their middle."""
    half = _NEST / 2
    return glued([(x, y, height) for x in (-half, half) for y in (-half, half)])


class GluedContract(SimulatedScenes):
    """Glued sets against closed forms; subclasses define the program."""

    def test_a_particle_rests_on_a_glued_set_with_its_weight(self, run: Run) -> None:
        columns: dict[str, Recorded] = {
            "down": Force("nest", "z"),
            "side": Force("nest", "x"),
            "energy": KineticEnergy(),
            "above": MassAbove(-0.01),
        }
        hold = Stage("hold", Elapsed(0.1), series=Series(columns, 0.001), snapshot="held")
        stages = [settle(), hold]
        body, start = nest(0.0), 2 * RADIUS * _SINE
        scene = scene_of(spheres([(0, 0, start)]), {}, stages, DAMPED, glued={"nest": body})
        out = run(scene)
        out.require_complete(["settle", "hold"], "nest")

        series = means(out, "hold")
        assert series["down"] == pytest.approx(-WEIGHT, rel=1e-3)
        assert series["side"] == pytest.approx(0, abs=1e-3 * WEIGHT)
        # That of the last oscillations, far below that of a glued particle which falls.
        assert series["energy"] < 100 * scene.energy_at_rest
        assert series["above"] == pytest.approx(MASS, rel=1e-5)
        assert out.snapshot("rest").positions.shape == (1, 3)
        assert out.stages[0].particles == 1
        moduli = particle_moduli(DAMPED, "particle")
        height = start
        for _ in range(10):
            # As it sinks, the contacts lie flatter.
            force = WEIGHT / 4 * math.hypot(1.0, _NEST / math.sqrt(2) / height)
            distance = 2 * RADIUS - hertz_overlap(force, moduli, RADIUS / 2)
            height = math.sqrt(distance**2 - _NEST**2 / 2)
        sunk = start - out.snapshot("held").positions[0, 2]
        assert sunk == pytest.approx(start - height, rel=2e-3)

    def test_a_glued_set_without_a_motion_stands_still_and_is_told_from_loose_particles(
        self, run: Run
    ) -> None:
        sizes = ParticleSizes((2 * RADIUS, RADIUS), (0.5, 0.5))
        # Glued particles overlap each other, a wall and the other set: they feel none of them.
        one = Glued(np.array([(0, 0, 0.001), (0.003, 0, 0.0)]), np.array([0, 1]))
        other = Glued(np.array([(0, 0.004, 0.0)]), np.array([1]))
        columns: dict[str, Recorded] = {"floor": Force("floor", "z"), "one": Force("one", "z")}
        stages = frames(0.05, 2, Series(columns, 0.005))
        particles = replace(
            spheres([(0.05, 0, 0.03), (-0.05, 0, 0.05)], [(0, 0, 0), (0.1, 0, 0)]),
            size_indices=np.array([1, 0]),
        )
        scene = scene_of(particles, FLOOR, stages, sizes=sizes, glued={"one": one, "other": other})
        out = run(scene)

        for frame in ("frame1", "frame2"):
            for number, body in enumerate((one, other), 1):
                found = out.snapshot(frame, glued=number)
                assert found.positions == pytest.approx(body.positions, abs=1e-9)
                expected = np.array(sizes.diameters)[body.size_indices] / 2
                assert found.radii == pytest.approx(expected)
            assert out.snapshot(frame).radii == pytest.approx([RADIUS / 2, RADIUS])
        assert [end.particles for end in out.stages] == [2, 2]
        assert out.series("part2")["one"] == pytest.approx(0, abs=1e-12)
        assert out.series("part1")["floor"] == pytest.approx(0, abs=1e-12)
        fallen = GRAVITY * out.stages[0].time ** 2 / 2
        assert out.snapshot("frame1").positions[:, 2] == pytest.approx(
            [0.03 - fallen, 0.05 - fallen], abs=1e-6
        )

    def test_a_moving_glued_set_moves_exactly_so_through_a_periodic_box(self, run: Run) -> None:
        period, speed, rise = 0.04, 1.3, 0.2
        box = Box((0.0, -0.1, -0.1), (period, 0.1, 0.1), periodic="x")
        both = {"ram": (Velocity("x", speed), Velocity("z", rise))}
        columns: dict[str, Recorded] = {
            "x": Travel("ram", "x"),
            "z": Travel("ram", "z"),
            "energy": KineticEnergy(),
        }
        travel = Series(columns, 0.002)
        stages = [
            Stage("go", Elapsed(0.1), motions=both, series=travel, snapshot="gone"),
            Stage("stop", Elapsed(0.05), series=travel, snapshot="stopped"),
            Stage("back", Elapsed(0.02), motions={"ram": Velocity("x", -speed)}, snapshot="back"),
        ]
        body = glued([(0.01, 0, 0), (0.019, 0.001, 0.002)])
        particles = spheres([(0.02, 0.05, 0.0)])
        scene = scene_of(particles, {}, stages, box=box, gravity=0.0, glued={"ram": body})
        out = run(scene)
        out.require_complete(["go", "stop", "back"], "box")

        first, second, third = (end.time for end in out.stages)
        ways = [speed * first, speed * first, speed * (first - third + second)]
        for stage, way in zip(stages, ways, strict=True):
            found = out.snapshot(stage.snapshot, glued=1).positions
            x = (found[:, 0] - body.positions[:, 0] - way + period / 2) % period - period / 2
            assert x == pytest.approx(0, abs=1e-7)
            assert found[:, 1:] == pytest.approx(
                body.positions[:, 1:] + [0, rise * first], abs=1e-7
            )
        go, stop = out.series("go"), out.series("stop")
        assert go["x"] == pytest.approx(speed * go["time"], abs=1e-9)
        assert go["z"] == pytest.approx(rise * go["time"], abs=1e-9)
        assert stop["x"] == pytest.approx(speed * first, abs=1e-9)
        assert go["energy"] == pytest.approx(0, abs=1e-15)
        # Without gravity a loose particle stays where it is.
        assert out.snapshot("back").positions[0] == pytest.approx([0.02, 0.05, 0], abs=1e-12)

    def test_film_and_frames_show_glued_particles_where_they_are(self, run: Run) -> None:
        speed, body = 0.2, glued([(0.01, 0, 0), (0.019, 0.001, 0.002)])
        motions = {"ram": Velocity("x", speed)}
        stages = [Stage("go", Elapsed(0.05), motions=motions, frames=Frames("going", 0.01))]
        scene = scene_of(spheres([(0, 0.05, 0)]), {}, stages, glued={"ram": body})
        out = run(replace(scene, film_interval=0.01))

        film = Film(out.folder / FILM)
        assert len(film.steps) >= 5
        for shown in film.read(range(len(film.steps))):
            way = [speed * shown.step * scene.time_step, 0, 0]
            assert shown.glued.tolist() == [0, 1, 1]
            assert shown.positions[1:] == pytest.approx(body.positions + way, abs=1e-6)
        frames_of_set = [*read_frames(out.path_of(snapshot_file("going")), glued=1)]
        assert len(frames_of_set) >= 5
        for frame in frames_of_set:
            way = [speed * frame.step * scene.time_step, 0, 0]
            assert frame.particles.positions == pytest.approx(body.positions + way, abs=1e-6)

    def test_an_elastic_particle_leaves_a_moving_glued_set_at_twice_its_speed(
        self, run: Run
    ) -> None:
        speed = 0.2
        push = {"ram": Velocity("x", speed)}
        stages = [
            Stage("push", Elapsed(0.05), motions=push, snapshot="pushed"),
            Stage("more", Elapsed(0.02), motions=push, snapshot="later"),
        ]
        scene = scene_of(
            spheres([(2 * RADIUS + 0.001, 0, 0)]),
            {},
            stages,
            ELASTIC,
            gravity=0.0,
            glued={"ram": glued([(0, 0, 0)])},
        )
        out = run(scene)
        out.require_complete(["push", "more"], "box")

        assert final_velocities(out, scene)[0] == pytest.approx([2 * speed, 0, 0], abs=2e-3 * speed)

    def test_a_glued_set_that_moves_along_drags_by_friction(self, run: Run) -> None:
        # Pressed between a set that stands and one that moves, a sphere rolls at half the speed:
        # it sees the velocity of the glued particles, and not only their positions.
        speed, load = 0.01, 50 * WEIGHT
        values = {**material(0.3, 0.8), "particle.youngs_modulus": 1e8}
        top = 4 * RADIUS
        rows = {
            name: glued([(x, 0.0, z) for x in np.arange(-0.03, 0.03, 0.0005)])
            for name, z in (("lower", 0.0), ("upper", top))
        }
        stiffness = 1.5 * load / hertz_overlap(load, particle_moduli(values, "particle"), RADIUS)
        press = Load("z", -load, largest_speed=0.05, gain=1 / (stiffness * 0.002))
        roll = {"upper": (Velocity("x", speed), press)}
        stages = [
            Stage("press", Elapsed(0.02), motions={"upper": press}, snapshot="pressed"),
            Stage("spin", Elapsed(0.2), motions=roll, snapshot="spun"),
            Stage("roll", Elapsed(0.2), motions=roll, snapshot="rolled"),
            Stage("stop", Elapsed(0.1), snapshot="stopped"),
            Stage("stand", Elapsed(0.1), snapshot="stood"),
        ]
        scene = scene_of(
            spheres([(0, 0, 2 * RADIUS)]),
            {},
            stages,
            values,
            gravity=0.0,
            glued=rows,
            time_step=time_step(ParticleSizes((2 * RADIUS,)), values, 0.1),
        )
        out = run(scene)
        out.require_complete([stage.name for stage in stages], "box")

        rolling = replace(scene, stages=scene.stages[:3])
        assert final_velocities(out, rolling)[0, 0] == pytest.approx(speed / 2, rel=0.03)
        # A set that has stopped has no velocity either.
        assert final_velocities(out, scene)[0, 0] == pytest.approx(0, abs=0.01 * speed)

    def test_a_glued_set_under_a_load_presses_with_that_load(self, run: Run) -> None:
        load = 40 * WEIGHT
        gap = 2 * RADIUS * _SINE
        body = {"lower": nest(0.0), "upper": nest(2 * gap + 0.0005)}
        stiffness = load / 0.0001
        piston = Load("z", -load, largest_speed=0.05, gain=1 / (stiffness * 0.005))
        columns: dict[str, Recorded] = {
            "lower": Force("lower", "z"),
            "upper": Force("upper", "z"),
            "way": Travel("upper", "z"),
        }
        motions = {"upper": piston}
        stages = [
            Stage("press", Loaded("upper", 0.002, 3.0), motions=motions),
            Stage(
                "hold",
                Elapsed(0.02),
                motions=motions,
                series=Series(columns, 0.001),
                snapshot="held",
            ),
        ]
        values = {**DAMPED, "particle.youngs_modulus": 1e8}
        scene = scene_of(
            spheres([(0, 0, gap)]), {}, stages, values, gravity=0.0, glued=body, quiet_speed=1e-4
        )
        out = run(scene)
        pressed, _ = out.require_complete(["press", "hold"], "press")

        series = means(out, "hold")
        assert pressed.end == "done"
        assert series["upper"] == pytest.approx(load, rel=3e-3)
        assert series["lower"] == pytest.approx(-load, rel=3e-3)
        overlap = hertz_overlap(load / (4 * _SINE), particle_moduli(values, "particle"), RADIUS / 2)
        height = math.sqrt((2 * RADIUS - overlap) ** 2 - _NEST**2 / 2)
        found = out.snapshot("held").positions[0, 2]
        assert gap - found == pytest.approx(gap - height, rel=0.02)
        plate = out.snapshot("held", glued=2).positions[:, 2]
        assert plate == pytest.approx([2 * height] * 4, abs=0.02 * (gap - height))
        assert series["way"] == pytest.approx(2 * (height - gap) - 0.0005, rel=2e-3)

    def test_a_load_moves_no_faster_than_its_speed_beside_a_velocity(self, run: Run) -> None:
        largest, sideways = 0.05, 0.3
        motions = {"plate": (Velocity("y", sideways), Load("z", -1.0, largest, gain=10.0))}
        recorded = Series({"z": Travel("plate", "z"), "y": Travel("plate", "y")}, 0.001)
        stages = [
            Stage("one", Elapsed(0.05), motions=motions, series=recorded, snapshot="first"),
            Stage("two", Elapsed(0.05), motions=motions, series=recorded, snapshot="second"),
        ]
        body = {"plate": glued([(0, 0, 0.0), (0.01, 0, 0.0)])}
        scene = scene_of(spheres([(0, 0, 0.08)]), {}, stages, gravity=0.0, glued=body)
        out = run(scene)

        for stage in stages:
            series, end = out.series(stage.name), out.snapshot(stage.snapshot, glued=1)
            time = next(end.time for end in out.stages if end.name == stage.name)
            assert series["z"] == pytest.approx(-largest * series["time"], rel=0.01, abs=1e-5)
            assert series["y"] == pytest.approx(sideways * series["time"], abs=1e-9)
            assert end.positions[:, 2] == pytest.approx(-largest * time, rel=0.01)
            assert end.positions[:, 1] == pytest.approx(sideways * time, abs=1e-7)

    def test_no_glued_particle_touches_a_wall_that_moves_or_is_struck_off(self, run: Run) -> None:
        walls = {"lid": Wall(Plane("z", 0.02, upwards=False))}
        body = {"plate": glued([(0, 0, 0.03), (0.01, 0, 0.018)])}
        stages = [
            Stage("cut", Elapsed(0.01), strike_off=0.025, snapshot="cut"),
            Stage("rest", AtRest(1.0), snapshot="rest"),
        ]
        columns: dict[str, Recorded] = {"lid": Force("lid", "z")}
        stages[0] = replace(stages[0], series=Series(columns, 0.001))
        particles = spheres([(0.05, 0, 0.03), (-0.05, 0, RADIUS)])
        scene = scene_of(particles, {**walls, **FLOOR}, stages, DAMPED, glued=body)
        out: RunOutput = run(scene)
        out.require_complete(["cut", "rest"], "box")

        assert len(out.snapshot("rest", glued=1)) == 2
        assert out.series("cut")["lid"] == pytest.approx(0, abs=1e-12)
        assert [end.particles for end in out.stages] == [1, 1]

    def test_elastic_energy_of_a_stiff_nest_is_kept(self, run: Run) -> None:
        drop = 0.002
        start = 2 * RADIUS * _SINE + drop
        scene = scene_of(
            spheres([(0, 0, start)]), {}, frames(0.1, 2), STIFF, glued={"nest": nest(0.0)}
        )
        out = run(scene)
        out.require_complete(["part1", "part2"], "nest")

        end = out.stages[-1]
        rise = out.snapshot("frame2").positions[0, 2] - (start - drop)
        speeds = final_velocities(out, scene)
        assert speeds[0, :2] == pytest.approx(0, abs=1e-3)
        assert end.kinetic_energy + WEIGHT * rise == pytest.approx(WEIGHT * drop, rel=0.05)

    @pytest.mark.parametrize("speed", [-8.0, 8.0])
    def test_a_glued_set_turns_exactly_and_stays_as_it_was_left(
        self, run: Run, speed: float
    ) -> None:
        through = (0.0, 0.01, 0.02)
        body = glued([(0.0, 0.03, 0.02), (0.01, 0.01, -0.02), (0.02, -0.01, 0.05)])
        turn = Stage(
            "turn",
            Elapsed(0.05),
            motions={"vane": Rotation("x", speed, through)},
            series=Series({"angle": Travel("vane", "x")}, 0.001),
            snapshot="turned",
        )
        stages = [turn, *frames(0.02)]
        box = Box((0.0, -0.1, -0.1), (0.03, 0.1, 0.2), periodic="x")
        particle = spheres([(0.01, 0.0, 0.15)])
        out = run(scene_of(particle, {}, stages, box=box, glued={"vane": body}))

        series, angle = out.series("turn"), speed * out.stages[0].time
        assert series["angle"] == pytest.approx(speed * series["time"], abs=1e-9)
        arm = body.positions - np.array(through)
        turned = arm.copy()
        turned[:, 1] = arm[:, 1] * math.cos(angle) - arm[:, 2] * math.sin(angle)
        turned[:, 2] = arm[:, 1] * math.sin(angle) + arm[:, 2] * math.cos(angle)
        for frame in ("turned", "frame1"):
            found = out.snapshot(frame, glued=1).positions
            assert found == pytest.approx(turned + np.array(through), abs=1e-7)

    @pytest.mark.parametrize("speed", [-60.0, 60.0])
    def test_a_glued_particle_that_spins_drags_another(self, run: Run, speed: float) -> None:
        # It slides all the time, so friction is constant: an inverted pendulum.
        friction, values = 0.2, material(0.3, 0.2)
        overlap = hertz_overlap(WEIGHT, particle_moduli(values, "particle"), RADIUS / 2)
        length = 2 * RADIUS - overlap
        turn = {"ball": Rotation("x", speed)}
        spin = Stage("spin", Elapsed(0.02), motions=turn, snapshot="dragged")
        particle, ball = spheres([(0.0, 0.0, length)]), glued([(0, 0, 0)])
        out = run(scene_of(particle, {}, [spin], values, glued={"ball": ball}))

        time = out.stages[0].time
        way = friction * length * (math.cosh(math.sqrt(GRAVITY / length) * time) - 1)
        # The upper side of a particle that turns about x goes towards negative y.
        found, expected = out.snapshot("dragged").positions[0, 1], -math.copysign(way, speed)
        assert found == pytest.approx(expected, abs=0.03 * way + self.slide_kick * time)

    def test_a_glued_particle_that_is_left_spins_no_more(self, run: Run) -> None:
        turn = {"ball": Rotation("x", 60.0)}
        spin = Stage("spin", Elapsed(0.02), motions=turn)
        # It falls onto the ball, and bounces, after that was left.
        particle, ball = spheres([(0.0, 0.0, 2 * RADIUS + 0.005)]), glued([(0, 0, 0)])
        stages = [spin, *frames(0.03)]
        out = run(scene_of(particle, {}, stages, material(0.3, 0.5), glued={"ball": ball}))

        found = out.snapshot("frame1").positions[0]
        assert found[:2] == pytest.approx([0, 0], abs=1e-8)
        assert found[2] < 2 * RADIUS + 0.002
