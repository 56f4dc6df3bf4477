"""Cards of materials whose particles are clumps carry the clump."""

from __future__ import annotations

import itertools
import json
import math
import re
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_solvers_read_cards import run_yade, start, write_yade

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.cards import CardParameter, MaterialCard, render
from grainfit.cards.from_calibration import make_card
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.decks import write_deck
from grainfit.work_folder.saved_calibration import SavedCalibration

SIZES = ParticleSizes((0.010,), shape=ParticleShape("grain", aspect_ratio=1.8))

#: Upright: YADE sorts the axes by their moments, and the masses of the spheres have another centre.
PIN = ParticleSizes(
    (0.010,), shape=ParticleShape(spheres=((0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.1, 0.5)))
)


@pytest.fixture
def clumps(card: MaterialCard) -> MaterialCard:
    return replace(card, sizes=SIZES)


def molecules(text: str) -> dict[str, str]:
    """Return the molecule files in the comments of a card for LAMMPS, by name."""
    lines = [line.removeprefix("#     ").removeprefix("#") for line in text.splitlines()]
    ends = [n for n, line in enumerate(lines) if re.match(r" (Clump \d+, with|--- values)", line)]
    return {lines[n + 1]: "\n".join(lines[n + 1 : end]) for n, end in itertools.pairwise(ends)}


def followed(text: str, folder: Path, count: int) -> list[str]:
    """Follow a card for LAMMPS to the letter: write its files, return the lines of its head.

    What a card cannot know is added: the box, a region to pour from, and a number of particles.
    """
    files = {"this_file": text, **molecules(text)}
    for name, content in files.items():
        (folder / name).write_text(content)
    head = text[text.index("# For LAMMPS") :].splitlines()[1:]
    lines = [line.removeprefix("#     ") for line in head]
    deck = list(itertools.takewhile(lambda line: not line.startswith("#"), lines))
    place = next(n for n, line in enumerate(deck) if line.startswith("create_box"))
    regions = ["boundary p p f", "region box block -0.04 0.04 -0.04 0.04 0.0 0.2"]
    deck[place:place] = [*regions, "region hopper block -0.04 0.04 -0.04 0.04 0.05 0.19"]
    deck = [line.replace("pour 1000", f"pour {count}") for line in deck]
    return [line for line in deck if not line.startswith("run")]


def run_lammps(lines: list[str], folder: Path) -> list[list[float]]:
    """Return the numbers in the lines that begin with FOUND."""
    (folder / "in.card").write_text("\n".join(lines) + "\n")
    program = Lammps(Heap(diameter="10 mm"), {})._program()
    command = [program, "-in", "in.card", "-nocite"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-800:]
    found = [line.split() for line in done.stdout.splitlines() if line.startswith("FOUND ")]
    return [list(map(float, numbers)) for _, *numbers in found]


BODIES = """compute body all rigid/local motion mass inertiax inertiay inertiaz
compute sums all reduce sum c_body[1] c_body[2] c_body[3] c_body[4] inputs local
compute turning all erotate/rigid motion
compute moving all ke/rigid motion
compute low all reduce min z
compute contacts all contact/atom
compute touching all reduce sum c_contacts
thermo 1
thermo_style custom step c_sums[*] c_turning c_moving c_low c_touching"""
FOUND = (
    'print "FOUND $(c_sums[1]:%.12g) $(c_sums[2]:%.12g) $(c_sums[3]:%.12g) $(c_sums[4]:%.12g)'
    ' $(c_turning) $(c_moving) $(c_low) $(c_touching)"'
)


def test_lammps_pours_clumps_where_its_card_is_followed_to_the_letter(
    clumps: MaterialCard, tmp_path: Path
) -> None:
    # Six types of spheres in two diameters.
    shape = ParticleShape("grain", aspect_ratio=1.4)
    sizes = ParticleSizes((0.008, 0.010), (0.4, 0.6), shape=shape)
    text = render(replace(clumps, sizes=sizes), "lammps")
    [every] = re.findall(r"^#     run +100000 (every .*)$", text, re.MULTILINE)
    lines = followed(text, tmp_path, 30)

    count, steps = "variable count equal count(all)/7", f"run 12000 {every}"
    counted = 'print "FOUND ${count} $(c_low)"'
    low = "compute low all reduce min z\nthermo_style custom step atoms c_low"
    [[number, lowest]] = run_lammps([*lines, count, low, steps, "run 0", counted], tmp_path)
    assert number == 30
    assert 0 < lowest < 0.004


def test_lammps_moves_the_clump_of_a_card_as_a_whole(card: MaterialCard, tmp_path: Path) -> None:
    lines = followed(render(replace(card, sizes=PIN), "lammps"), tmp_path, 1)
    [[mass, *moments, turning, moving, lowest, touching]] = run_lammps(
        [*lines, BODIES, "run 100", "run 0", FOUND], tmp_path
    )

    clump = PIN.clump
    assert clump is not None
    expected = card.values["particle.density"] * math.pi / 6 * 0.01**3
    assert mass == pytest.approx(expected, rel=1e-9)
    inertia = sorted(expected * 0.01**2 * moment for moment in clump.moments)
    assert sorted(moments) == pytest.approx(inertia, rel=1e-6)
    # Gravity on its spheres would turn it, and they would push each other.
    assert lowest > 0.01
    assert moving > 0
    assert turning < 1e-12 * moving
    assert touching == 0


#: What stands before the lines of a card, and what inserts the clumps of its templates.
LIGGGHTS = """units si
atom_style granular
newton off
communicate single vel yes
boundary f f f
neighbor 0.002 bin
region box block -0.1 0.1 -0.1 0.1 0.0 0.2 units box
"""
INSERTION = """region hopper block -0.08 0.08 -0.08 0.08 0.05 0.18 units box
fix both all particledistribution/discrete 15485867 2 clump1 0.5 clump2 0.5
fix insertion all insert/pack seed 32452843 distributiontemplate both insert_every once &
    overlapcheck yes orientation random all_in yes particles_in_region 10 region hopper
"""
COUNTED = """run 1
variable number equal atoms
print "FOUND ${number}"
"""


def deck_of_card(text: str) -> str:
    """Return the first lines of a card for LIGGGHTS, with box, templates and insertion added."""
    indented = [line[6:] for line in text.splitlines() if line.startswith("#     ")]
    begin = next(n for n, line in enumerate(indented) if line.startswith("atom_modify"))
    indented = indented[begin:]
    end, first = (
        next(n for n, line in enumerate(indented) if line.startswith(start))
        for start in ("timestep", "fix clump1")
    )
    head = [line for line in indented[: end + 1] if not line.startswith("fix             walls")]
    deck = "\n".join(head).replace("create_box      2 ...", "create_box      2 box")
    inserted = "\n".join(indented[first:]) + f"\n{INSERTION}"
    return deck.replace("fix             motion", f"{inserted}fix             motion")


@needs.LIGGGHTS
def test_liggghts_inserts_the_clumps_of_each_diameter(clumps: MaterialCard, tmp_path: Path) -> None:
    sizes = ParticleSizes((0.008, 0.010), (0.4, 0.6), shape=SIZES.shape)
    text = render(replace(clumps, sizes=sizes), "liggghts")
    (tmp_path / "this_file").write_text(text)
    (tmp_path / "in.test").write_text(f"{LIGGGHTS}{deck_of_card(text)}\n{COUNTED}")
    start(Liggghts, tmp_path)

    assert "FOUND 70" in (tmp_path / "solver.log").read_text(errors="replace").splitlines()


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


@pytest.mark.parametrize("to", ["lammps", "liggghts", "yade", "json", "csv"])
@pytest.mark.parametrize("shape", [None, ParticleShape("cylinder", aspect_ratio=1.2)])
def test_coarse_grained_cards_have_no_rounding_of_the_computer(
    beads: Path, to: str, shape: ParticleShape | None
) -> None:
    saved = SavedCalibration.open(beads)
    enlarged = ParticleSizes((0.003,), shape=shape).coarse_grained(3)
    made = make_card(replace(saved, records={}, sizes=enlarged), {})
    parameters = [replace(p, value=1007.0) if "density" in p.name else p for p in made.parameters]
    if to in ("lammps", "json", "csv"):
        # At the size of the particles, it is 0.30000000000000004.
        name = "particle_particle.surface_energy"
        parameters.append(CardParameter(name, "", "", "", 0.1, "given"))
    text = render(replace(made, parameters=tuple(parameters)), to)

    assert "00000000000" not in re.sub(r"\b[1-9]0+(\.0)?\b", "", text)
    assert "99999999999" not in text


def test_the_card_of_yade_finds_a_clump_by_its_diameter_as_people_write_it(
    clumps: MaterialCard,
) -> None:
    sizes = SIZES.coarse_grained(0.3 / 0.1)
    text = render(replace(clumps, sizes=sizes), "yade")
    lookup = text[text.index("CLUMPS = {") : text.index("    numbers = []")]
    found: dict[str, Any] = {}
    exec(lookup.replace("orientation=Quaternion.Identity, ", "") + "    return mass", found)

    assert sizes.diameters != (0.03,)
    assert found["put_clump"](None, 0.03) == found["put_clump"](None)
    with pytest.raises(KeyError, match=r"0\.04"):
        found["put_clump"](None, 0.04)


def test_cards_of_spheres_say_nothing_of_clumps(card: MaterialCard) -> None:
    assert json.loads(render(card, "json"))["particle_shape"] is None
    assert all("clump" not in render(card, to) for to in ("lammps", "liggghts", "yade"))


#: A pin at a place and with an orientation, and one that falls on its end.
YADE = """
import json
from yade import *

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


@needs.YADE
def test_yade_puts_the_clump_of_a_card(card: MaterialCard, tmp_path: Path) -> None:
    write_yade(render(replace(card, sizes=PIN), "yade"), YADE, tmp_path / "test.py")
    log = run_yade("test.py", tmp_path)
    assert (tmp_path / "found.json").is_file(), log
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
