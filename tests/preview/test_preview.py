"""Preview: what is drawn is where the scene has it, in words and in both pictures."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import needs
from benchmarks.axe import violations_in
from grainfit.bulk_tests.outline import concepts
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.starter import starter_file
from grainfit.cli.app import app
from grainfit.errors import InputError
from grainfit.formatting import millimetres
from grainfit.materials.sizes import ParticleSizes
from grainfit.preview import messages
from grainfit.preview.geometry import feature_edges, geometry_of
from grainfit.preview.page import preview_page
from grainfit.preview.preview import preview_tests, write_preview
from grainfit.preview.scene_picture import COLOURS, draw_geometry
from grainfit.preview.scene_text import motion_text, stage_text, wall_text
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.glued import Glued
from grainfit.scenes.scene import Box, Load, Rotation, Scene, Stage, Velocity, Wall
from grainfit.scenes.shapes import Block, Cylinder, Plane
from grainfit.scenes.triangles import triangles_of
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import GLASS_BEADS
from grainfit.testing.simulated_scenes import spheres

BLADE = Path(__file__).parents[2] / "examples" / "blade" / "calibration.toml"
BOX = Box((-0.1, -0.1, -0.05), (0.12, 0.1, 0.2))


def scene(walls: dict[str, Wall], *stages: Stage, positions=((0.0, 0.0, 0.02),)) -> Scene:
    return Scene(
        title="A few beads",
        material=GLASS_BEADS,
        sizes=ParticleSizes((0.02,)),
        particles=spheres(positions),
        box=BOX,
        walls=walls,
        stages=stages or (Stage("fill", AtRest(1.0)),),
        gravity=9.81,
        time_step=1e-4,
        quiet_speed=1e-3,
        check_interval=0.01,
    )


def test_edges_are_those_of_the_shape_and_not_of_its_triangles() -> None:
    block = triangles_of(Block((-0.05,) * 3, (0.05, 0.05, 0.15)), BOX, 0.01)
    edges = feature_edges(block, 0.2)
    # The lower face lies outside of the box, and is not there: its edges are borders.
    assert len(edges) == 12
    assert np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1).max() == pytest.approx(0.2)

    tube = triangles_of(Cylinder(0.05, 0.0, 0.1), BOX, 0.01)
    heights = feature_edges(tube, 0.2)[:, :, 2]
    assert np.ptp(heights, axis=1).max() < 1e-9
    assert set(np.round(heights.ravel(), 6)) == {0.0, 0.1}


def test_walls_have_their_state_and_the_arrows_of_their_motions() -> None:
    drawn = geometry_of(
        scene(
            {"floor": Wall(Plane("z", 0.01)), "side": Wall(Plane("x", -0.1))},
            Stage("push", Elapsed(1.0), motions={"side": Velocity("x", -0.2)}),
            Stage(
                "press",
                Elapsed(1.0),
                put={"lid": Wall(Plane("z", 0.1, upwards=False))},
                motions={"lid": Load("z", -3.0, 0.1, 1.0)},
            ),
            Stage("shut", Elapsed(1.0), put={"door": Wall(Plane("y", 0.1))}),
        )
    )
    walls = {wall.name: wall for wall in drawn.walls}

    assert [wall.state for wall in drawn.walls] == ["still", "moving", "moving", "later"]
    for name, direction in (("side", [-1, 0, 0]), ("lid", [0, 0, -1])):
        ((start, end),) = walls[name].arrows
        np.testing.assert_allclose((end - start) / np.linalg.norm(end - start), direction)
    assert len(walls["floor"].arrows) == len(walls["door"].arrows) == 0
    # The lowest point of everything is at z = 0, and the middle is on the z axis.
    corners = drawn.corners
    assert corners[:, 2].min() == pytest.approx(0.0)
    assert corners[:, 0].min() == pytest.approx(-corners[:, 0].max())


def test_glued_particles_are_drawn_in_the_colour_of_what_they_do() -> None:
    plate = np.array([[x, 0.0, 0.1] for x in (-0.04, -0.02, 0.0, 0.02, 0.04)])
    body = Glued(plate, np.zeros(5, dtype=np.int64))
    still = replace(scene({"floor": Wall(Plane("z", 0.01))}), glued={"plate": body})
    push = Stage("push", Elapsed(1.0), motions={"plate": Velocity("x", 0.2)})

    def strong(experiment: Scene) -> int:
        picture = np.asarray(draw_geometry(geometry_of(experiment), 400), dtype=float)
        return int(((picture[..., 0] - picture[..., 2]) > 120).sum())

    (drawn,) = geometry_of(replace(still, stages=(push,))).glued
    assert (drawn.state, len(drawn.radii)) == ("moving", 5)
    ((start, end),) = drawn.arrows
    np.testing.assert_allclose((end - start) / np.linalg.norm(end - start), [1, 0, 0])
    assert start[0] == pytest.approx(drawn.positions[:, 0].max())
    # Vermilion has much red and no blue; the one loose bead is yellow in both.
    assert strong(replace(still, stages=(push,))) > 2 * strong(still) > 0


def test_a_wall_hides_nothing_but_is_seen_and_a_particle_hides_the_wall_behind_it() -> None:
    def pixels(wall: Wall) -> np.ndarray:
        found = draw_geometry(geometry_of(scene({"wall": wall})), 400)
        return np.asarray(found, dtype=float)

    def blue(picture: np.ndarray) -> int:
        return int(((picture[..., 2] - picture[..., 0]) > 40).sum())

    behind = pixels(Wall(Plane("y", 0.09)))
    before = pixels(Wall(Plane("y", -0.09)))

    # The bead is drawn in dark blue, or in yellow when it is the highest: it is the only one.
    def bead(picture: np.ndarray) -> int:
        return int(((picture[..., 0] - picture[..., 2]) > 90).sum())

    assert bead(behind) > 300
    assert 0 < bead(before) <= bead(behind)
    slate = np.abs(behind - (0.34 * np.array(COLOURS["still"]) + 0.66 * 255)).max(axis=-1) < 40
    assert (slate & (behind.max(axis=-1) < 250)).sum() > 2000
    assert blue(behind) == blue(before) == 0


@dataclass(frozen=True)
class Star:
    """A shape that no solver has."""

    points: int


@dataclass(frozen=True)
class Turning:
    """A motion that this version does not know."""

    turns: float
    along: str = "y"


def test_a_shape_and_a_motion_of_the_future_are_named_with_their_values() -> None:
    known = scene({"floor": Wall(Plane("z", 0.0)), "star": Wall(Star(5))})  # type: ignore[arg-type]

    assert geometry_of(known).not_drawn == ("star",)
    assert wall_text(known.walls["star"]) == "star: points 5"
    assert motion_text(Turning(2.5)) == "turning: turns 2.5, along y"
    turns = motion_text(Rotation("y", 0.5))
    assert turns == "turns at 4.77 rpm about the y axis"
    moving = Stage("turn", Elapsed(2.0), motions={"floor": Turning(2.5)})  # type: ignore[dict-item]
    assert stage_text(moving) == "floor turning: turns 2.5, along y; for 2 s"
    (floor,) = geometry_of(replace(known, stages=(moving,))).walls
    assert (floor.state, len(floor.arrows)) == ("moving", 0)


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_test_of_the_bench_has_a_preview(tmp_path: Path, name: str) -> None:
    path = tmp_path / "one.toml"
    lacks = concepts(BUILT_IN[name](diameter="10 mm")) & set(Liggghts.missing)
    program = "lammps" if lacks else "liggghts"
    path.write_text(starter_file([name]).replace('solver = "lammps"', f'solver = "{program}"'))
    setup = load_calibration(path)
    values = setup.values([])
    (found,) = preview_tests(setup.solvers, values, 1)

    text = preview_page(setup.name, [found], values, {})
    picture = draw_geometry(found.geometry, 200)

    assert found.cost is not None
    glued = sum(len(body.positions) for body in found.scene.glued.values())
    assert found.cost.particles == len(found.geometry.radii) + glued
    assert found.geometry.not_drawn == ()
    assert len(picture.getcolors(10**7) or ()) > 200
    for wall in found.scene.all_walls():
        assert f"<strong>{wall}</strong>" in text
    for stage in found.scene.stages:
        assert f"<strong>{stage.name}</strong>: {stage_text(stage)}" in text
    data = json.loads(re.search(r'id="data-particles">(.*?)</script>', text, re.DOTALL)[1])
    table = np.frombuffer(base64.b64decode(data["test-1"]["particles"]), "<i2").reshape(-1, 4)
    step = found.geometry.radii[0] / table[0, 3]
    np.testing.assert_allclose(table[:, :3] * step, found.geometry.positions, atol=0.002)
    sets = data["test-1"]["glued"]
    for drawn_set, body in zip(sets, found.geometry.glued, strict=True):
        glued_table = np.frombuffer(base64.b64decode(drawn_set["particles"]), "<i2")
        placed = glued_table.reshape(-1, 4)[:, :3] * step
        np.testing.assert_allclose(placed, body.positions, atol=0.002)
    for body_name in found.scene.glued:
        assert f"<strong>{body_name}</strong>" in text
    lines = data["test-1"]["dimensions"]
    shown = {words for _, _, words in lines}
    for wall in found.scene.all_walls().values():
        if isinstance(wall.shape, Cylinder):
            assert f"⌀ {millimetres(2 * wall.shape.radius)}" in shown
    walls = data["test-1"]["walls"]
    assert len(walls) == len(found.geometry.walls)
    for wall, drawn in zip(walls, found.geometry.walls, strict=True):
        corners = np.frombuffer(base64.b64decode(wall["triangles"]), "<i2") * step
        np.testing.assert_allclose(corners, drawn.triangles.ravel(), atol=0.002)


def test_the_command_writes_page_and_picture_of_a_scene_of_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    done = CliRunner().invoke(app, ["preview", str(BLADE)])

    assert done.exit_code == 0, done.output
    assert "Test scene, lammps: 310 particles" in " ".join(done.output.split())
    assert {path.name for path in tmp_path.iterdir()} == {
        "calibration.preview.html",
        "calibration.preview.png",
    }
    with Image.open(tmp_path / "calibration.preview.png") as image:
        assert image.size[0] > 800
        assert len(image.getcolors(10**7) or ()) > 500
    text = (tmp_path / "calibration.preview.html").read_text()
    assert "blade moves along x at 100 mm/s" in text
    assert not re.search(r"https?://", text)


def test_a_test_is_drawn_before_it_is_measured(tmp_path: Path) -> None:
    plan, page = tmp_path / "plan.toml", tmp_path / "plan.html"
    text = starter_file(["heap"])
    without = "\n".join(line for line in text.splitlines() if not line.startswith("targets."))
    plan.write_text(without)
    sliding = "particle_particle.sliding_friction=0.45"

    done = CliRunner().invoke(app, ["preview", str(plan), "-o", str(page), "--set", sliding])

    assert done.exit_code == 0, done.output
    assert "0.45" in page.read_text()
    plan.write_text(without.replace('type = "heap"', 'type = "heap"\nrepeat = 0'))
    wrong = CliRunner().invoke(app, ["preview", str(plan)])
    assert isinstance(wrong.exception, InputError)
    (fault,) = wrong.exception.faults
    assert "repeats" in str(fault)


def test_the_name_of_a_picture_is_that_of_the_picture(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["preview", str(BLADE), "-o", str(tmp_path / "blade.png")])

    assert done.exit_code == 0, done.output
    assert {path.name for path in tmp_path.iterdir()} == {"blade.html", "blade.png"}
    with Image.open(tmp_path / "blade.png") as image:
        assert image.size[0] > 800


@needs.CHROMIUM
def test_the_page_breaks_no_rule_of_accessibility(tmp_path: Path) -> None:
    file, page = tmp_path / "two.toml", tmp_path / "two.html"
    # The shear test has glued particles and walls of every kind.
    file.write_text(starter_file(["heap", "shear"]))
    setup = load_calibration(file)
    values = setup.values([])
    write_preview(page, setup.name, preview_tests(setup.solvers, values, 1), values, {})

    assert page.read_text().count("<canvas") == 2
    assert violations_in(page) == []


def test_a_file_without_a_scene_and_a_place_that_cannot_be_written_are_said(
    tmp_path: Path,
) -> None:
    path = tmp_path / "own.toml"
    (tmp_path / "model.py").write_text("def simulate(parameters, seed): return {'a': 1.0}")
    path.write_text(
        'name = "own"\n[parameters]\nx = { min = 1.0, max = 2.0 }\n[[test]]\ntype = "python"\n'
        'function = "model.py:simulate"\ntargets.a = { value = 1.0 }\n'
    )
    setup = load_calibration(path)
    with pytest.raises(InputError, match=messages.NO_SCENE.pattern):
        preview_tests(setup.solvers, setup.values([]), 1)
    blade = load_calibration(BLADE)
    values = blade.values([])
    tests = preview_tests(blade.solvers, values, 1)
    with pytest.raises(InputError, match=messages.CANNOT_BE_WRITTEN.pattern):
        write_preview(tmp_path / "no" / "a.html", "x", tests, values, {})
