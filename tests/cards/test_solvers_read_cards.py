"""Every card in the program that it is for: what was exported is what the program computes with."""

from __future__ import annotations

import json
import math
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from exported_beads import FIXED, SIZES

import grainfit
import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.cards import MaterialCard, render
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.epsd.model import rolling_spring_of
from grainfit.contact_models.hertz_mindlin.model import (
    EffectiveModuli,
    hertz_stiffness,
    particle_moduli,
    tangential_stiffness,
)
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.process.process import run_process

PAGE = Path(__file__).parents[2] / "docs" / "export.md"
RADIUS = 0.005
OVERLAP = 1e-4

#: Two particles that touch, and one that touches the floor.
LAMMPS = """
units           si
atom_style      sphere
atom_modify     map array
boundary        f f f
newton          off
comm_modify     vel yes
region          box block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box
create_box      1 box
include         card.inc
create_atoms    1 single 0.0 0.0 0.05 units box
create_atoms    1 single 0.0099 0.0 0.05 units box
create_atoms    1 single 0.05 0.05 0.0049 units box
set             group all diameter 0.01
set             group all density ${particle_density}
pair_style      granular
pair_coeff      1 1 ${particle_particle_contact}
fix             floor all wall/gran granular ${particle_wall_contact} zplane 0.0 NULL
fix             motion all nve/sphere
timestep        ${recommended_time_step}
run             0
"""

LIGGGHTS = """
units           si
atom_style      granular
atom_modify     map array
boundary        f f f
newton          off
communicate     single vel yes
region          box block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box
create_box      2 box
neighbor        0.002 bin
neigh_modify    delay 0
include         card.inc
pair_style      gran model ${contact_model}
pair_coeff      * *
create_atoms    1 single 0.0 0.0 0.05 units box
create_atoms    1 single 0.0099 0.0 0.05 units box
create_atoms    1 single 0.05 0.05 0.0049 units box
set             group all diameter 0.01
set             group all density ${particle_density}
fix             floor all wall/gran model ${contact_model} primitive type 2 zplane 0.0
fix             motion all nve/sphere
timestep        ${recommended_time_step}
run             0
"""

YADE = """
import json, math
from yade import *
from this_file import PARAMETERS

radius, overlap = RADIUS, OVERLAP


def beads(gap):
    \"\"\"Two particles side by side, and one above a wall.\"\"\"
    O.bodies.clear()
    O.bodies.append(
        [
            utils.sphere((-(radius + gap / 2), 0, 0.05), radius, material=particle),
            utils.sphere((radius + gap / 2, 0, 0.05), radius, material=particle),
            utils.sphere((0.05, 0, radius + gap), radius, material=particle),
            utils.wall(0, axis=2, material=wall),
        ]
    )


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [contact_physics], [contact_law]
    ),
    NewtonIntegrator(gravity=(0, 0, 0), damping=0),
]
O.dt = RECOMMENDED_TIME_STEP / 10
beads(-overlap)
O.step()
set_contacts_on_walls()


def physics(one, other):
    found = O.interactions[one, other].phys
    return {
        "kno": found.kno,
        "kso": found.kso,
        "friction": found.tangensOfFrictionAngle,
        "krot": found.kr,
        "moment_limit": found.maxBendPl,
    }


found = {
    "parameters": PARAMETERS,
    "time_step": RECOMMENDED_TIME_STEP,
    "materials": {
        m.label: [m.young, m.poisson, m.density, m.frictionAngle] for m in O.materials
    },
    "particles": physics(0, 1),
    "wall": physics(2, 3),
}
beads(radius / 100)
O.bodies[0].state.vel = (0.25, 0, 0)
O.bodies[1].state.vel = (-0.25, 0, 0)
O.bodies[2].state.vel = (0, 0, -0.5)
O.run(2000, wait=True)
found["rebound"] = (O.bodies[1].state.vel[0] - O.bodies[0].state.vel[0]) / 0.5
found["wall_rebound"] = O.bodies[2].state.vel[2] / 0.5
with open("found.json", "w") as file:
    json.dump(found, file)
""".replace("RADIUS, OVERLAP", f"{RADIUS}, {OVERLAP}")


def deck(text: str, names: list[str]) -> str:
    """A deck that prints variables, and what pushes the particles."""
    forces = "variable pushed equal fx[2]\nvariable lifted equal fz[3]\n"
    names = [*names, "recommended_time_step", "pushed", "lifted"]
    return text + forces + "".join(f'print "VALUE {name} ${{{name}}}"\n' for name in names)


def start(solver_type: type[DeckSolver], folder: Path) -> None:
    solver = solver_type(Heap(SIZES), FIXED)
    run_process(solver._command(Path("in.test")), Workspace(folder, 60.0))


def write_yade(card: str, script: str, path: Path) -> None:
    """Write a card, and a script that begins as the first lines of the card say."""
    (path.parent / "this_file.py").write_text(card, encoding="utf-8")
    head = [line.removeprefix("#     ") for line in card.splitlines()]
    [end] = [n for n, line in enumerate(head, 1) if line.startswith("from this_file import")]
    path.write_text("\n".join(head[1:end]) + f"\n{script}", encoding="utf-8")


def run_yade(name: str, folder: Path) -> str:
    command = ["yade", "-n", "-x", name]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    return done.stdout + done.stderr


def printed(log: Path) -> dict[str, float]:
    lines = [line.split() for line in log.read_text(errors="replace").splitlines()]
    assert ["INJECTED"] not in lines
    return {line[1]: float(line[2]) for line in lines if line[:1] == ["VALUE"]}


def variables(card: MaterialCard) -> dict[str, float]:
    return {name.replace(".", "_"): v for name, v in card.values.items() if name.isascii()}


def hertz_force(moduli: EffectiveModuli, radius: float) -> float:
    return hertz_stiffness(OVERLAP, moduli, radius) * OVERLAP


def require_forces(card: MaterialCard, found: dict[str, float]) -> None:
    between = hertz_force(particle_moduli(card.values, "particle"), RADIUS / 2)
    on_wall = hertz_force(particle_moduli(card.values, "wall"), RADIUS)
    assert found["pushed"] == pytest.approx(between, rel=1e-6)
    assert found["lifted"] == pytest.approx(on_wall, rel=1e-6)


def test_lammps_computes_with_the_values_of_its_card(
    nasty_card: MaterialCard, tmp_path: Path
) -> None:
    (tmp_path / "card.inc").write_text(render(nasty_card, "lammps"))
    expected = variables(nasty_card)
    (tmp_path / "in.test").write_text(deck(LAMMPS, list(expected)))
    start(Lammps, tmp_path)
    found = printed(tmp_path / "solver.log")
    assert found | expected == found
    assert found["recommended_time_step"] == nasty_card.recommended_time_step
    require_forces(nasty_card, found)


def test_lammps_takes_the_contacts_of_every_pair_of_diameters(
    card: MaterialCard, tmp_path: Path
) -> None:
    sizes = grainfit.ParticleSizes((0.008, 0.010), (0.3, 0.7))
    (tmp_path / "card.inc").write_text(render(replace(card, sizes=sizes), "lammps"))
    text = LAMMPS.replace("create_box      1", "create_box      2")
    pairs = "".join(
        f"pair_coeff {i} {j} ${{particle_particle_contact_{i}_{j}}}\n"
        for i, j in ((1, 1), (1, 2), (2, 2))
    )
    text = text.replace("pair_coeff      1 1 ${particle_particle_contact}\n", pairs)
    text = text.replace("${particle_wall_contact}", "${particle_wall_contact_2}")
    text = text.replace("create_atoms    1", "create_atoms    2")
    (tmp_path / "in.test").write_text(deck(text, []))
    start(Lammps, tmp_path)
    require_forces(card, printed(tmp_path / "solver.log"))


@needs.LIGGGHTS
def test_liggghts_computes_with_the_values_of_its_card(
    nasty_card: MaterialCard, tmp_path: Path
) -> None:
    (tmp_path / "card.inc").write_text(render(nasty_card, "liggghts"))
    expected = variables(nasty_card)
    # What the contact model reads: values of the two types, and of the pairs of types.
    read = {}
    for fix, name in (("youngs_modulus", "youngs_modulus"), ("poissons_ratio", "poissons_ratio")):
        for number, body in ((1, "particle"), (2, "wall")):
            read[f"f_{fix}[{number}]"] = nasty_card.values[f"{body}.{name}"]
    for fix, name in (
        ("coefficientRestitution", "restitution"),
        ("coefficientFriction", "sliding_friction"),
        ("coefficientRollingFriction", "rolling_friction"),
        ("coefficientRollingViscousDamping", "rolling_damping"),
    ):
        read[f"f_{fix}[1][1]"] = nasty_card.values[f"particle_particle.{name}"]
        read[f"f_{fix}[1][2]"] = nasty_card.values[f"particle_wall.{name}"]
        read[f"f_{fix}[2][1]"] = nasty_card.values[f"particle_wall.{name}"]
    of_fixes = [f"of_fix_{number}" for number in range(len(read))]
    text = LIGGGHTS + "".join(
        f"variable {name} equal {fix}\n" for name, fix in zip(of_fixes, read, strict=True)
    )
    (tmp_path / "in.test").write_text(deck(text, [*expected, *of_fixes]))
    start(Liggghts, tmp_path)
    found = printed(tmp_path / "solver.log")
    assert found | expected == found
    assert found["recommended_time_step"] == nasty_card.recommended_time_step
    for name, (fix, value) in zip(of_fixes, read.items(), strict=True):
        assert found[name] == pytest.approx(value, rel=1e-9), fix
    require_forces(nasty_card, found)


@needs.YADE
def test_yade_computes_with_the_values_of_its_card(
    nasty_card: MaterialCard, tmp_path: Path
) -> None:
    write_yade(render(nasty_card, "yade"), YADE, tmp_path / "test.py")
    log = run_yade("test.py", tmp_path)
    assert (tmp_path / "found.json").is_file(), log
    assert "INJECTED" not in log.splitlines()
    found = json.loads((tmp_path / "found.json").read_text())
    values = nasty_card.values
    assert found["parameters"] == values
    assert found["time_step"] == nasty_card.recommended_time_step
    assert found["materials"]["particle"] == [
        values["particle.youngs_modulus"],
        values["particle.poissons_ratio"],
        values["particle.density"],
        math.atan(values["particle_particle.sliding_friction"]),
    ]
    # On a wall, YADE takes half the radius: the card makes up for it.
    for name, contact in (
        ("particles", Contact.between(values, RADIUS, RADIUS, nasty_card.gravity)),
        ("wall", Contact.on_wall(values, RADIUS, nasty_card.gravity)),
    ):
        moduli, radius = particle_moduli(values, contact.body), contact.effective_radius
        spring = rolling_spring_of(contact, contact.value("rolling_damping"))
        assert found[name] == {
            "kno": pytest.approx(4 / 3 * moduli.young * math.sqrt(radius)),
            "kso": pytest.approx(tangential_stiffness(moduli) * math.sqrt(radius), rel=1e-5),
            "friction": pytest.approx(contact.value("sliding_friction")),
            "krot": pytest.approx(spring.stiffness * radius**2),
            "moment_limit": pytest.approx(contact.value("rolling_friction") * radius),
        }
    assert found["rebound"] == pytest.approx(values["particle_particle.restitution"], rel=0.02)
    assert found["wall_rebound"] == pytest.approx(values["particle_wall.restitution"], rel=0.02)


@needs.YADE
def test_script_of_the_page_runs_beside_its_card(card: MaterialCard, tmp_path: Path) -> None:
    _, section = PAGE.read_text(encoding="utf-8").split("\n## YADE\n")
    script, _ = section.partition("```python\n")[2].split("```\n", 1)
    (tmp_path / "sand.py").write_text(render(card, "yade"), encoding="utf-8")
    falls = 'O.run(10, wait=True)\nprint("FALLS", O.bodies[0].state.vel[2] < 0)\n'
    (tmp_path / "script.py").write_text(script + falls, encoding="utf-8")

    log = run_yade("script.py", tmp_path)
    assert "FALLS True" in log.splitlines(), log
