"""Cards of a material on two walls, in the programs that they are for."""

from __future__ import annotations

import csv
import io
import json
import math
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from exported_beads import FIXED, SIZES
from test_solvers_read_cards import write_yade

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.cards import CardParameter, MaterialCard, render
from grainfit.contact_models.dmt.model import pull_off_force
from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.contact_models.registry import in_order, material_parameter
from grainfit.errors import InputError
from grainfit.materials.walls import material_on, on_wall, wall_of
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.process.process import run_process
from grainfit.solvers.registry import DEM_PROGRAMS

FRICTION = {"steel": 0.1, "acrylic": 0.4}
RADIUS, SPEED, TIME = 0.005, 1.0, 0.02


@pytest.fixture
def two_walls(card: MaterialCard) -> MaterialCard:
    """The beads on steel and acrylic, which have another friction and stiffness."""
    values = {name: value for name, value in card.values.items() if wall_of(name) is None}
    for wall, friction in FRICTION.items():
        own = {name: value for name, value in card.values.items() if wall_of(name) == ""}
        own |= {"particle_wall.sliding_friction": friction, "wall.youngs_modulus": friction * 1e7}
        own |= {"particle_wall.rolling_friction": 0.0, "particle_wall.rolling_damping": 0.0}
        values |= {on_wall(name, wall): value for name, value in own.items()}
    return replace(card, parameters=tuple(_parameters(values)))


def _parameters(values: dict[str, float]) -> Iterator[CardParameter]:
    for name in in_order(values):
        known = material_parameter(name)
        assert known is not None
        yield CardParameter(
            name, known.symbol, known.unit, known.description, values[name], "given"
        )


def height(card: MaterialCard, wall: str) -> float:
    """Height of a particle at rest on a wall."""
    material = material_on(card.values, wall)
    weight = material["particle.density"] * 4 / 3 * math.pi * RADIUS**3 * 9.81
    return RADIUS - hertz_overlap(weight, particle_moduli(material, "wall"), RADIUS)


def slowed(program: str, text: str, folder: Path) -> dict[str, float]:
    """Speed that particles lose by sliding on each wall, over gravity times time."""
    (folder / "in.test").write_text(text, encoding="utf-8")
    solver: DeckSolver = DEM_PROGRAMS[program](Heap(SIZES), FIXED)
    run_process(solver._command(Path("in.test")), Workspace(folder, 60.0))
    log = (folder / "solver.log").read_text(errors="replace").splitlines()
    found = [line.split() for line in log if line.startswith("SPEED ")]
    return {wall: (SPEED - float(speed)) / (9.81 * TIME) for _, wall, speed in found}


#: A particle slides on each of two floors.
LAMMPS = """
units           si
atom_style      sphere
atom_modify     map array
boundary        f f f
newton          off
comm_modify     vel yes
region          box block -1 1 -1 1 -0.1 0.1 units box
create_box      1 box
include         card.inc
create_atoms    1 single 0.0 0.0 {steel} units box
create_atoms    1 single 0.0 0.5 {acrylic} units box
set             group all diameter 0.01
set             group all density ${{particle_density}}
group           steel id 1
group           acrylic id 2
pair_style      granular
pair_coeff      1 1 ${{particle_particle_contact}}
fix             floor1 steel wall/gran granular ${{particle_wall_steel_contact}} zplane 0 NULL
fix             floor2 acrylic wall/gran granular ${{particle_wall_acrylic_contact}} zplane 0 NULL
"""
LIGGGHTS = """
units           si
atom_style      granular
atom_modify     map array
boundary        f f f
newton          off
communicate     single vel yes
region          box block -1 1 -1 1 -0.1 0.1 units box
create_box      3 box
neighbor        0.002 bin
neigh_modify    delay 0
include         card.inc
pair_style      gran model ${{contact_model}}
pair_coeff      * *
create_atoms    1 single 0.0 0.0 {steel} units box
create_atoms    1 single 0.0 0.5 {acrylic} units box
set             group all diameter 0.01
set             group all density ${{particle_density}}
group           steel id 1
group           acrylic id 2
fix             steel steel wall/gran model ${{contact_model}} primitive type 2 zplane 0.0
fix             acrylic acrylic wall/gran model ${{contact_model}} primitive type 3 zplane 0.0
"""
SLIDE = f"""
fix             gravity all gravity 9.81 vector 0.0 0.0 -1.0
fix             motion all nve/sphere
velocity        all set {SPEED} 0.0 0.0
timestep        1e-5
run             {round(TIME / 1e-5)}
variable        steel equal vx[1]
variable        acrylic equal vx[2]
print           "SPEED steel ${{steel}}"
print           "SPEED acrylic ${{acrylic}}"
"""


@pytest.mark.parametrize(("program", "deck"), [("lammps", LAMMPS), ("liggghts", LIGGGHTS)])
def test_particles_slide_on_each_wall_with_its_friction(
    two_walls: MaterialCard, tmp_path: Path, program: str, deck: str
) -> None:
    if program == "liggghts" and shutil.which("liggghts") is None:
        pytest.skip("LIGGGHTS is not installed: apt-get install liggghts")
    (tmp_path / "card.inc").write_text(render(two_walls, program), encoding="utf-8")
    text = deck.format(**{wall: height(two_walls, wall) for wall in FRICTION}) + SLIDE

    assert slowed(program, text, tmp_path) == pytest.approx(FRICTION, rel=0.02)


YADE = """
from yade import *

O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [contact_physics], [contact_law]
    ),
    NewtonIntegrator(gravity=(0, 0, 0), damping=0),
]
O.dt = 1e-7
O.bodies.append(utils.sphere((0.00499, 0, 0.00499), 0.005, material=particle))
O.bodies.append(utils.wall(0, axis=2, material=wall_steel))
O.bodies.append(utils.wall(0, axis=0, material=wall_acrylic))
O.step()
set_contacts_on_walls()
for number, name in ((1, "steel"), (2, "acrylic")):
    physics = O.interactions[0, number].phys
    numbers = physics.tangensOfFrictionAngle, physics.kno, physics.maxBendPl, physics.adhesionForce
    print("WALL", name, *numbers, flush=True)
"""


@needs.YADE
def test_yade_gives_contacts_the_values_of_their_wall(
    two_walls: MaterialCard, tmp_path: Path
) -> None:
    rolling = {"steel": 0.05, "acrylic": 0.08}
    changes = {f"particle_wall.{w}.rolling_friction": v for w, v in rolling.items()}
    changes |= {f"particle_wall.{w}.surface_energy": 10 * v for w, v in rolling.items()}
    values = {**two_walls.values, **changes, "particle_particle.surface_energy": 0.6}
    sticky = replace(two_walls, parameters=tuple(_parameters(values)), contact_models=("dmt",))
    write_yade(render(sticky, "yade"), YADE, tmp_path / "in.test.py")
    undamped = {name: 0.0 if "rolling_damping" in name else value for name, value in FIXED.items()}
    solver: DeckSolver = DEM_PROGRAMS["yade"](Heap(SIZES), undamped)
    run_process(solver._command(Path("in.test.py")), Workspace(tmp_path, 60.0))

    log = (tmp_path / "solver.log").read_text(errors="replace").splitlines()
    found = {line.split()[1]: line.split()[2:] for line in log if line.startswith("WALL ")}
    assert found.keys() == FRICTION.keys()
    for wall, numbers in found.items():
        young = particle_moduli(material_on(values, wall), "wall").young
        expected = [
            FRICTION[wall],
            4 / 3 * young * math.sqrt(RADIUS),
            rolling[wall] * RADIUS,
            pull_off_force(10 * rolling[wall], RADIUS),
        ]
        assert [float(number) for number in numbers] == pytest.approx(expected)


def test_tables_and_data_have_every_wall(two_walls: MaterialCard) -> None:
    name = "particle_wall.acrylic.sliding_friction"
    rows = {row["name"]: row for row in csv.DictReader(io.StringIO(render(two_walls, "csv")))}
    assert rows[name]["symbol"] == "μ_pw_acrylic"
    data = {one["name"]: one for one in json.loads(render(two_walls, "json"))["parameters"]}
    assert data[name]["value"] == 0.4
    assert data[name]["description"] == "particle-wall sliding friction coefficient (acrylic)"


def test_a_parameter_that_a_wall_lacks_is_named(two_walls: MaterialCard) -> None:
    lacking = replace(
        two_walls,
        parameters=tuple(
            p for p in two_walls.parameters if p.name != "particle_wall.acrylic.restitution"
        ),
    )
    with pytest.raises(InputError, match=r"needs particle_wall\.acrylic\.restitution"):
        render(lacking, "liggghts")
