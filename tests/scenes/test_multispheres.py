"""Decks of clumps for LIGGGHTS: templates, places, and what is struck off."""

from __future__ import annotations

import math
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import needs
from grainfit.measurement.particles import read_dump
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.packing import Rectangle, random_column
from grainfit.scenes.records import MassAbove, Series
from grainfit.scenes.scene import Box, Scene, Stage
from grainfit.solvers.dem.liggghts import multispheres
from grainfit.solvers.dem.liggghts.multispheres import INSERTION
from grainfit.solvers.dem.liggghts.scene_deck import LiggghtsSceneDeck
from grainfit.testing.clump_contract import PAIR, PIN, clumps
from grainfit.testing.glued_contract import glued
from grainfit.testing.simulated_scenes import FLOOR, MASS, RADIUS, scene_of, settle, spheres


def written(scene: Scene, folder: Path) -> dict[str, str]:
    folder.mkdir(exist_ok=True)
    LiggghtsSceneDeck(scene, folder).write()
    return {path.name: path.read_text() for path in folder.iterdir() if path.is_file()}


def joined(text: str) -> str:
    """Return a deck with each command on one line."""
    return re.sub(r" &\n\s+", " ", text)


def after(word: str, line: str, count: int) -> list[float]:
    """Return the numbers that follow a word."""
    return [float(value) for value in line.split(f" {word} ")[1].split()[:count]]


def test_templates_have_mass_and_inertia_of_the_union(tmp_path: Path) -> None:
    scene = scene_of(clumps([(0, 0, 0.1)]), FLOOR, [settle()], sizes=PIN)
    deck = joined(written(scene, tmp_path)["in.liggghts"])

    (template,) = re.findall("fix .* particletemplate/multisphere .*", deck)
    clump = PIN.clump
    assert clump is not None
    moments = MASS * (2 * RADIUS) ** 2 * np.array(clump.moments)
    assert after("mass", template, 1) == pytest.approx([MASS])
    tensor = after("inertia_tensor", template, 6)
    assert tensor == pytest.approx([moments[0], 0, 0, moments[1], 0, moments[2]])
    balls = np.array(after("spheres", template, 8)).reshape(2, 4)
    assert balls[:, :3] == pytest.approx(2 * RADIUS * clump.positions)
    assert balls[:, 3] == pytest.approx(2 * RADIUS * clump.radii)


def test_every_clump_is_inserted_where_the_scene_has_it(tmp_path: Path) -> None:
    start = random_column(PAIR, 7, Rectangle(0.06, 0.05), seed=3)
    scene = scene_of(start, FLOOR, [settle()], sizes=PAIR)
    text = joined(written(scene, tmp_path)["clumps.liggghts"])

    regions = [after("block", line, 6) for line in re.findall("region .* block .*", text)]
    places = np.array(regions).reshape(-1, 3, 2)
    assert places.mean(axis=2) == pytest.approx(start.positions, abs=1e-15)
    assert np.ptp(places, axis=2).max() < 1e-8 * RADIUS
    fixes = re.findall("fix .* insert/pack .*", text)
    scalar_first = np.array([after("orientation constant", line, 4) for line in fixes])
    turned = Rotation.from_quat(np.roll(scalar_first, -1, axis=1))
    error = turned * Rotation.from_quat(start.turns).inv()
    assert error.magnitude() == pytest.approx(np.zeros(7), abs=1e-9)
    assert len(re.findall("unfix", text)) == len(re.findall("delete", text)) == 7


def test_few_fixes_are_there_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Or LIGGGHTS takes half an hour to insert 55,000 clumps."""
    monkeypatch.setattr(multispheres, "_TOGETHER", 3)
    scene = scene_of(random_column(PAIR, 7, Rectangle(0.06, 0.05), 3), {}, [settle()], sizes=PAIR)
    text = joined(written(scene, tmp_path)[INSERTION])

    words = [line.split()[:2] for line in text.splitlines()]
    there: set[str] = set()
    inserted: list[set[str]] = []
    for word, name in words:
        if word == "fix":
            there.add(name)
        elif word == "run":
            inserted.append(set(there))
        elif word == "unfix":
            there.remove(name)
    assert [len(names) for names in inserted] == [3, 3, 1]
    assert len(set.union(*inserted)) == 7
    assert there == set()


@pytest.mark.slow
@needs.LIGGGHTS
def test_clumps_that_come_in_groups_fly_as_those_that_come_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = [(0.03 * n - 0.06, 0.0, 0.1) for n in range(5)]
    start = clumps(places, [0.4] * 5, [(0.1, -0.2, 0.3)] * 5, [(4, 5, 6)] * 5)
    scene = scene_of(start, {}, [Stage("fly", Elapsed(0.02), snapshot="end")], sizes=PAIR)
    found = []
    for number in (2, 5):
        monkeypatch.setattr(multispheres, "_TOGETHER", number)
        folder = tmp_path / str(number)
        written(scene, folder)
        subprocess.run(["liggghts", "-in", "in.liggghts"], cwd=folder, check=True, text=True)
        found.append(read_dump(folder / "snapshots" / "end.dump").positions)

    assert len(found[0]) == 10
    assert np.array_equal(*found)


def test_velocities_and_spins_are_those_of_the_scene(tmp_path: Path) -> None:
    start = clumps([(0, 0, 0.1)], [0.4], [(0.1, -0.2, 0.3)], [(4, 5, 6)])
    scene = scene_of(start, FLOOR, [settle()], sizes=PAIR)
    text = joined(written(scene, tmp_path)["clumps.liggghts"])

    assert after("vel constant", text, 3) == [0.1, -0.2, 0.3]
    assert after("omega constant", text, 3) == [4, 5, 6]


def test_the_centre_decides_what_is_struck_off(tmp_path: Path) -> None:
    body = glued([(x, 0.0, 0.0) for x in (-0.01, 0.01)])
    stages = [Stage("one", Elapsed(0.01), strike_off=0.05), settle()]
    start = clumps([(0, 0, 0.1), (0.03, 0, 0.1)])
    files = written(scene_of(start, {}, stages, sizes=PIN, glued={"plate": body}), tmp_path)

    assert re.search("height +equal 0.05", files["in.liggghts"])
    # The glued spheres have the first numbers.
    sums = re.findall(r"\((.*)\)>\$\{height\}", files["surplus.liggghts"])
    numbers = [re.findall(r"z\[(\d+)\]", terms) for terms in sums]
    assert numbers == [["3", "4"], ["5", "6"]]
    clump = PIN.clump
    assert clump is not None
    weights = np.array([float(term.split("*")[0]) for term in sums[0].split("+")])
    assert weights.sum() == pytest.approx(1)
    assert weights @ clump.positions == pytest.approx([0, 0, 0], abs=1e-9)
    assert re.findall(r"set atom (\S+)", files["surplus.liggghts"]) == ["3*4", "5*6"]


def test_looks_of_a_stage_follow_each_other_without_a_setup(tmp_path: Path) -> None:
    again = Stage("again", AtRest(1.0))
    deck = written(scene_of(clumps([(0, 0, 0.1)]), FLOOR, [settle(), again], sizes=PAIR), tmp_path)[
        "in.liggghts"
    ]

    looks = [line for line in deck.splitlines() if line.startswith("run")]
    # Insertion, the first count, and of each stage: the run before the first look, and the others.
    assert [re.sub(r"\d\d+", "N", line).split(maxsplit=1)[1] for line in looks] == [
        "0 post no",
        "N post no",
        "N pre no post no",
        "0 post no",
        "0 post no",
        "N pre no post no",
    ]


def test_spheres_need_no_files_of_clumps(tmp_path: Path) -> None:
    stages = [Stage("one", Elapsed(0.01), strike_off=0.05), settle()]
    alone = {"clumps.liggghts", "surplus.liggghts"}
    files = written(scene_of(spheres([(0, 0, 0.1)]), FLOOR, stages), tmp_path / "spheres")
    assert not alone & set(files)
    assert "multisphere" not in files["in.liggghts"]

    pair = clumps([(0, 0, 0.1)])
    files = written(scene_of(pair, FLOOR, stages, sizes=PAIR), tmp_path / "pair")
    assert alone <= set(files)
    files = written(scene_of(pair, FLOOR, [settle()], sizes=PAIR), tmp_path / "kept")
    assert alone & set(files) == {"clumps.liggghts"}


def test_mass_above_sums_the_shares_of_spheres(tmp_path: Path) -> None:
    recorded = Series({"above": MassAbove(0.05)}, 0.001)
    stages = [Stage(name, Elapsed(0.01), series=recorded) for name in ("one", "two")]
    deck = written(scene_of(clumps([(0, 0, 0.1)]), {}, stages, sizes=PIN), tmp_path)["in.liggghts"]

    assert deck.count("reduce/region record_above sum v_share") == 2
    assert deck.count("uncompute       record_above") == 2
    (share,) = re.findall(r"share atom ([^*]+)\*r\*r\*r", deck)
    clump = PIN.clump
    assert clump is not None
    radii = 2 * RADIUS * clump.radii
    assert float(share) * (radii**3).sum() == pytest.approx(MASS, rel=1e-9)


def test_the_share_of_a_sphere_is_its_mass(tmp_path: Path) -> None:
    dump = tmp_path / "one.dump"
    dump.write_text(
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n"
        "-1 1\n-1 1\n-1 1\nITEM: ATOMS id type x y z radius mass mol v_share\n"
        "2 1 0.004 0 0 0.004 0.001 1 0.0007\n1 1 0 0 0 0.003 0.001 1 0.0003\n"
    )
    found = read_dump(dump)

    assert found.masses.tolist() == [0.0003, 0.0007]
    assert found.count == 1
    assert math.isclose(found.masses.sum(), 0.001)


def test_glued_particles_are_parts_of_no_clump(tmp_path: Path) -> None:
    dump = tmp_path / "one.dump"
    dump.write_text(
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n"
        "-1 1\n-1 1\n-1 1\nITEM: ATOMS id type x y z radius mass v_glued mol v_share\n"
        "2 1 0.1 0 0 0.004 0.001 0 1 0.0007\n1 1 0 0 0 0.003 0.001 1 -1 0.001\n"
    )
    found = read_dump(dump, glued=1)

    assert found.clumps is not None
    assert found.clumps.tolist() == [0]
    assert found.volumes == pytest.approx(4 / 3 * math.pi * 0.003**3, rel=1e-3)


def test_glued_spheres_are_created_within_the_periods(tmp_path: Path) -> None:
    box = Box((-0.1, 0.0, -0.1), (0.1, 0.03, 0.2), periodic="y")
    body = glued([(0.01, -0.01, 0.0), (0.02, 0.03, 0.0)])
    scene = scene_of(
        clumps([(0, 0.01, 0.1)]), {}, [settle()], sizes=PAIR, glued={"plate": body}, box=box
    )
    files = written(scene, tmp_path)

    assert "0 atoms" in files["particles.data"]
    single = [after("single", line, 3) for line in re.findall("create_atoms.*", files[INSERTION])]
    assert np.array(single) == pytest.approx(np.array([(0.01, 0.02, 0.0), (0.02, 0.0, 0.0)]))


def test_variables_of_looks_come_after_those_of_their_stage(tmp_path: Path) -> None:
    stages = [settle(), settle(Series({"above": MassAbove(0.05)}, 0.001))]
    stages[1] = replace(stages[1], name="again", snapshot=None)
    scene = scene_of(clumps([(0, 0, 0.1)]), FLOOR, stages, sizes=PAIR)
    deck = written(scene, tmp_path)["in.liggghts"]

    again = deck[: deck.index("record_above equal")].rfind("--- again")
    for name in ("energy", "passed", "count", "since"):
        assert deck[:again].rfind(f"variable        {name} delete") > 0
        assert deck[:again].rfind(f"{name} equal") < deck[:again].rfind(f"{name} delete")
