# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of programs that simulate clumps of spheres, as tests to inherit: closed forms.

Use it like `grainfit.testing.scene_contract.SceneContract`::

    class TestMyProgram(SceneContract, ClumpContract):
        @pytest.fixture
        def solver(self):
            return MyProgram(Heap(diameter="10 mm"), {})
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation as Turn

from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.errors import RunFailedError
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import Particles
from grainfit.scenes.conditions import Drained, Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import (
    Force,
    Frames,
    KineticEnergy,
    MassAbove,
    RadialForce,
    Recorded,
    Series,
)
from grainfit.scenes.scene import Box, Stage, Wall, time_step
from grainfit.scenes.shapes import Cylinder
from grainfit.solvers.dem.program import DeckSolver
from grainfit.testing.glued_contract import glued
from grainfit.testing.simulated_scenes import (
    BOX,
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
    frames,
    material,
    means,
    scene_of,
    settle,
    spheres,
)

_ASPECT_RATIO = 1.6
PAIR = ParticleSizes((2 * RADIUS,), shape=ParticleShape("two_spheres", aspect_ratio=_ASPECT_RATIO))
#: One large sphere and a small one: its spheres' masses have another centre than the body.
PIN = ParticleSizes(
    (2 * RADIUS,), shape=ParticleShape(spheres=((0.0, 0.0, 0.0, 1.0), (1.1, 0.0, 0.0, 0.5)))
)
#: About the y axis, which takes x to -z, and z to x.
_UPRIGHT = math.pi / 2


def clumps(
    positions: Sequence[Sequence[float]],
    turns: Sequence[float] = (),
    velocities: Sequence[Sequence[float]] | None = None,
    spins: Sequence[Sequence[float]] | None = None,
) -> Column:
    """Return clumps with centres at these positions, turned about the y axis by these angles."""
    angles = np.array(turns or [0.0] * len(positions))
    quaternions = Turn.from_rotvec(np.outer(angles, [0.0, 1.0, 0.0])).as_quat()
    rates = None if spins is None else np.array(spins, dtype=float)
    column = spheres(positions, velocities)
    return replace(column, orientations=quaternions, spins=rates)


def centres(found: Particles, sizes: ParticleSizes) -> NDArray[np.float64]:
    """Return the centres of mass of clumps of two spheres, m, shape (clumps, 3)."""
    clump = sizes.clump
    assert clump is not None, "these are spheres"
    first, second = clump.positions[:, 0]
    share = -first / (second - first)
    pairs = found.positions.reshape(-1, 2, 3)
    found_centres: NDArray[np.float64] = pairs[:, 0] * (1 - share) + pairs[:, 1] * share
    return found_centres


def axes(found: Particles) -> NDArray[np.float64]:
    """Return the directions from the first to the second sphere of clumps of two."""
    pairs = np.diff(found.positions.reshape(-1, 2, 3), axis=1)[:, 0]
    directions: NDArray[np.float64] = pairs / np.linalg.norm(pairs, axis=1)[:, None]
    return directions


def moments(sizes: ParticleSizes) -> NDArray[np.float64]:
    """Return the principal moments of inertia of a clump of elastic material, kg m^2."""
    clump = sizes.clump
    assert clump is not None, "these are spheres"
    return MASS * (2 * RADIUS) ** 2 * np.array(clump.moments)


class ClumpContract(SimulatedScenes):
    """Clumps against closed forms; subclasses define the program."""

    @pytest.mark.parametrize("sizes", [PAIR, PIN], ids=["pair", "pin"])
    def test_a_clump_falls_freely_and_does_not_turn(self, run: Run, sizes: ParticleSizes) -> None:
        recorded = Series({"energy": KineticEnergy()}, 0.01)
        start = clumps([(0.01, -0.02, 0.1)], [0.4])
        out = run(scene_of(start, {}, frames(0.1, series=recorded), sizes=sizes))

        (end,) = out.stages
        found = out.snapshot("frame1")
        clump = sizes.clump
        assert clump is not None
        assert (end.particles, found.count, len(found)) == (1, 1, 2)
        assert found.masses.sum() == pytest.approx(MASS, rel=1e-4)
        assert found.radii == pytest.approx(2 * RADIUS * clump.radii, rel=1e-4)
        assert found.volumes.sum() == pytest.approx(math.pi / 6 * (2 * RADIUS) ** 3, rel=1e-3)
        assert found.diameter == pytest.approx(2 * RADIUS, rel=1e-3)
        fall = GRAVITY * end.time**2 / 2
        place = [0.01, -0.02, 0.1 - fall]
        assert centres(found, sizes)[0] == pytest.approx(place, abs=2e-6)
        assert axes(found)[0] == pytest.approx([math.cos(0.4), 0, -math.sin(0.4)], abs=1e-3)
        series = out.series("part1")
        assert series["energy"] == pytest.approx(
            MASS * (GRAVITY * series["time"]) ** 2 / 2, rel=2e-3, abs=1e-12
        )

    def test_a_clump_of_unequal_spheres_turns_about_its_centre_of_mass(self, run: Run) -> None:
        place, speed = [0.01, -0.02, 0.1], 20.0
        start = clumps([place], [0.4], spins=[[0.0, speed, 0.0]])
        half_a_turn = math.pi / speed
        out = run(scene_of(start, {}, frames(half_a_turn), sizes=PIN, gravity=0.0))

        angle = 0.4 + speed * out.stages[-1].time
        found = out.snapshot("frame1")
        assert axes(found)[0] == pytest.approx([math.cos(angle), 0, -math.sin(angle)], abs=1e-3)
        assert centres(found, PIN)[0] == pytest.approx(place, abs=2e-6)

    def test_a_clump_that_spins_keeps_its_axis(self, run: Run) -> None:
        speed, time = 20.0, 0.05
        start = clumps([(0, 0, 0.1)], spins=[(0, speed, 0)])
        scene = scene_of(start, {}, frames(time), sizes=PAIR, gravity=0.0)
        out = run(scene)

        found, angle = out.snapshot("frame1"), speed * out.stages[0].time
        assert axes(found)[0] == pytest.approx([math.cos(angle), 0, -math.sin(angle)], abs=3e-3)
        assert centres(found, PAIR)[0] == pytest.approx([0, 0, 0.1], abs=2e-6)
        energy = moments(PAIR)[1] * speed**2 / 2
        assert energy <= scene.initial_energy <= 1.1 * energy

    def test_kinetic_energy_is_that_of_translation(self, run: Run) -> None:
        """A clump, too, may spin on a point of a floor for ever, and its bed is at rest."""
        recorded = Series({"energy": KineticEnergy()}, 0.01)
        start = clumps([(0, 0, 0.1)], velocities=[(0.02, 0, 0)], spins=[(0, 20.0, 5.0)])
        out = run(scene_of(start, {}, frames(0.05, series=recorded), sizes=PAIR, gravity=0.0))

        energy = MASS * 0.02**2 / 2
        assert out.series("part1")["energy"] == pytest.approx(energy, rel=2e-3)
        assert out.stages[0].kinetic_energy == pytest.approx(energy, rel=2e-3)

    def test_a_clump_that_tumbles_precesses_about_its_angular_momentum(self, run: Run) -> None:
        # A symmetric top: its axis goes round the angular momentum with the rate L / I.
        spin, tumble = 30.0, 15.0
        start = clumps([(0, 0, 0.1)], spins=[(spin, 0, tumble)])
        out = run(scene_of(start, {}, frames(0.1, 4), sizes=PAIR, gravity=0.0))

        along, across, _ = moments(PAIR)
        momentum = np.array([along * spin, 0.0, across * tumble])
        rate = momentum / across
        for number, stage in enumerate(out.stages, 1):
            expected = Turn.from_rotvec(rate * stage.time).apply([1.0, 0.0, 0.0])
            found = axes(out.snapshot(f"frame{number}"))[0]
            assert found == pytest.approx(expected, abs=5e-3)

    @pytest.mark.parametrize("angle", [0.3, 1.0])
    def test_a_clump_that_hits_a_plane_beside_its_centre_rebounds_and_turns(
        self, run: Run, angle: float
    ) -> None:
        speed, restitution, gap = 0.5, 1.0, 0.001
        clump = PAIR.clump
        assert clump is not None
        arm, radius = 2 * RADIUS * clump.positions[1, 0], 2 * RADIUS * clump.radii[1]
        # The second sphere is the lower one, at positive x.
        reach = arm * math.sin(angle) + radius
        start = clumps([(0, 0, reach + gap)], [angle], [(0, 0, -speed)])
        step = time_step(PAIR, STIFF, 0.01)
        scene = scene_of(
            start, FLOOR, frames(0.006, 2), STIFF, sizes=PAIR, gravity=0.0, time_step=step
        )
        out = run(scene)

        inertia, beside = moments(PAIR)[1], arm * math.cos(angle)
        impulse = (1 + restitution) * speed / (1 / MASS + beside**2 / inertia)
        rebound, turning = impulse / MASS - speed, impulse * beside / inertia
        one, other = out.snapshot("frame1"), out.snapshot("frame2")
        passed = out.stages[1].time - out.stages[0].time
        found = (centres(other, PAIR) - centres(one, PAIR))[0] / passed
        assert found == pytest.approx([0, 0, rebound], abs=0.01 * speed)
        # The end that was hit goes up: the axis turns from x to z.
        (x, _, z), (x2, _, z2) = axes(one)[0], axes(other)[0]
        turned = (math.atan2(z2, x2) - math.atan2(z, x)) / passed
        assert turned == pytest.approx(turning, rel=0.02)

    def test_a_clump_lies_on_two_spheres_with_its_weight(self, run: Run) -> None:
        clump = PAIR.clump
        assert clump is not None
        radius = 2 * RADIUS * clump.radii[0]
        load = Series({"load": Force("floor", "z")}, 0.001)
        stages = [settle(), Stage("hold", Elapsed(0.01), series=load)]
        out = run(scene_of(clumps([(0, 0, radius)]), FLOOR, stages, DAMPED, sizes=PAIR))

        moduli = particle_moduli(DAMPED, "wall")
        overlap = hertz_overlap(WEIGHT / 2, moduli, self.wall_radius * radius)
        heights = radius - out.snapshot("rest").positions[:, 2]
        assert heights == pytest.approx([overlap, overlap], rel=0.01)
        assert means(out, "hold")["load"] == pytest.approx(-WEIGHT, rel=1e-2)

    def test_restitution_is_that_of_the_masses_of_clumps(self, run: Run) -> None:
        # End to end, and upright on the floor: central impacts of one contact each.
        restitution, speed, gap = 0.6, 0.3, 0.002
        clump = PAIR.clump
        assert clump is not None
        end = 2 * RADIUS * clump.outer_radius
        start = clumps(
            [(-end - gap / 2, 0, 0.1), (end + gap / 2, 0, 0.1), (0.06, 0.05, end + gap / 2)],
            [0.0, 0.0, _UPRIGHT],
            [(speed, 0, 0), (-speed, 0, 0), (0, 0, -speed)],
        )
        stages = frames(0.04, 2)
        scene = scene_of(start, FLOOR, stages, material(restitution), sizes=PAIR, gravity=0.0)
        out = run(scene)

        passed = out.stages[1].time - out.stages[0].time
        moved = [centres(out.snapshot(name), PAIR) for name in ("frame1", "frame2")]
        found = (moved[1] - moved[0]) / passed
        slow = restitution * speed
        expected = [[-slow, 0, 0], [slow, 0, 0], [0, 0, slow]]
        assert found == pytest.approx(np.array(expected), abs=0.02 * speed)

    def test_a_clump_that_leaves_the_box_is_gone_as_a_whole(self, run: Run) -> None:
        box = replace(BOX, low=(-0.1, -0.1, -0.03))
        start = clumps([(0, 0, 0.03), (0.05, 0, 0.15)], [_UPRIGHT, 0.0])
        out = run(scene_of(start, {}, frames(0.15), sizes=PAIR, box=box))

        assert out.stages[0].particles == out.snapshot("frame1").count == 1
        assert len(out.snapshot("frame1")) == 2

    def test_nothing_is_left_of_clumps_that_leave_a_periodic_box(self, run: Run) -> None:
        box = Box((-0.1, 0.0, -0.03), (0.1, 0.03, 0.3), periodic="y")
        start = clumps(
            [(-0.02, 0.002, 0.03), (0.02, 0.028, 0.03), (0, 0.015, 0.25)], [_UPRIGHT] * 3
        )
        out = run(scene_of(start, {}, frames(0.16), sizes=PAIR, box=box))

        assert out.stages[0].particles == out.snapshot("frame1").count == 1
        assert len(out.snapshot("frame1")) == 2

    def test_a_clump_that_leaves_a_closed_stage_fails_the_run(self, run: Run) -> None:
        box = replace(BOX, low=(-0.1, -0.1, -0.03))
        start = clumps([(0, 0, 0.03), (0.05, 0, 0.15)])
        stages = [Stage("fill", Elapsed(0.15), is_closed=True)]
        out = run(scene_of(start, {}, stages, sizes=PAIR, box=box))

        with pytest.raises(RunFailedError, match="broke out of the pot"):
            out.require_complete(["fill"], "pot")

    def test_clumps_whose_centre_is_above_are_struck_off(self, run: Run) -> None:
        # Upright ones, of which a sphere is above and another below the height.
        heights = [0.06, 0.0595, 0.0605, 0.08]
        places = [(0.03 * n - 0.05, 0.0, z) for n, z in enumerate(heights)]
        start = clumps(places, [_UPRIGHT] * 4)
        stages = [
            Stage("one", Elapsed(0.001), strike_off=0.07, snapshot="first"),
            Stage("two", Elapsed(0.05), strike_off=0.0598, snapshot="second"),
        ]
        out = run(scene_of(start, {}, stages, sizes=PAIR, gravity=1e-3))

        first, second = (out.snapshot(name) for name in ("first", "second"))
        assert centres(first, PAIR)[:, 0] == pytest.approx([-0.05, -0.02, 0.01], abs=1e-6)
        assert centres(second, PAIR)[:, 0] == pytest.approx([-0.02], abs=1e-6)
        assert [end.particles for end in out.stages] == [3, 1]
        # The one that is left falls as before.
        time = out.stages[1].time
        fallen = heights[1] - centres(second, PAIR)[0, 2]
        assert fallen == pytest.approx(1e-3 * time**2 / 2, abs=1e-7)

    @pytest.mark.parametrize("sizes", [PAIR, PIN], ids=["pair", "pin"])
    def test_the_mass_above_a_height_counts_clumps(self, run: Run, sizes: ParticleSizes) -> None:
        above = Series({"above": MassAbove(0.05)}, 0.001)
        stages = [Stage(name, Elapsed(0.003), series=above) for name in ("one", "two")]
        start = clumps([(0, 0, 0.02), (0.02, 0, 0.08), (-0.03, 0, 0.09)])
        out = run(scene_of(start, {}, stages, sizes=sizes, gravity=0.0))

        for name in ("one", "two"):
            assert out.series(name)["above"] == pytest.approx(2 * MASS, rel=1e-4)

    def test_stages_end_once_shares_of_clumps_have_drained(self, run: Run) -> None:
        stages = [
            Stage(name, Drained(0.05, share, 1.0, at_least=0.001))
            for name, share in (("one", 0.3), ("two", 0.6))
        ]
        heights = [0.05 + GRAVITY * time**2 / 2 for time in (0.05, 0.08)]
        start = clumps([(0, 0, 0.15), *((0.05, 0, height) for height in heights)])
        scene = scene_of(start, {}, stages, sizes=PAIR)

        for end, expected in zip(run(scene).require_good(), (0.05, 0.08), strict=True):
            assert expected - 2e-3 <= end.time <= expected + 1.1 * scene.check_interval + 1e-3

    def test_clumps_of_two_sizes_have_their_spheres_and_masses(self, run: Run) -> None:
        sizes = ParticleSizes((2 * RADIUS, 3 * RADIUS), (0.5, 0.5), shape=PIN.shape)
        start = replace(
            clumps([(0, 0, 0.05), (0.03, 0, 0.05), (-0.04, 0, 0.05)], [0.2, 0.4, 0.0]),
            size_indices=np.array([1, 0, 1]),
        )
        out = run(scene_of(start, {}, frames(0.01), sizes=sizes))

        clump, found = sizes.clump, out.snapshot("frame1")
        assert clump is not None
        diameters = np.array([3, 2, 3]) * RADIUS
        radii = np.outer(diameters, clump.radii).ravel()
        assert sorted(found.radii) == pytest.approx(sorted(radii), rel=1e-4)
        assert found.clumps is not None
        masses = [found.masses[found.clumps == n].sum() for n in np.unique(found.clumps)]
        expected = MASS * (diameters / (2 * RADIUS)) ** 3
        assert sorted(masses) == pytest.approx(sorted(expected), rel=1e-4)
        assert out.stages[0].kinetic_energy == pytest.approx(
            expected.sum() * (GRAVITY * out.stages[0].time) ** 2 / 2, rel=1e-2
        )

    def test_sums_of_a_second_stage_go_on_from_look_to_look(self, run: Run) -> None:
        clump = PAIR.clump
        assert clump is not None
        radius = 2 * RADIUS * clump.outer_radius
        walls = {**FLOOR, "tube": Wall(Cylinder(1.2 * radius, BOX.low[2], BOX.high[2]))}
        columns: dict[str, Recorded] = {"outwards": RadialForce("tube"), "above": MassAbove(0.0)}
        stages = [Stage("one", Elapsed(0.001)), settle(Series(columns, 0.005))]
        start = clumps([(0, 0, 0.03), (0, 0, 0.05)], [0.9, 0.0])
        damped = {**DAMPED, "particle_wall.sliding_friction": 0.5}
        out = run(scene_of(start, walls, stages, damped, sizes=PAIR))
        out.require_complete(["one", "settle"], "tube")

        series = out.series("settle")
        assert len(series["time"]) > 5
        assert series["above"] == pytest.approx(2 * MASS, rel=1e-4)
        # The clumps lean against it at last.
        assert series["outwards"][-1] > 0.1 * WEIGHT

    def test_clumps_touch_across_a_periodic_side(self, run: Run) -> None:
        depth = 0.03
        box = Box((-0.1, 0.0, -0.1), (0.1, depth, 0.2), periodic="y")
        clump = PAIR.clump
        assert clump is not None
        end = 2 * RADIUS * clump.outer_radius
        lengthwise = Turn.from_euler("z", 90, degrees=True).as_quat()
        # Across the side, and just in front of the other end of its copy.
        middle, gap, speed = 0.002, 0.001, 0.3
        start = replace(
            spheres([(0, middle, 0.1), (0, middle + depth / 2, 0.1)], [(0, speed, 0), (0, 0, 0)]),
            orientations=np.array([lengthwise, lengthwise]),
        )
        assert depth / 2 - 2 * end == pytest.approx(gap, abs=2e-3)
        stages = frames(0.02)
        out = run(scene_of(start, {}, stages, sizes=PAIR, box=box, gravity=0.0))

        # Equal masses: they exchange their velocities, and go on doing so around the period.
        (stage,) = out.stages
        assert stage.particles == 2
        assert stage.kinetic_energy == pytest.approx(MASS * speed**2 / 2, rel=0.01)

    def test_clumps_meet_glued_spheres_and_are_told_from_them(self, run: Run) -> None:
        body = glued([(x, y, 0.0) for x in (-0.01, 0.0, 0.01) for y in (-0.01, 0.0, 0.01)])
        stages = [Stage("fall", Elapsed(0.2), frames=Frames("film", 0.1)), settle()]
        start = clumps([(0.002, 0.001, 0.03)], [0.3])
        damped = {**DAMPED, "particle_particle.sliding_friction": 0.5}
        scene = scene_of(start, {}, stages, damped, sizes=PAIR, glued={"plate": body})
        out = run(scene)
        out.require_complete(["fall", "settle"], "plate")

        resting = out.snapshot("rest")
        assert (resting.count, len(resting), out.stages[1].particles) == (1, 2, 1)
        assert (resting.positions[:, 2] > RADIUS).all()
        plate = out.snapshot("rest", glued=1)
        assert plate.positions == pytest.approx(body.positions, abs=1e-9)
        assert plate.radii == pytest.approx(RADIUS)

    def test_a_clump_of_aspect_ratio_one_is_a_sphere(
        self, solver: DeckSolver, tmp_path: Path
    ) -> None:
        written = []
        for shape in (None, ParticleShape("two_spheres", aspect_ratio=1.0)):
            folder = tmp_path / str(shape)
            folder.mkdir()
            sizes = ParticleSizes((2 * RADIUS,), shape=shape)
            scene = scene_of(spheres([(0, 0, 0.1)]), FLOOR, frames(0.01), ELASTIC, sizes=sizes)
            solver.deck(scene, folder).write()
            files = sorted(path for path in folder.rglob("*") if path.is_file())
            written.append(b"".join(path.read_bytes() for path in files))

        assert written[0] == written[1]
