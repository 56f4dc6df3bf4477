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

from pathlib import Path

import numpy as np
import pytest

from grainfit.errors import InputError
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import Rectangle, random_column
from grainfit.scenes.records import Force, KineticEnergy, MassAbove, Recorded, Series
from grainfit.scenes.run_output import STAGES, series_file
from grainfit.scenes.scene import Load, Rotation, Stage, Velocity, Wall
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Mesh, Plane, Shape
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver
from grainfit.testing.motion_contract import MotionContract
from grainfit.testing.simulated_scenes import (
    FLOOR,
    GRAVITY,
    MASS,
    RADIUS,
    SIZES,
    Run,
    frames,
    scene_of,
    settle,
    spheres,
)
from grainfit.testing.stage_contract import StageContract
from grainfit.testing.wall_contract import WallContract


class SceneContract(WallContract, MotionContract, StageContract):
    """Every concept of scenes against a closed form; subclasses define the program."""

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
        shapes = {"plane", "block", "prism", "cylinder", "cone", "disc", "annulus", "mesh"}
        shapes.add("lying cylinder")
        motions = {"velocity", "load", "velocity and load", "load on an area", "rotation"}
        others = {"glued", "frames", "clumps", "friction of a stage"}
        axes = {f"periodic {axes}" for axes in ("x", "y", "z", "xy", "xz", "yz", "xyz")}

        assert set(solver.missing) <= shapes | motions | axes | others

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
