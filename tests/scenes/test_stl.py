"""Walls from STL files: reading, sanity, division for periodic boxes, and real runs."""

from __future__ import annotations

import re
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.errors import InputError
from grainfit.messages import Message
from grainfit.scenes import messages
from grainfit.scenes.conditions import AtRest
from grainfit.scenes.packing import Round, random_column
from grainfit.scenes.scene import Box, Scene, Stage, Wall, time_step
from grainfit.scenes.scene_faults import scene_faults
from grainfit.scenes.shapes import Block, Cone, Cylinder, Disc, Mesh
from grainfit.scenes.stl import Triangles, divided, mesh_faults, mesh_triangles, read_stl
from grainfit.scenes.triangles import triangles_of, write_stl
from grainfit.scenes.wall_distances import distances
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import GLASS_BEADS
from grainfit.testing.simulated_scenes import DAMPED, RADIUS, SIZES, resting_overlap, spheres

BOX = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.2))
TABLE = Block((-0.05, -0.04, -0.05), (0.05, 0.04, 0.02))
NEEDS_LIGGGHTS = needs.LIGGGHTS


def binary(path: Path, triangles: Triangles) -> Path:
    """Write a binary STL file."""
    facets = [struct.pack("<12fH", 0, 0, 1, *t.ravel(), 0) for t in triangles]
    path.write_bytes(b"solid in binary".ljust(80) + struct.pack("<I", len(facets)))
    with path.open("ab") as file:
        file.writelines(facets)
    return path


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """A closed block in a text file in mm."""
    write_stl(tmp_path / "table.stl", 1000 * triangles_of(TABLE, BOX, RADIUS))
    return tmp_path / "table.stl"


def test_text_and_binary_files_have_the_same_triangles(table: Path, tmp_path: Path) -> None:
    text = read_stl(table)
    packed = read_stl(binary(tmp_path / "packed.stl", text.triangles))

    assert len(text.triangles) == 12
    np.testing.assert_allclose(packed.triangles, text.triangles, rtol=1e-6)
    assert text.is_closed
    assert packed.is_closed
    assert text.size == pytest.approx(100.0)
    open_ = read_stl(binary(tmp_path / "open.stl", text.triangles[:-1]))
    assert not open_.is_closed


def test_text_files_mean_the_same_however_they_are_written(table: Path, tmp_path: Path) -> None:
    triangles = read_stl(table).triangles
    text = table.read_text()
    long = re.sub(r"(?<=vertex )(\S+)", lambda x: f"{float(x[1]):.40f}e000", text)
    assert long != text
    for number, content in enumerate((text.upper(), "\ufeff" + text, long)):
        file = tmp_path / f"{number}.stl"
        file.write_text(content, encoding="utf-8", newline="\r\n")
        np.testing.assert_array_equal(read_stl(file).triangles, triangles)


def test_triangles_without_an_area_are_left_out(tmp_path: Path) -> None:
    good = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    needle = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=float)
    found = read_stl(binary(tmp_path / "some.stl", np.array([good, needle])))

    assert (len(found.triangles), found.left_out) == (1, 1)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", messages.MESH_NO_STL),
        (b"PK\x03\x04" + bytes(200), messages.MESH_CUT_OFF),
        (b"solid x\nendsolid x\n" + b" " * 100, messages.MESH_CUT_OFF),
        (b"solid x\nfacet normal 0 0 1\nendsolid x\n" + b" " * 100, messages.MESH_EMPTY),
        (
            b"solid x\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\nendsolid" + b" " * 100,
            messages.MESH_DAMAGED,
        ),
        (
            b"solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 b 0\nendfacet" + b" " * 100,
            messages.MESH_CORNERS,
        ),
        (
            b"solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 nan 0\nendfacet" + b" " * 100,
            messages.MESH_CORNERS,
        ),
        (
            b"solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 2 0 0\nendfacet" + b" " * 100,
            messages.MESH_FLAT,
        ),
    ],
)
def test_a_file_that_is_no_wall_is_refused_by_name(
    tmp_path: Path, content: bytes, message: Message
) -> None:
    path = tmp_path / "wall.stl"
    path.write_bytes(content)

    with pytest.raises(InputError, match=message.pattern) as caught:
        read_stl(path)

    assert caught.value.source == str(path)
    assert all(fault.remedy for fault in caught.value.faults)


def test_a_cut_off_file_and_a_missing_one_are_refused(table: Path, tmp_path: Path) -> None:
    whole = binary(tmp_path / "whole.stl", read_stl(table).triangles).read_bytes()
    (tmp_path / "half.stl").write_bytes(whole[:-70])

    with pytest.raises(InputError, match=re.escape(messages.MESH_CUT_OFF(count=12))):
        read_stl(tmp_path / "half.stl")
    for path in (tmp_path / "none.stl", tmp_path):
        with pytest.raises(InputError, match=messages.MESH_UNREADABLE.pattern):
            read_stl(path)


def test_a_file_that_changes_is_read_again(table: Path, tmp_path: Path) -> None:
    assert len(read_stl(table).triangles) == 12

    write_stl(table, triangles_of(Disc(0.05, 0.0), BOX, RADIUS))

    assert len(read_stl(table).triangles) == 40


@pytest.mark.parametrize("periodic", ["", "y"])
@pytest.mark.parametrize(
    ("scale", "shift", "message"),
    [
        (1.0, 0.0, messages.MESH_SIZE(name="table.stl", size=100, room=0.3)),
        (1e-7, 0.0, messages.MESH_SIZE(name="table.stl", size=1e-5, room=0.3)),
        (0.001, 500.0, messages.MESH_ELSEWHERE(name="table.stl")),
        (0.0, 0.0, messages.MESH_SCALE(scale=0.0)),
    ],
)
def test_another_unit_and_another_place_are_seen(
    table: Path, scale: float, shift: float, message: str, periodic: str
) -> None:
    write_stl(table, read_stl(table).triangles + shift)
    box = replace(BOX, periodic=periodic)

    (fault,) = mesh_faults("wall hopper", Mesh(table, scale), box)

    assert str(fault) == f"wall hopper: {message}"
    assert list(mesh_faults("wall hopper", Mesh(table, 0.001), box)) == [] or shift


def test_a_mesh_that_needs_too_many_triangles_is_named(tmp_path: Path) -> None:
    floor = tmp_path / "floor.stl"
    write_stl(floor, np.array([[[0, 0, 0], [1900, 0, 0], [1900, 0.08, 0]]]))
    box = Box((0.0, 0.0, -1.0), (2000.0, 0.08, 1.0), periodic="y")

    (fault,) = mesh_faults("wall floor", Mesh(floor), box)

    assert fault.message == f"floor.stl {messages.MESH_PERIOD.text}"


def test_triangles_in_a_periodic_box_are_short_and_cover_the_same_area(table: Path) -> None:
    periodic = Box((-0.1, -0.04, -0.1), (0.1, 0.04, 0.2), periodic="y")
    before = mesh_triangles(Mesh(table, 0.001), BOX)
    after = mesh_triangles(Mesh(table, 0.001), periodic)

    def areas(triangles: Triangles) -> float:
        sides = triangles[:, 1:] - triangles[:, :1]
        return float(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum() / 2)

    sides = np.linalg.norm(after - np.roll(after, 1, axis=1), axis=2)
    assert sides.max() <= periodic.longest_element == pytest.approx(0.02)
    # The two ends of the table lie in the periodic sides, where it goes on.
    assert areas(after) == pytest.approx(areas(before) - 2 * 0.1 * 0.07, rel=1e-9)
    narrow = Box((-0.1, -0.03, -0.1), (0.1, 0.03, 0.2), periodic="y")
    (fault,) = mesh_faults("wall table", Mesh(table, 0.001), narrow)
    assert fault == messages.MESH_BEYOND_PERIOD.fault("wall table", name="table.stl", axis="y")
    (fault,) = mesh_faults("wall table", Mesh(table, 0.001), replace(narrow, periodic=""))
    assert fault == messages.MESH_BEYOND.fault("wall table", name="table.stl", axis="y")
    with pytest.raises(InputError, match=messages.MESH_PERIOD.pattern):
        divided(before, 1e-5)


def settled(walls: dict[str, Wall], particles, box: Box, height: float = 2.0) -> Scene:
    """Return a scene that ends when its particles are at rest."""
    return Scene(
        title="Particles on a wall from an STL file",
        material=DAMPED,
        sizes=SIZES,
        particles=particles,
        box=box,
        walls=walls,
        stages=(Stage("settle", AtRest(height, at_least=0.02), snapshot="rest"),),
        gravity=9.81,
        time_step=time_step(SIZES, DAMPED, 0.1),
        quiet_speed=1e-3,
        check_interval=0.01,
    )


def test_distances_from_a_file_are_those_from_its_block(table: Path) -> None:
    places = np.random.default_rng(1).uniform(BOX.low, BOX.high, (500, 3))

    found = distances(Mesh(table, 0.001), BOX, places, 0.05)

    expected = np.abs(distances(TABLE, BOX, places, 0.05))
    np.testing.assert_allclose(found[expected < 0.05], expected[expected < 0.05], atol=1e-12)
    assert (found[expected >= 0.05] >= 0.05).all()
    assert 100 < (expected < 0.05).sum() < 500


@pytest.mark.parametrize("above", [0.95, 1.0])
def test_a_particle_that_begins_in_a_file_is_refused(table: Path, above: float) -> None:
    beads = spheres([[0.011, 0.007, 0.02 + above * RADIUS], [0.0, 0.0, 0.1]])

    found = scene_faults(settled({"table": Wall(Mesh(table, 0.001))}, beads, BOX))

    assert len(found) == (above < 1)
    assert all(messages.IN_WALL.is_in(str(fault), caught=1, count=2) for fault in found)


@NEEDS_LIGGGHTS
@pytest.mark.parametrize("periodic", ["", "y"])
def test_a_particle_rests_on_a_file_in_mm_at_the_height_of_hertz(
    table: Path, tmp_path: Path, periodic: str
) -> None:
    box = Box((-0.1, -0.04, -0.1), (0.1, 0.04, 0.2), periodic)
    bead = spheres([[0.011, 0.007, 0.02 + 1.01 * RADIUS]])
    solver = Liggghts(Heap(diameter="10 mm"), GLASS_BEADS)

    run = solver.simulate(
        settled({"table": Wall(Mesh(table, 0.001))}, bead, box), Workspace(tmp_path, timeout=60.0)
    )

    run.require_good()
    overlap = 0.02 + RADIUS - run.snapshot("rest").positions[0, 2]
    assert overlap == pytest.approx(resting_overlap(DAMPED), rel=0.02)


@NEEDS_LIGGGHTS
def test_a_hopper_from_a_file_empties(tmp_path: Path) -> None:
    hopper = Cone(5 * RADIUS, 10 * RADIUS, 0.0, 8 * RADIUS)
    triangles = triangles_of(hopper, BOX, 2 * RADIUS)
    path = binary(tmp_path / "a hopper.stl", 1000 * triangles)
    beads = random_column(SIZES, 60, Round(5 * RADIUS), seed=1)
    beads.positions[:, 2] += 2 * RADIUS
    box = Box((-0.1, -0.1, -0.05), (0.1, 0.1, 0.4))
    walls = {"hopper": Wall(Mesh(path, 0.001)), "floor": Wall(Disc(0.09, -0.04))}
    walls["rim"] = Wall(Cylinder(0.085, -0.04, 0.01))
    solver = Liggghts(Heap(diameter="10 mm"), GLASS_BEADS)

    scene = replace(settled(walls, beads, box), material=GLASS_BEADS, quiet_speed=0.01)
    run = solver.simulate(scene, Workspace(tmp_path, timeout=60.0))

    run.require_good()
    left = run.snapshot("rest").positions
    # They lie on the floor below the hopper.
    assert len(left) == 60
    assert left[:, 2].max() < 0


def test_lammps_refuses_an_stl_file_and_says_what_to_use(table: Path, tmp_path: Path) -> None:
    bead = spheres([[0.0, 0.0, 0.03]])
    scene = settled({"table": Wall(Mesh(table, 0.001))}, bead, BOX)

    with pytest.raises(InputError, match='no friction on walls from STL files; use solver = "lig'):
        Lammps(Heap(diameter="10 mm"), GLASS_BEADS).simulate(scene, Workspace(tmp_path))
