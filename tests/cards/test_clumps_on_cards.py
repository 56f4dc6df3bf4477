"""Cards of materials whose particles are clumps carry the clump."""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.cards import MaterialCard, render
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.decks import write_deck

SIZES = ParticleSizes((0.010,), shape=ParticleShape("grain", aspect_ratio=1.8))

#: Upright: YADE sorts the axes by their moments, and the masses of the spheres have another centre.
PIN = ParticleSizes(
    (0.010,), shape=ParticleShape(spheres=((0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.1, 0.5)))
)


@pytest.fixture
def clumps(card: MaterialCard) -> MaterialCard:
    return replace(card, sizes=SIZES)


def block(text: str, first: str, last: str) -> str:
    """Return the comments of a card between two lines, as they are to be copied."""
    lines = [line.removeprefix("#").removeprefix("     ") for line in text.splitlines()]
    begin = next(n for n, line in enumerate(lines) if first in line)
    end = next(n for n, line in enumerate(lines) if n > begin and last in line)
    return "\n".join(lines[begin + 1 : end])


def test_lammps_reads_the_molecule_of_a_card(clumps: MaterialCard, tmp_path: Path) -> None:
    text = render(clumps, "lammps")
    (tmp_path / "clump.mol").write_text("clump\n\n" + block(text, "reinit no", "--- values"))
    (tmp_path / "card").write_text(text)
    deck = (
        "units si\natom_style sphere\natom_modify map array\nboundary f f f\nnewton off\n"
        "comm_modify vel yes cutoff 0.1\n"
        "fix property all property/atom mol ghost yes\n"
        "region box block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box\ncreate_box 4 box\n"
        "include card\npair_style granular\n"
        "neigh_modify exclude molecule/intra all\n"
        + "".join(
            f"pair_coeff {i} {j} ${{particle_particle_contact_{i}_{j}}}\n"
            for i in range(1, 5)
            for j in range(i, 5)
        )
        + "molecule clump clump.mol\n"
        "region here block -0.02 0.02 -0.02 0.02 -0.02 0.02 units box\n"
        "fix motion all rigid/small molecule mol clump reinit no\n"
        "fix insert all deposit 1 0 1 12345 region here mol clump rigid motion units box\n"
        "compute body all rigid/local motion mass inertiax inertiay inertiaz\n"
        "compute all_bodies all reduce sum c_body[1] c_body[2] c_body[3] c_body[4] "
        "inputs local\n"
        "thermo_style custom step c_all_bodies[*]\nthermo_modify norm no format float %.12g\n"
        "timestep 1e-6\nrun 2 post no\nrun 0\n"
    )
    (tmp_path / "in.card").write_text(deck)
    program = Lammps(Heap(diameter="10 mm"), {})._program()
    done = subprocess.run(
        [program, "-in", "in.card", "-nocite"], cwd=tmp_path, capture_output=True, text=True
    )

    assert done.returncode == 0, done.stdout[-800:]
    lines = done.stdout.splitlines()
    heads = [n for n, line in enumerate(lines) if line.split()[:1] == ["Step"]]
    _, mass, *moments = map(float, lines[heads[-1] + 1].split())
    clump = SIZES.clump
    assert clump is not None
    density = clumps.values["particle.density"]
    expected = density * 3.141592653589793 / 6 * 0.01**3
    assert mass == pytest.approx(expected, rel=1e-9)
    assert sorted(moments) == pytest.approx(
        sorted(expected * 0.01**2 * moment for moment in clump.moments), rel=1e-6
    )


def test_every_card_has_the_spheres(clumps: MaterialCard) -> None:
    clump = SIZES.clump
    assert clump is not None
    found = json.loads(render(clumps, "json"))["particle_shape"]

    assert [sphere["radius"] for sphere in found["spheres"]] == clump.radii.tolist()
    assert found["moments_of_inertia"] == list(clump.moments)
    for to in ("lammps", "liggghts", "yade"):
        text = render(clumps, to)
        assert "clumps of spheres: grain, aspect ratio 1.8" in text
        assert all(line.startswith("#") for line in text.splitlines() if "multisphere" in line)
    assert "particletemplate/multisphere" in render(clumps, "liggghts")
    assert "put_clump" in render(clumps, "yade")


def test_cards_of_spheres_say_nothing_of_clumps(card: MaterialCard) -> None:
    assert json.loads(render(card, "json"))["particle_shape"] is None
    assert all("clump" not in render(card, to) for to in ("lammps", "liggghts", "yade"))


#: A pin at a place and with an orientation, and one that falls on its end.
YADE = """
import json, os, sys
from yade import *

sys.path.insert(0, os.getcwd())
from material import RECOMMENDED_TIME_STEP, contact_law, contact_physics, put_clump, wall

O.bodies.append(utils.wall(0, axis=2, material=wall))
clump, members = put_clump((0.1, 0.2, 0.3), Quaternion(Vector3(1, 2, 3).normalized(), 0.7))
state = O.bodies[clump].state
turn = state.ori.toRotationMatrix()
found = {
    "labels": [O.bodies[n].material.label for n in members],
    "spheres": [[*O.bodies[n].state.pos, O.bodies[n].shape.radius] for n in members],
    "place": list(state.pos),
    "mass": state.mass,
    "inertia": [list(row) for row in turn * state.inertia.asDiagonal() * turn.transpose()],
    "masses_of_members": [O.bodies[n].state.mass for n in members],
}
clump, _ = put_clump((0, 0, 0.006))
O.bodies[clump].state.vel = (0, 0, -0.3)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [contact_physics], [contact_law]
    ),
    NewtonIntegrator(gravity=(0, 0, 0), damping=0),
]
O.dt = RECOMMENDED_TIME_STEP / 20
O.run(20000, wait=True)
found["rebound"] = O.bodies[clump].state.vel[2] / 0.3
with open("found.json", "w") as file:
    json.dump(found, file)
"""


@pytest.mark.skipif(
    shutil.which("yade") is None, reason="YADE is not installed: apt-get install yade"
)
def test_yade_puts_the_clump_of_a_card(card: MaterialCard, tmp_path: Path) -> None:
    text = render(replace(card, sizes=PIN), "yade")
    (tmp_path / "material.py").write_text(text, encoding="utf-8")
    (tmp_path / "test.py").write_text(YADE)
    command = ["yade", "-n", "-x", "test.py"]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert (tmp_path / "found.json").is_file(), done.stdout + done.stderr
    found = json.loads((tmp_path / "found.json").read_text())

    clump, diameter = PIN.clump, PIN.diameters[0]
    assert clump is not None
    mass = card.values["particle.density"] * math.pi / 6 * diameter**3
    axis = np.array([1, 2, 3]) / math.sqrt(14)
    turn = Rotation.from_rotvec(0.7 * axis).as_matrix()
    assert found["labels"] == ["particle", "particle"]
    assert found["place"] == pytest.approx([0.1, 0.2, 0.3], abs=1e-7)
    places = [0.1, 0.2, 0.3] + diameter * clump.positions @ turn.T
    expected = np.column_stack((places, diameter * clump.radii))
    assert np.array(found["spheres"]) == pytest.approx(expected, abs=1e-7)
    assert found["mass"] == pytest.approx(mass)
    inertia = mass * diameter**2 * turn @ np.diag(clump.moments) @ turn.T
    assert np.array(found["inertia"]) == pytest.approx(inertia, abs=1e-5 * inertia.max())
    # An impact on the end: the dashpot knows the mass of the whole clump.
    assert found["masses_of_members"] == [pytest.approx(mass)] * 2
    assert found["rebound"] == pytest.approx(card.values["particle_wall.restitution"], rel=0.02)


def test_yade_has_the_rolling_stiffness_of_its_deck(clumps: MaterialCard, tmp_path: Path) -> None:
    undamped = {n: 0.0 if "damping" in n else v for n, v in clumps.values.items()}
    deck = write_deck(Packing(SIZES), tmp_path, "yade", undamped, seed=1).read_text()

    [stiffness] = re.findall(r"krot=(\S+),", deck)
    assert f"krot={stiffness}," in render(clumps, "yade")
