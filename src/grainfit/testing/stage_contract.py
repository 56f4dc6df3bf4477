# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of programs that simulate scenes: how stages end, and what they record."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grainfit.errors import RunFailedError
from grainfit.measurement.particles import read_frames
from grainfit.scenes.conditions import AtRest, Clear, Drained, Elapsed
from grainfit.scenes.film import FILM, Film
from grainfit.scenes.packing import Round, random_column
from grainfit.scenes.records import (
    Force,
    Frames,
    KineticEnergy,
    MassAbove,
    Recorded,
    Series,
    Travel,
)
from grainfit.scenes.run_output import snapshot_file
from grainfit.scenes.scene import Load, Stage, Velocity, Wall, time_step
from grainfit.scenes.shapes import Block, Cylinder, Plane
from grainfit.testing.lowered_bed import Tube, floor_shares, lowered_bed
from grainfit.testing.simulated_scenes import (
    BOX,
    DAMPED,
    ELASTIC,
    FLOOR,
    GRAVITY,
    MASS,
    RADIUS,
    SIZES,
    WEIGHT,
    Run,
    SimulatedScenes,
    frames,
    material,
    means,
    resting_overlap,
    scene_of,
    settle,
    spheres,
)


class StageContract(SimulatedScenes):
    """Stages and records against closed forms."""

    # --- stages --------------------------------------------------------------------------------

    def test_walls_are_taken_away_and_put_at_the_beginning_of_a_stage(self, run: Run) -> None:
        stages = [
            settle(),
            Stage("fall", Elapsed(0.06), take_away=("door",), snapshot="falling"),
            Stage("catch", AtRest(2.0, at_least=0.1), put=FLOOR, snapshot="caught"),
        ]
        walls = {"door": Wall(Plane("z", 0.05))}
        out = run(scene_of(spheres([(0, 0, 0.05 + RADIUS)]), walls, stages, DAMPED))

        rest, falling, caught = (out.snapshot(stage.snapshot).positions[0, 2] for stage in stages)
        time = out.stages[1].time - out.stages[0].time
        assert rest == pytest.approx(0.05 + self.rests_at(DAMPED), abs=1e-6)
        assert falling == pytest.approx(rest - GRAVITY * time**2 / 2, abs=5e-6)
        assert caught == pytest.approx(self.rests_at(DAMPED), abs=1e-6)

    def test_exactly_the_particles_above_are_struck_off_at_every_stage(self, run: Run) -> None:
        particles = spheres([(0, 0, 0.06), (0.02, 0, 0.08), (0.04, 0, 0.0899), (0.06, 0, 0.0901)])
        stages = [
            Stage("one", Elapsed(0.05), strike_off=0.09, snapshot="first"),
            Stage("two", Elapsed(0.01), strike_off=0.06, snapshot="second"),
        ]
        out = run(scene_of(particles, {}, stages))

        # After 0.05 s they have fallen by 12 mm.
        assert out.snapshot("first").positions[:, 0] == pytest.approx([0, 0.02, 0.04])
        assert out.snapshot("second").positions[:, 0] == pytest.approx([0])
        assert [end.particles for end in out.stages] == [3, 1]

    def test_a_stage_ends_at_rest_and_not_before_its_shortest_time(self, run: Run) -> None:
        stages = [Stage("settle", AtRest(5.0, at_least=0.4)), Stage("after", Elapsed(0.01))]
        scene = scene_of(spheres([(0, 0, 0.01)]), FLOOR, stages, DAMPED)
        settled, after = run(scene).require_complete(["settle", "after"], "box")

        assert (settled.end, after.end) == ("at_rest", "done")
        assert settled.kinetic_energy < scene.energy_at_rest
        assert 0.4 - scene.time_step < settled.time < 0.5
        assert after.time - settled.time == pytest.approx(0.01, abs=scene.time_step)

    def test_a_bed_that_never_rests_fails_the_run_at_the_limit(self, run: Run) -> None:
        stages = [Stage("settle", AtRest(0.3)), Stage("after", Elapsed(0.01), snapshot="late")]
        scene = scene_of(spheres([(0, 0, 0.05)]), FLOOR, stages, ELASTIC)
        out = run(scene)

        (end,) = out.stages
        assert end.end == "restless"
        assert 0.3 <= end.time + scene.time_step <= 0.3 + 2 * scene.check_interval
        assert not (out.folder / "snapshots/late.dump").exists()
        with pytest.raises(RunFailedError, match="did not come to rest in the settle stage"):
            out.require_complete(["settle", "after"], "box")

    @pytest.mark.parametrize(("share", "expected"), [(0.3, 0.05), (0.6, 0.08), (1.0, 0.217)])
    def test_a_stage_ends_once_a_share_has_drained_or_the_rest_is_at_rest(
        self, run: Run, share: float, expected: float
    ) -> None:
        walls = {"table": Wall(Block((-0.02, -0.02, -0.02), (0.02, 0.02, 0.0)))}
        falls = [GRAVITY * time**2 / 2 for time in (0.05, 0.08)]
        particles = spheres([(0, 0, RADIUS), *((0.05 + fall, 0, fall) for fall in falls)])
        box = replace(BOX, low=(-0.1, -0.1, -0.2))
        until = Drained(0.0, share, 1.0, at_least=0.01)
        scene = scene_of(particles, walls, [Stage("drain", until)], DAMPED, box=box)
        (end,) = run(scene).require_complete(["drain"], "box")

        assert end.end == "done"
        assert end.particles == (1 if share == 1.0 else 3)
        assert expected - scene.time_step <= end.time <= expected + 1.1 * scene.check_interval

    def test_what_goes_on_falling_without_draining_fails_the_run(self, run: Run) -> None:
        stages = [Stage("drain", Drained(-1.0, 0.5, 0.05, at_least=0.01))]
        out = run(scene_of(spheres([(0, 0, 0.1)]), FLOOR, stages, DAMPED))
        assert [end.end for end in out.stages] == ["restless"]

    @pytest.mark.parametrize(("limit", "expected"), [(1.0, 0.17), (0.05, 0.05)])
    def test_a_lift_ends_once_the_tube_is_clear_or_at_its_limit(
        self, run: Run, limit: float, expected: float
    ) -> None:
        walls = {**FLOOR, "tube": Wall(Cylinder(0.02, 0.0015, 0.06))}
        lift = Stage("lift", Clear("tube", limit), motions={"tube": Velocity("z", 0.05)})
        scene = scene_of(spheres([(0, 0, RADIUS)]), walls, [settle(), lift], DAMPED)
        settled, lifted = run(scene).require_complete(["settle", "lift"], "tube")

        duration = lifted.time - settled.time
        assert lifted.end == "done"
        assert expected - 0.002 <= duration <= expected + 1.1 * scene.check_interval

    @pytest.mark.parametrize("until", [AtRest(1.0, at_least=0.01), Elapsed(0.2)])
    def test_a_particle_that_leaves_a_closed_stage_fails_the_run(
        self, run: Run, until: AtRest | Elapsed
    ) -> None:
        walls = {"table": Wall(Block((-0.02, -0.02, -0.02), (0.02, 0.02, 0.0)))}
        particles = spheres([(0, 0, RADIUS), (0.05, 0, 0.01)])
        box = replace(BOX, low=(-0.1, -0.1, -0.03))
        stages = [Stage("fill", until, is_closed=True), Stage("after", Elapsed(0.01))]
        out = run(scene_of(particles, walls, stages, DAMPED, box=box))

        assert [end.end for end in out.stages] == ["broken"]
        assert out.stages[0].particles == 1
        with pytest.raises(RunFailedError, match="1 of 2 particles broke out of the pot"):
            out.require_complete(["fill", "after"], "pot")
        with pytest.raises(RunFailedError, match="1 of 2 particles left the box in the fill stage"):
            out.require_good()

    def test_a_closed_stage_that_all_particles_leave_says_so(self, run: Run) -> None:
        box = replace(BOX, low=(-0.1, -0.1, -0.03))
        particles = spheres([(0.05, 0, 0.01), (0, 0.05, 0.02)])
        fill = Stage("fill", AtRest(1.0, at_least=0.2), is_closed=True)
        walls = {"table": Wall(Block((-0.02, -0.02, -0.02), (0.02, 0.02, 0.0)))}
        with pytest.raises(RunFailedError, match="all 2 particles left the box in the fill stage"):
            run(scene_of(particles, walls, [fill], DAMPED, box=box)).require_good()

    def test_floor_and_wall_carry_the_weight_of_a_bed(self, run: Run) -> None:
        values = material(restitution=0.3, sliding_friction=0.4)
        radius, top = 5 * RADIUS, 0.19
        walls = {**FLOOR, "tube": Wall(Cylinder(radius, -0.1, 0.2))}
        both: dict[str, Recorded] = {"floor": Force("floor", "z"), "wall": Force("tube", "z")}
        recorded = Series(both, 0.002)
        lower = {"floor": Velocity("z", -0.01)}
        stages = [
            Stage("fill", AtRest(5.0, at_least=0.2), is_closed=True),
            Stage("filled", Elapsed(0.02), series=recorded),
            Stage("lower", Elapsed(0.3), motions=lower),
            Stage("settle", AtRest(5.0, at_least=0.1)),
            Stage("lowered", Elapsed(0.02), series=recorded, snapshot="end"),
        ]
        column = random_column(SIZES, 80, Round(radius), 1)
        assert column.height < top
        options = {"time_step": time_step(SIZES, values, 0.1), "quiet_speed": 2e-4}
        out = run(scene_of(column, walls, stages, values, **options))

        out.require_complete([stage.name for stage in stages], "tube")
        weight = 80 * WEIGHT
        for stage in ("filled", "lowered"):
            forces = means(out, stage)
            assert forces["floor"] + forces["wall"] == pytest.approx(-weight, rel=1e-2)
        # The bed hangs on the wall once it has moved down.
        assert forces["wall"] < -0.1 * weight

    @pytest.mark.slow
    def test_a_lowered_bed_hangs_on_a_wide_tube_as_janssen_says(self, run: Run) -> None:
        if self.is_slow:
            pytest.skip("takes minutes; benchmarks/janssen.py has these runs")
        # So soft that it takes few time steps.
        softness = {"particle.youngs_modulus": 1.5e5}
        values = {**material(restitution=0.6, sliding_friction=0.4), **softness}
        tube = Tube(14 * RADIUS, 14 * RADIUS, has_radial_forces=False)
        column = random_column(SIZES, 1170, Round(tube.radius), 1)
        step = time_step(SIZES, values, 0.12)
        out = run(lowered_bed(tube, column, values, SIZES, GRAVITY, step))

        out.require_complete(["fill", "hold", "lower", "stop", "after"], "tube")
        found = floor_shares(out, tube, SIZES, GRAVITY)
        assert found["hold_sum"] == pytest.approx(1.0, abs=1e-2)
        assert found["after_sum"] == pytest.approx(1.0, abs=1e-2)
        assert found["after_floor"] == pytest.approx(found["after_janssen"], rel=0.1)
        # Lowering the floor is what makes the bed hang.
        assert found["after_floor"] < 0.85 * found["hold_floor"]

    def test_an_empty_box_is_a_result(self, run: Run) -> None:
        columns: dict[str, Recorded] = {
            "mass": MassAbove(-1.0),
            "energy": KineticEnergy(),
            "floor": Force("floor", "z"),
            "way": Travel("floor"),
        }
        recorded = Series(columns, 0.01)
        down = {"floor": Velocity("z", -0.1)}
        stages = [
            Stage("fall", Elapsed(0.3), frames=Frames("falling", 0.02), snapshot="fallen"),
            Stage("rest", AtRest(1.0, at_least=0.1), motions=down, series=recorded),
            Stage("on", Elapsed(0.05), motions=down, frames=Frames("going", 0.02), series=recorded),
            Stage("struck", Elapsed(0.01), strike_off=0.0, snapshot="end"),
        ]
        walls = {"floor": Wall(Block((0.05, -0.02, -0.01), (0.08, 0.02, 0.0)))}
        box = replace(BOX, low=(-0.1, -0.1, -0.05))
        particles = spheres([(0, 0, 0.05), (0, 0.02, 0.08)])
        scene = scene_of(particles, walls, stages, DAMPED, box=box, film_interval=0.05)
        out = run(scene)

        ends = [(end.name, end.end, end.particles) for end in out.require_good()]
        assert ends == [
            ("fall", "done", 0),
            ("rest", "at_rest", 0),
            ("on", "done", 0),
            ("struck", "done", 0),
        ]
        assert out.stages[-1].time == pytest.approx(0.46, abs=4 * scene.time_step)
        assert len(out.snapshot("fallen")) == len(out.snapshot("end")) == 0
        series = out.series("on")
        assert not any(series[name].any() for name in ("mass", "energy", "floor"))
        assert series["way"] == pytest.approx(-0.1 * (series["time"] - out.stages[0].time))
        assert np.diff(series["time"]) == pytest.approx(0.01, abs=scene.time_step)
        assert [len(frame.particles) for frame in out.frames("falling")][-1] == 0
        assert len([*out.frames("going")]) in (2, 3)
        film = Film(out.folder / FILM)
        assert out.stages[-1].time - film.steps[-1] * scene.time_step < 0.05 + scene.time_step

    def test_a_box_that_runs_empty_after_it_was_pressed_is_a_result(self, run: Run) -> None:
        press = Load("z", -0.001, largest_speed=0.01, gain=1.0)
        stages = [
            Stage("fall", Elapsed(0.3), motions={"floor": press}),
            Stage("on", Elapsed(0.02), snapshot="end"),
        ]
        walls = {"floor": Wall(Block((0.05, -0.02, -0.01), (0.08, 0.02, 0.0)))}
        box = replace(BOX, low=(-0.1, -0.1, -0.05))
        scene = scene_of(spheres([(0, 0, 0.05)]), walls, stages, DAMPED, box=box)

        out = run(scene)

        assert [end.particles for end in out.require_good()] == [0, 0]
        assert len(out.snapshot("end")) == 0

    def test_frames_are_recorded_during_a_stage(self, run: Run) -> None:
        fall = Stage("fall", Elapsed(0.05), frames=Frames("falling", 0.01), snapshot="end")
        later = Stage("later", Elapsed(0.02), frames=Frames("on", 0.005))
        particles = spheres([(0, 0, 0.1), (0.05, 0, 0.15)])
        scene = scene_of(particles, FLOOR, [fall, later])
        out = run(scene)

        for name, every, begin, count in (
            ("falling", 0.01, 0.0, 6),
            ("on", 0.005, out.stages[0].time, 4),
        ):
            frames = [*out.frames(name)]
            times = np.array([frame.step for frame in frames]) * scene.time_step
            assert np.diff(times) == pytest.approx(every, abs=scene.time_step)
            assert times[0] >= begin - scene.time_step
            assert abs(len(times) - count) <= 1
            assert times[-1] <= out.stages[-1].time
            for frame, time in zip(frames, times, strict=True):
                heights = np.array([0.1, 0.15]) - GRAVITY * time**2 / 2
                assert frame.particles.positions[:, 2] == pytest.approx(heights, abs=2e-6)

    def test_a_film_goes_through_all_stages_and_changes_nothing(self, run: Run) -> None:
        stages = [
            Stage("fall", Elapsed(0.05)),
            Stage("on", Elapsed(0.03), strike_off=0.12),
            settle(),
        ]
        particles = spheres([(0, 0, 0.1), (0.05, 0, 0.15)])
        scene = scene_of(particles, FLOOR, stages, DAMPED)
        plain, out = run(scene), run(replace(scene, film_interval=0.004))

        assert out.stages == plain.stages
        np.testing.assert_array_equal(
            out.snapshot("rest").positions, plain.snapshot("rest").positions
        )
        film = Film(out.folder / FILM)
        times = film.steps * scene.time_step
        every = scene.steps(0.004) * scene.time_step
        np.testing.assert_allclose(times, every * np.arange(len(times)), rtol=1e-9)
        assert out.stages[-1].time - times[-1] < 0.004 + scene.time_step
        for frame, time in zip(film.read(range(len(times))), times, strict=True):
            is_struck_off = time > out.stages[0].time
            assert len(frame.numbers) == (1 if is_struck_off else 2)
            assert set(frame.glued) == {0}
            if time < 0.1:
                heights = np.array([0.1, 0.15])[: len(frame.numbers)] - GRAVITY * time**2 / 2
                assert frame.positions[:, 2] == pytest.approx(heights, abs=2e-6)

    def test_energy_from_nowhere_fails_the_run(self, run: Run) -> None:
        # Grossly overlapping: they shoot apart.
        particles = spheres([(0, 0, 0.05), (RADIUS, 0, 0.05)])
        out = run(scene_of(particles, FLOOR, [*frames(0.01), settle()], ELASTIC))

        assert [end.end for end in out.stages] == ["unstable"]
        with pytest.raises(RunFailedError, match="became unstable in the part1 stage"):
            out.require_complete(["part1", "settle"], "box")

    def test_energy_that_the_start_or_a_wall_gives_fails_no_run(self, run: Run) -> None:
        ram = Wall(Plane("x", -RADIUS - 0.0001))
        push = Stage("push", Elapsed(0.01), motions={"ram": Velocity("x", 2.0)})
        # Each program rounds one of them up.
        for speed in (2 / 3, 0.7, 1.1):
            particle = spheres([(0, 0, 0)], [(speed, 0, 0)])
            flown = run(scene_of(particle, {}, frames(0.01), gravity=0.0))
            assert [end.end for end in flown.stages] == ["done"]
        for gravity in (0.0, GRAVITY):
            thrown = run(scene_of(spheres([(0, 0, 0)]), {"ram": ram}, [push], gravity=gravity))
            assert [end.end for end in thrown.stages] == ["done"]

    # --- records -------------------------------------------------------------------------------

    def test_mass_above_a_height_counts_particles_that_fall_into_a_sink(self, run: Run) -> None:
        walls = {"table": Wall(Block((-0.02, -0.02, -0.02), (0.02, 0.02, 0.0)))}
        heights = np.array([0.01, 0.03, 0.05])
        particles = spheres([(0, 0, RADIUS), *((0.05, 0, z) for z in heights)])
        box = replace(BOX, low=(-0.1, -0.1, -0.03))
        recorded = Series({"above": MassAbove(0.0)}, 0.002)
        out = run(scene_of(particles, walls, frames(0.15, series=recorded), DAMPED, box=box))

        series = out.series("part1")
        reached = heights - GRAVITY * series["time"][:, None] ** 2 / 2
        assert series["above"] == pytest.approx(MASS * (1 + (reached > 0).sum(axis=1)), rel=1e-5)
        assert out.stages[0].particles == len(out.snapshot("frame1")) == 1

    def test_what_has_left_the_box_is_in_no_record_and_in_no_frame(self, run: Run) -> None:
        columns: dict[str, Recorded] = {"mass": MassAbove(-1.0), "energy": KineticEnergy()}
        stages = [
            Stage("go", Elapsed(0.05), series=Series(columns, 0.01), frames=Frames("going", 0.01))
        ]
        heights = RADIUS - resting_overlap(DAMPED)
        starts = [(0.05, 0, heights), (-0.05, 0, heights)]
        out = run(scene_of(spheres(starts, [(3, 0, 0), (0, 0, 0)]), FLOOR, stages, DAMPED))

        series = out.series("go")
        assert series["mass"][0] == pytest.approx(2 * MASS, rel=1e-5)
        assert series["mass"][-1] == pytest.approx(MASS, rel=1e-5)
        assert series["energy"][-1] < 1e-3 * series["energy"][0]
        *_, last = read_frames(out.path_of(snapshot_file("going")))
        assert last.particles.positions[:, 0] == pytest.approx([-0.05])

    def test_stages_record_the_same_quantities_and_forget_a_wall_that_is_gone(
        self, run: Run
    ) -> None:
        # Names that a deck may use for itself.
        door: dict[str, Recorded] = {"count": Force("door", "z"), "top": Force("door", "x")}
        others: dict[str, Recorded] = {
            "energy": KineticEnergy(),
            "now": MassAbove(0.0),
            "floor": Force("floor", "z"),
        }
        walls = {**FLOOR, "door": Wall(Plane("z", 0.05))}
        stages = [
            settle(),
            Stage("one", Elapsed(0.01), series=Series({**door, **others}, 0.001)),
            Stage("two", Elapsed(0.01), series=Series({**door, **others}, 0.001)),
            Stage("fall", Elapsed(0.05), take_away=("door",), series=Series(others, 0.001)),
        ]
        out = run(scene_of(spheres([(0.01, 0, 0.05 + RADIUS)]), walls, stages, DAMPED))
        one, two, fall = (out.series(name) for name in ("one", "two", "fall"))

        assert list(one) == list(two) == ["time", *door, *others]
        for series in (one, two):
            assert series["count"] == pytest.approx(-WEIGHT, rel=1e-2)
            assert series["top"] == pytest.approx(0, abs=1e-3 * WEIGHT)
            assert series["now"] == pytest.approx(MASS, rel=1e-5)
            assert series["floor"] == pytest.approx(0)
        assert one["time"][-1] < two["time"][0]
        speeds = GRAVITY * (fall["time"] - out.stages[2].time)
        assert fall["energy"] == pytest.approx(MASS * speeds**2 / 2, rel=2e-2, abs=1e-9)
