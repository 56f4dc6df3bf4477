# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of programs that simulate scenes, as tests to inherit: few particles, closed forms.

Write a test class for a new DEM program, in a file that pytest finds::

    from grainfit.testing.scene_contract import SceneContract

    class TestMyProgram(SceneContract):
        @pytest.fixture
        def solver(self):
            return MyProgram(Heap(diameter="10 mm"), {})

and pytest runs all tests below. A concept of scenes that the program does not have stands in its
``missing``; its tests are skipped, and the program must refuse it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.contact import Contact, particle_mass
from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.contact_models.registry import CONTACT_MODELS
from grainfit.errors import InputError, RunFailedError
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import read_frames
from grainfit.scenes.conditions import AtRest, Clear, Elapsed, Loaded
from grainfit.scenes.film import FILM, Film
from grainfit.scenes.packing import Column, Rectangle, random_column
from grainfit.scenes.records import (
    Force,
    Frames,
    KineticEnergy,
    MassAbove,
    RadialForce,
    Recorded,
    Series,
    Travel,
)
from grainfit.scenes.run_output import STAGES, RunOutput, series_file, snapshot_file
from grainfit.scenes.scene import Box, Load, Rotation, Scene, Stage, Velocity, Wall, time_step
from grainfit.scenes.shapes import (
    Annulus,
    Block,
    Cone,
    Cylinder,
    Disc,
    Mesh,
    Plane,
    Shape,
)
from grainfit.scenes.triangles import triangles_of, write_stl
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver
from grainfit.testing.materials import GLASS_BEADS

GRAVITY = 9.81
RADIUS = 0.005
SIZES = ParticleSizes((2 * RADIUS,))
_TIMEOUT = 120.0
#: A box that nothing in these tests leaves unless it is meant to, m.
BOX = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.2))
FLOOR = {"floor": Wall(Plane("z", 0.0))}
Run = Callable[[Scene], RunOutput]


def material(restitution: float = 1.0, sliding_friction: float = 0.0) -> dict[str, float]:
    """Return glass beads without rolling friction, with these values for all contacts."""
    contacts = {
        f"{pair}.{name}": value
        for pair in ("particle_particle", "particle_wall")
        for name, value in (
            ("restitution", restitution),
            ("sliding_friction", sliding_friction),
            ("rolling_friction", 0.0),
        )
    }
    return {**GLASS_BEADS, **contacts}


ELASTIC = material()
#: Deforms so little that the direction of a contact stays what it was at its beginning.
STIFF = {**ELASTIC, "particle.youngs_modulus": 1e8}
#: Comes to rest quickly.
DAMPED = material(restitution=0.3)
MASS = particle_mass(ELASTIC, RADIUS)
WEIGHT = MASS * GRAVITY


def spheres(
    positions: Sequence[Sequence[float]], velocities: Sequence[Sequence[float]] | None = None
) -> Column:
    """Return equal particles at these positions."""
    places = np.array(positions, dtype=float)
    motions = None if velocities is None else np.array(velocities, dtype=float)
    kinds = np.zeros(len(places), dtype=np.int64)
    return Column(places, kinds, float(places[:, 2].max()) + RADIUS, motions)


def scene_of(
    particles: Column,
    walls: Mapping[str, Wall],
    stages: Sequence[Stage],
    values: Mapping[str, float] = ELASTIC,
    **options: Any,
) -> Scene:
    """Return a small scene; options are fields of `Scene`."""
    given: dict[str, Any] = {
        "title": "Scene of a test",
        "sizes": SIZES,
        "box": BOX,
        "gravity": GRAVITY,
        "quiet_speed": 1e-5,
        "check_interval": 0.005,
        **options,
    }
    given.setdefault("time_step", time_step(given["sizes"], values, 0.02))
    return Scene(material=values, particles=particles, walls=walls, stages=tuple(stages), **given)


def frames(seconds: float, count: int = 1, series: Series | None = None) -> list[Stage]:
    """Return stages of equal length with a snapshot each: ``frame1``, ``frame2``, ..."""
    return [
        Stage(f"part{n}", Elapsed(seconds / count), snapshot=f"frame{n}", series=series)
        for n in range(1, count + 1)
    ]


def settle(series: Series | None = None) -> Stage:
    """Return a stage that ends at rest, with the snapshot ``rest``."""
    return Stage("settle", AtRest(2.0, at_least=0.02), snapshot="rest", series=series)


def resting_overlap(values: Mapping[str, float], load: float = WEIGHT, curve: float = 1.0) -> float:
    """Return the Hertz overlap of a particle on a wall under a load, m."""
    return hertz_overlap(load, particle_moduli(values, "wall"), curve * RADIUS)


def _attracting(model: ContactModel, name: str, weights: float) -> float:
    """Return the value of a parameter at which a wall bears so many weights of a particle."""
    low, high = 0.0, 1e9
    assert model.attraction is not None
    for _ in range(100):
        middle = (low + high) / 2
        contact = Contact.on_wall({**DAMPED, name: middle}, RADIUS, GRAVITY)
        enough = model.attraction(contact).pull_off > weights * WEIGHT
        low, high = (low, middle) if enough else (middle, high)
    return high


def final_velocities(run: RunOutput, scene: Scene) -> NDArray[np.float64]:
    """Return the mean velocities between the last two snapshots, m/s, shape (n, 3)."""
    last, before = scene.stages[-1], scene.stages[-2]
    times = {stage.name: stage.time for stage in run.stages}
    moved = run.snapshot(last.snapshot).positions - run.snapshot(before.snapshot).positions
    return moved / (times[last.name] - times[before.name])


def means(run: RunOutput, stage: str) -> dict[str, float]:
    """Return the means of the columns of a series."""
    return {name: float(column.mean()) for name, column in run.series(stage).items()}


class SimulatedScenes:
    """Simulate scenes in a program that subclasses define.

    Attributes
    ----------
    wall_radius : float
        R* of a particle on a plane wall, over its radius.
    slide_kick : float
        Change of speed when a particle begins to slide, beyond that of friction, m/s.
    """

    wall_radius: ClassVar[float] = 1.0
    slide_kick: ClassVar[float] = 0.0

    @pytest.fixture
    def solver(self) -> DeckSolver:
        """Return the program under test."""
        raise NotImplementedError

    @pytest.fixture
    def run(self, solver: DeckSolver, tmp_path: Path) -> Run:
        """Return a function that simulates a scene in a folder of its own."""

        def run(scene: Scene) -> RunOutput:
            lacking = scene.concepts() & set(solver.missing)
            if lacking:
                pytest.skip(f"{solver.name} has no {', '.join(sorted(lacking))}")
            folder = tmp_path / str(len(list(tmp_path.iterdir())))
            folder.mkdir()
            return solver.simulate(scene, Workspace(folder, _TIMEOUT))

        return run


class SceneContract(SimulatedScenes):
    """Every concept of scenes against a closed form; subclasses define the program."""

    def rests_at(self, values: Mapping[str, float]) -> float:
        """Return the height of the centre of a particle at rest on a wall at height 0, m."""
        return RADIUS - resting_overlap(values, curve=self.wall_radius)

    def tube_floor(self, radius: float) -> tuple[float, float]:
        """Return how far below its axis the floor of a lying tube is, and its radius there, m."""
        return radius, radius

    # --- what a program does not have ----------------------------------------------------------

    @pytest.mark.parametrize(
        "shape",
        [
            Plane("z", 0.1),
            Block((-0.02, -0.02, -0.01), (0.02, 0.02, 0.0)),
            Cylinder(0.03, 0.0, 0.1),
            Cylinder(0.03, -0.1, 0.1, "x"),
            Cone(0.02, 0.04, 0.0, 0.1),
            Disc(0.03, 0.0),
            Annulus(0.01, 0.03, 0.0),
            Mesh(Path("floor.stl")),
        ],
        ids=lambda shape: type(shape).__name__.lower(),
    )
    def test_a_missing_concept_is_refused_with_the_reason_and_what_to_use_instead(
        self, solver: DeckSolver, tmp_path: Path, shape: Shape
    ) -> None:
        stages = [
            Stage("move", Elapsed(0.01), motions={"thing": Velocity("z", 0.1)}),
            Stage("press", Elapsed(0.01), motions={"thing": Load("z", 1.0, 0.1, 0.1)}),
        ]
        turn = Stage("turn", Elapsed(0.01), motions={"thing": Rotation("y", 1.0)})
        moved = stages if isinstance(shape, Plane) else [turn]
        scene = scene_of(spheres([(0, 0, 0.01)]), {"thing": Wall(shape)}, moved)
        lacking = scene.concepts() & set(solver.missing)
        if not lacking:
            return
        with pytest.raises(InputError) as caught:
            solver.simulate(scene, Workspace(tmp_path))

        faults = caught.value.faults
        assert all(solver.name in fault.message and "use " in fault.remedy for fault in faults)
        assert sorted(f.remedy for f in faults) == sorted(f"{solver.missing[c]}." for c in lacking)
        assert list(tmp_path.iterdir()) == []

    def test_missing_concepts_are_concepts_of_scenes(self, solver: DeckSolver) -> None:
        shapes = {"plane", "block", "cylinder", "cone", "disc", "annulus", "mesh"}
        shapes.add("lying cylinder")
        motions = {"velocity", "load", "velocity and load", "rotation"}
        axes = {f"periodic {axes}" for axes in ("x", "y", "z", "xy", "xz", "yz", "xyz")}

        assert set(solver.missing) <= shapes | motions | axes | {"glued", "frames", "clumps"}

    # --- gravity, time step, files -------------------------------------------------------------

    def test_a_particle_falls_freely(self, run: Run) -> None:
        recorded = Series({"energy": KineticEnergy()}, 0.01)
        scene = scene_of(spheres([(0.01, -0.02, 0.1)]), {}, frames(0.1, series=recorded))
        out = run(scene)

        (end,) = out.stages
        assert (end.name, end.end, end.particles) == ("part1", "done", 1)
        assert end.time == pytest.approx(0.1, abs=scene.time_step)
        assert end.time == pytest.approx(end.step * scene.time_step)
        fall = GRAVITY * end.time**2 / 2
        particle = out.snapshot("frame1")
        assert particle.positions[0] == pytest.approx([0.01, -0.02, 0.1 - fall], abs=1e-6)
        assert particle.radii[0] == pytest.approx(RADIUS)
        assert particle.masses[0] == pytest.approx(MASS, rel=1e-5)
        series = out.series("part1")
        assert np.diff(series["time"]) == pytest.approx(0.01, abs=scene.time_step)
        assert series["energy"] == pytest.approx(
            MASS * (GRAVITY * series["time"]) ** 2 / 2, rel=2e-3, abs=1e-12
        )
        assert end.kinetic_energy == pytest.approx(MASS * GRAVITY * fall, rel=2e-3)

    def test_all_programs_write_the_same_files(self, run: Run) -> None:
        columns: dict[str, Recorded] = {"floor": Force("floor", "z"), "above": MassAbove(0.05)}
        first = Stage("first", Elapsed(0.01), series=Series(columns, 0.002), snapshot="one")
        out = run(scene_of(spheres([(0, 0, 0.1)]), FLOOR, [first]))

        files = {str(path.relative_to(out.folder)) for path in out.folder.rglob("*.*")}
        assert {STAGES, series_file("first"), "snapshots/one.dump"} <= files
        head = (out.folder / series_file("first")).read_text().splitlines()[0]
        assert head == "time,floor,above"
        dump = (out.folder / "snapshots/one.dump").read_text().splitlines()
        assert dump[8].strip() == "ITEM: ATOMS id type x y z radius mass"
        header, *rows = (out.folder / STAGES).read_text().splitlines()
        assert header == "stage,end,step,time,particles,kinetic_energy"
        assert [row.split(",")[:2] for row in rows] == [["first", "done"]]

    def test_decks_are_deterministic(self, solver: DeckSolver, tmp_path: Path) -> None:
        column = random_column(SIZES, 30, Rectangle(0.06, 0.05), seed=4)
        scene = scene_of(column, FLOOR, [settle()])
        written = []
        for name in ("one", "other"):
            folder = tmp_path / name
            folder.mkdir()
            solver.deck(scene, folder).write()
            files = sorted(path for path in folder.rglob("*") if path.is_file())
            written.append({path.name: path.read_bytes() for path in files})

        assert written[0] == written[1]

    # --- walls ---------------------------------------------------------------------------------

    def test_a_particle_rests_on_a_plane_at_hertz_overlap(self, run: Run) -> None:
        load = Series({"load": Force("floor", "z"), "side": Force("floor", "x")}, 0.001)
        stages = [settle(), Stage("hold", Elapsed(0.01), series=load)]
        out = run(scene_of(spheres([(0, 0, RADIUS)]), FLOOR, stages, DAMPED))

        overlap = RADIUS - out.snapshot("rest").positions[0, 2]
        assert overlap == pytest.approx(RADIUS - self.rests_at(DAMPED), rel=2e-3)
        assert out.series("hold")["load"] == pytest.approx(-WEIGHT, rel=1e-2)
        assert out.series("hold")["side"] == pytest.approx(0, abs=1e-3 * WEIGHT)

    @pytest.mark.parametrize(
        "model", [m for m in CONTACT_MODELS if m.attraction is not None], ids=lambda m: m.name
    )
    def test_a_particle_hangs_under_a_plane_that_attracts_it_enough(
        self, solver: DeckSolver, run: Run, model: ContactModel
    ) -> None:
        if solver.name not in model.solvers:
            pytest.skip(f"{solver.name} has no {model.name}")
        [name] = [p.name for p in model.parameters if p.name.startswith("particle_wall.")]
        assert model.attraction is not None
        ends = {}
        for weights in (0.6, 2.5):
            value = _attracting(model, name, weights)
            values = {**DAMPED, name: value}
            overlap = model.attraction(Contact.on_wall(values, RADIUS, GRAVITY)).overlap
            ceiling = {"ceiling": Wall(Plane("z", 0.05, upwards=False))}
            start = spheres([(0.0, 0.0, 0.05 - RADIUS + overlap)])
            found = run(
                scene_of(start, ceiling, frames(0.05), values, contact_models=(model.name,))
            )
            ends[weights] = 0.05 - RADIUS - found.snapshot("frame1").positions[0, 2]
        # Half of g t^2, or a part of the overlap.
        assert ends[0.6] > 0.004
        assert -0.1 * RADIUS < ends[2.5] < 0.0

    def test_planes_of_six_directions_meet_particles_on_the_side_of_their_normal(
        self, run: Run
    ) -> None:
        side, speed, restitution = 0.04, 0.5, 0.6
        walls, positions, velocities = {}, [], []
        for number, axis in enumerate("xyz"):
            for sign in (-1, 1):
                walls[f"{axis}{'_low' if sign < 0 else '_high'}"] = Wall(
                    Plane(axis, sign * side, upwards=sign < 0)
                )
                place, velocity = [0.0] * 3, [0.0] * 3
                place[number] = sign * (side - 2 * RADIUS)
                velocity[number] = sign * speed
                positions.append(place)
                velocities.append(velocity)
        # So little gravity that it does not matter here.
        scene = scene_of(
            spheres(positions, velocities),
            walls,
            [*frames(0.04), Stage("more", Elapsed(0.01), snapshot="later")],
            material(restitution),
            gravity=1e-3,
        )
        rebound = final_velocities(run(scene), scene)

        expected = -restitution * np.array(velocities)
        assert rebound == pytest.approx(expected, abs=0.02 * speed)

    def test_a_block_has_exact_faces_edges_and_corners(self, run: Run) -> None:
        # A region that is put together from others has no contact beside an edge until the centre
        # is below it, and then a huge one: the particle is shot away.
        half, beyond, drop = 0.03, 0.5 * RADIUS, 0.02
        over = half + beyond
        starts = [(0, 0), (over, 0), (0, -over), (over, over)]
        height = drop + RADIUS
        particles = spheres([(x, y, height) for x, y in starts])
        walls = {"block": Wall(Block((-half, -half, -0.03), (half, half, 0.0)))}
        until = math.sqrt(2 * drop / GRAVITY) + 0.015
        stages = [*frames(until), Stage("more", Elapsed(0.004), snapshot="later")]
        scene = scene_of(particles, walls, stages, STIFF)
        out = run(scene)

        sideways = np.sign(np.array(starts)) * beyond * (np.abs(starts) > half)
        normals = np.column_stack((sideways, np.zeros(4)))
        normals[:, 2] = np.sqrt(RADIUS**2 - (sideways**2).sum(axis=1))
        fall = drop + RADIUS - normals[:, 2]
        normals /= RADIUS
        energy = MASS * GRAVITY * (drop + 4 * RADIUS)
        kinetic = out.stages[-1].kinetic_energy
        final = out.snapshot("later").positions[:, 2]
        assert kinetic + WEIGHT * (final - height).sum() == pytest.approx(0, abs=0.01 * energy)
        # Elastic and smooth: the part of the velocity along the normal turns round.
        speed = np.sqrt(2 * GRAVITY * fall)
        bounced = 2 * speed[:, None] * normals[:, 2:] * normals
        found = final_velocities(out, scene)
        assert found[:, :2] == pytest.approx(bounced[:, :2], abs=0.05 * speed.max())

    def test_a_block_goes_on_along_a_periodic_axis(self, run: Run) -> None:
        box = Box((-0.1, 0.0, -0.1), (0.1, 0.03, 0.2), periodic="y")
        walls = {"shelf": Wall(Block((-0.02, 0.01, -0.03), (0.02, 0.02, 0.0)))}
        # Beside the corners of the block in y, and beside it in x.
        particles = spheres([(0, 0.001, RADIUS), (0.03, 0.015, RADIUS)])
        scene = scene_of(particles, walls, frames(0.1), DAMPED, box=box)
        positions = run(scene).snapshot("frame1").positions

        assert positions[0, 2] == pytest.approx(self.rests_at(DAMPED), abs=2e-5)
        assert positions[1, 2] == pytest.approx(RADIUS - GRAVITY * 0.1**2 / 2, abs=2e-5)

    @pytest.mark.parametrize("ends", [(0.0, 0.06), (BOX.low[2], BOX.high[2])])
    def test_a_tube_holds_two_particles_that_wedge_each_other(
        self, run: Run, ends: tuple[float, float]
    ) -> None:
        # Smooth: the lower one carries the upper one, and both press on opposite sides.
        radius = 1.6 * RADIUS
        reach = radius - RADIUS
        above = RADIUS + math.sqrt(4 * RADIUS**2 - 4 * reach**2)
        walls = {**FLOOR, "tube": Wall(Cylinder(radius, *ends))}
        columns: dict[str, Recorded] = {
            "sideways": Force("tube", "x"),
            "upwards": Force("tube", "z"),
            "floor": Force("floor", "z"),
        }
        # Programs with facets know the radial force of a tube through the box only.
        through = ends[0] <= BOX.low[2]
        if through:
            columns["outwards"] = RadialForce("tube")
        hold = Stage("hold", Elapsed(0.02), series=Series(columns, 0.001), snapshot="held")
        # Neither along an axis nor halfway between two.
        x, y = reach * math.cos(0.6), reach * math.sin(0.6)
        particles = spheres([(-x, -y, RADIUS), (x, y, above)])
        out = run(scene_of(particles, walls, [settle(), hold], DAMPED))

        lower, upper = out.snapshot("held").positions
        assert np.hypot(*lower[:2]) == pytest.approx(reach, rel=0.03)
        sideways, upwards = np.hypot(*(upper - lower)[:2]), (upper - lower)[2]
        series = means(out, "hold")
        if through:
            assert series["outwards"] == pytest.approx(2 * WEIGHT * sideways / upwards, rel=1e-2)
        assert series["floor"] == pytest.approx(-2 * WEIGHT, rel=1e-2)
        assert series["sideways"] == pytest.approx(0, abs=1e-2 * WEIGHT)
        assert series["upwards"] == pytest.approx(0, abs=1e-2 * WEIGHT)

    def test_a_particle_slides_down_a_smooth_funnel(self, run: Run) -> None:
        sine, cosine = 0.6, 0.8
        walls = {"funnel": Wall(Cone(0.012, 0.052, 0.0, 0.03))}
        start = np.array([0.044 - sine * RADIUS, 0, 0.024 + cosine * RADIUS])
        columns = {
            "down": Force("funnel", "z"),
            "sideways": Force("funnel", "x"),
        }
        stages = frames(0.08, 2, Series(columns, 0.001))
        out = run(scene_of(spheres([start.tolist()]), walls, stages, DAMPED))

        slid = GRAVITY * sine * 0.08**2 / 2
        moved = out.snapshot("frame2").positions[0] - start
        assert moved == pytest.approx([-slid * cosine, 0, -slid * sine], abs=0.03 * slid)
        series = means(out, "part2")
        assert series["down"] == pytest.approx(-WEIGHT * cosine**2, rel=0.02)
        assert series["sideways"] == pytest.approx(WEIGHT * cosine * sine, rel=0.02)

    @pytest.mark.parametrize(
        "shape",
        [Cylinder(0.03, 0.0, 0.05), Cylinder(0.03, -0.1, 0.1, "x"), Cone(0.02, 0.04, 0.0, 0.05)],
        ids=["tube", "lying tube", "funnel"],
    )
    def test_a_radial_force_that_cannot_be_had_is_refused_before_the_run(
        self, solver: DeckSolver, tmp_path: Path, shape: Shape
    ) -> None:
        series = Series({"outwards": RadialForce("side")}, 0.001)
        scene = scene_of(spheres([(0, 0, 0.1)]), {"side": Wall(shape)}, frames(0.01, series=series))
        try:
            run = solver.simulate(scene, Workspace(tmp_path, _TIMEOUT))
        except InputError as error:
            (fault,) = error.faults
            assert (fault.key, fault.remedy[:4]) == ("side", "Use ")
        else:
            assert run.series("part1")["outwards"] == pytest.approx(0)

    def test_particles_lie_on_a_disc_and_fall_beside_it(self, run: Run) -> None:
        walls = {"plate": Wall(Disc(0.03, 0.0))}
        inside, beside = [(0.001, 0), (0.029, 0), (0, -0.029)], [(-0.036, 0), (0, 0.036)]
        self._stay_and_fall(run, walls, inside, beside)

    def test_particles_lie_on_an_annulus_and_fall_through_its_orifice(self, run: Run) -> None:
        walls = {"ring": Wall(Annulus(0.0075, 0.03, 0.0))}
        self._stay_and_fall(run, walls, [(0.02, 0), (0, -0.0105)], [(0, 0), (0.037, 0)])

    def test_particles_lie_on_triangles_of_a_file(self, run: Run, tmp_path: Path) -> None:
        path = tmp_path / "a table.stl"
        table = Block((-0.02, -0.03, -0.02), (0.02, 0.03, 0.0))
        write_stl(path, triangles_of(table, BOX, 2 * RADIUS))
        walls = {"table": Wall(Mesh(path))}
        self._stay_and_fall(run, walls, [(0, 0), (0.019, -0.029)], [(0.026, 0), (0, 0.036)])

    def _stay_and_fall(
        self,
        run: Run,
        walls: Mapping[str, Wall],
        on_it: Sequence[tuple[float, float]],
        beside: Sequence[tuple[float, float]],
    ) -> None:
        """Check which of some particles at rest stay on a wall at height 0."""
        particles = spheres([(x, y, RADIUS) for x, y in (*on_it, *beside)])
        positions = (
            run(scene_of(particles, walls, frames(0.1), DAMPED)).snapshot("frame1").positions
        )

        assert positions[:, :2] == pytest.approx(particles.positions[:, :2], abs=1e-6)
        heights, fallen = positions[: len(on_it), 2], positions[len(on_it) :, 2]
        assert heights == pytest.approx(self.rests_at(DAMPED), abs=5e-6)
        assert fallen == pytest.approx(RADIUS - GRAVITY * 0.1**2 / 2, abs=2e-5)

    # --- box -----------------------------------------------------------------------------------

    def test_particles_feel_each_other_across_a_periodic_boundary(self, run: Run) -> None:
        overlap, depth, time = 0.0005, 0.05, 0.03
        box = Box((-0.1, 0.0, -0.1), (0.1, depth, 0.2), periodic="y")
        near, far = 0.0045, depth - (2 * RADIUS - overlap - 0.0045)
        particles = spheres([(0, near, 0.05), (0, far, 0.05)])
        stages = [*frames(time), Stage("more", Elapsed(0.01), snapshot="later")]
        scene = scene_of(particles, {}, stages, box=box)
        out = run(scene)

        young = particle_moduli(ELASTIC, "particle").young
        stored = 8 / 15 * young * math.sqrt(RADIUS / 2) * overlap**2.5
        speed = math.sqrt(stored / MASS)
        assert final_velocities(out, scene)[:, 1] == pytest.approx([speed, -speed], rel=5e-3)
        end = out.stages[-1]
        falling = MASS * (GRAVITY * end.time) ** 2
        assert end.kinetic_energy == pytest.approx(stored + falling, rel=5e-3)

    def test_a_bed_of_two_sizes_in_a_short_periodic_box_carries_its_weight(self, run: Run) -> None:
        sizes = ParticleSizes((2 * RADIUS, 1.4 * RADIUS), (0.7, 0.3))
        width, depth = 0.06, 0.025
        column = random_column(sizes, 60, Rectangle(width, depth), seed=3)
        sides = {
            "left": Wall(Plane("x", -width / 2)),
            "right": Wall(Plane("x", width / 2, upwards=False)),
        }
        columns = {
            "floor": Force("floor", "z"),
            "left": Force("left", "x"),
            "right": Force("right", "x"),
        }
        # No friction on walls: the sides carry no weight.
        values = material(0.3, 0.0) | {"particle_particle.sliding_friction": 0.3}
        stages = [
            Stage("fill", AtRest(3.0, at_least=0.2), is_closed=True),
            Stage("hold", Elapsed(0.02), series=Series(columns, 0.001), snapshot="bed"),
        ]
        scene = scene_of(
            column,
            {**FLOOR, **sides},
            stages,
            values,
            sizes=sizes,
            box=Box((-0.04, 0.0, -0.02), (0.04, depth, 0.3), periodic="y"),
            quiet_speed=1e-3,
            time_step=time_step(sizes, values, 0.1),
        )
        out = run(scene)

        bed = out.snapshot("bed")
        weight = bed.masses.sum() * GRAVITY
        assert len(bed) == 60
        assert weight == pytest.approx(scene.mass * GRAVITY, rel=1e-2)
        assert sorted(set(bed.radii.round(6))) == pytest.approx([0.7 * RADIUS, RADIUS])
        assert (np.abs(bed.positions[:, 0]) < width / 2).all()
        assert ((bed.positions[:, 1] > -1e-6) & (bed.positions[:, 1] < depth + 1e-6)).all()
        series = means(out, "hold")
        assert series["floor"] == pytest.approx(-weight, rel=1e-2)
        assert series["left"] < 0 < series["right"]

    # --- surfaces ------------------------------------------------------------------------------

    def test_each_surface_has_its_own_restitution(self, run: Run) -> None:
        drop, restitutions = 0.02, {"wall": 0.5, "felt": 0.3, "steel": 0.8}
        surfaces = {
            name: {"particle_wall.restitution": value}
            for name, value in restitutions.items()
            if name != "wall"
        }
        values = {**material(0.5), "particle.youngs_modulus": 1e8}
        stages = [*frames(0.074), Stage("more", Elapsed(0.004), snapshot="later")]
        scene = scene_of(
            self._one_on_each(drop),
            self._three_tables(restitutions),
            stages,
            values,
            surfaces=surfaces,
        )
        out = run(scene)

        speeds = final_velocities(out, scene)[:, 2]
        halfway = [out.snapshot(name).positions[:, 2] for name in ("frame1", "later")]
        rebound = np.mean(halfway, axis=0) - RADIUS + speeds**2 / (2 * GRAVITY)
        expected = [value**2 * drop for value in restitutions.values()]
        assert rebound == pytest.approx(expected, rel=0.05)

    def test_each_surface_has_its_own_sliding_friction(self, run: Run) -> None:
        speed, frictions = 0.5, {"wall": 0.2, "felt": 0.3, "steel": 0.1}
        surfaces = {
            name: {"particle_wall.sliding_friction": value}
            for name, value in frictions.items()
            if name != "wall"
        }
        stages = frames(0.04, 4)
        particles = self._one_on_each(-resting_overlap(DAMPED, curve=self.wall_radius))
        particles = replace(particles, velocities=np.array([[speed, 0.0, 0.0]] * 3))
        scene = scene_of(
            particles, self._three_tables(frictions), stages, material(0.3, 0.2), surfaces=surfaces
        )
        out = run(scene)

        # They slide all the time: 2 v / (7 mu g) is longer.
        ways = [out.snapshot(f"frame{n}").positions[:, 0] for n in (1, 2, 3, 4)]
        times = [end.time for end in out.stages]
        early = (ways[1] - ways[0]) / (times[1] - times[0])
        late = (ways[3] - ways[2]) / (times[3] - times[2])
        passed = (times[3] + times[2] - times[1] - times[0]) / 2
        lost = [friction * GRAVITY * passed for friction in frictions.values()]
        # LIGGGHTS brakes a sliding particle by a few mm/s more, once about every two diameters.
        assert early - late == pytest.approx(lost, abs=0.004)

    @staticmethod
    def _three_tables(surfaces: Sequence[str] | Mapping[str, float]) -> dict[str, Wall]:
        return {
            f"table_{name}": Wall(Block((-0.05, y - 0.01, -0.02), (0.05, y + 0.01, 0.0)), name)
            for name, y in zip(surfaces, (-0.04, 0.0, 0.04), strict=True)
        }

    @staticmethod
    def _one_on_each(height: float) -> Column:
        return spheres([(-0.03, y, RADIUS + height) for y in (-0.04, 0.0, 0.04)])

    # --- motions -------------------------------------------------------------------------------

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

    def test_a_load_that_is_not_reached_fails_the_run(self, run: Run) -> None:
        walls = {**FLOOR, "piston": Wall(Plane("z", 0.08, upwards=False))}
        piston = Load("z", -WEIGHT, largest_speed=0.1, gain=1.0)
        press = Stage("press", Loaded("piston", 0.01, 0.1), motions={"piston": piston})
        out = run(scene_of(spheres([(0, 0, RADIUS)]), walls, [press], DAMPED))

        assert [end.end for end in out.stages] == ["unloaded"]
        with pytest.raises(RunFailedError, match="load was not reached"):
            out.require_complete(["press"], "pot")

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
        with pytest.raises(RunFailedError, match="broke out of the pot"):
            out.require_complete(["fill", "after"], "pot")

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
