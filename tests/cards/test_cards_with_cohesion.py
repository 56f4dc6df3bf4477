"""Cards of a cohesive material: each program computes with the cohesion of its card."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from test_solvers_read_cards import (
    LAMMPS,
    LIGGGHTS,
    OVERLAP,
    RADIUS,
    YADE,
    deck,
    printed,
    run_yade,
    start,
    write_yade,
)

import needs
from grainfit.cards import CardParameter, MaterialCard, render
from grainfit.contact_models.dmt.model import pull_off_force
from grainfit.contact_models.hertz_mindlin.model import hertz_stiffness, particle_moduli
from grainfit.contact_models.jkr.model import force_at
from grainfit.contact_models.sjkr.model import sphere_area
from grainfit.contact_models.sjkr2.model import area_over_overlap
from grainfit.errors import InputError
from grainfit.materials.card import Program
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.dem import messages as of_dem
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts

BETWEEN, ON_WALL = 0.3, 0.2
STICKY = {"surface_energy": 1.0}
DAMP = {"cohesion_energy_density": 1e4}


def with_cohesion(card: MaterialCard, of: Mapping[str, float], *models: str) -> MaterialCard:
    parameters = [
        CardParameter(f"{section}.{key}", "", "", "", share * unit, "given")
        for key, unit in of.items()
        for section, share in (("particle_particle", BETWEEN), ("particle_wall", ON_WALL))
    ]
    return replace(card, parameters=(*card.parameters, *parameters), contact_models=models)


def hertz(card: MaterialCard, body: str, radius: float) -> float:
    return hertz_stiffness(OVERLAP, particle_moduli(card.values, body), radius) * OVERLAP


def require_forces(found: Mapping[str, float], between: float, on_wall: float) -> None:
    assert found["pushed"] == pytest.approx(between, rel=1e-6)
    assert found["lifted"] == pytest.approx(on_wall, rel=1e-6)


@pytest.mark.parametrize("model", ["jkr", "dmt"])
def test_lammps(card: MaterialCard, tmp_path: Path, model: str) -> None:
    sticky = with_cohesion(card, STICKY, model)
    (tmp_path / "card.inc").write_text(render(sticky, "lammps"))
    (tmp_path / "in.test").write_text(deck(LAMMPS, []))
    start(Lammps, tmp_path)

    def force(body: str, radius: float, energy: float) -> float:
        if model == "jkr":
            return force_at(OVERLAP, energy, particle_moduli(card.values, body).young, radius)
        return hertz(card, body, radius) - pull_off_force(energy, radius)

    require_forces(
        printed(tmp_path / "solver.log"),
        force("particle", RADIUS / 2, BETWEEN),
        force("wall", RADIUS, ON_WALL),
    )


@needs.LIGGGHTS
@pytest.mark.parametrize("model", ["sjkr", "sjkr2"])
def test_liggghts(card: MaterialCard, tmp_path: Path, model: str) -> None:
    (tmp_path / "card.inc").write_text(render(with_cohesion(card, DAMP, model), "liggghts"))
    (tmp_path / "in.test").write_text(deck(LIGGGHTS, []))
    start(Liggghts, tmp_path)
    areas = [
        sphere_area(2 * RADIUS - OVERLAP, RADIUS, RADIUS),
        sphere_area(RADIUS - OVERLAP, RADIUS, None),
    ]
    if model == "sjkr2":
        areas = [area_over_overlap(RADIUS, other) * OVERLAP for other in (RADIUS, None)]

    require_forces(
        printed(tmp_path / "solver.log"),
        hertz(card, "particle", RADIUS / 2) - 1e4 * BETWEEN * areas[0],
        hertz(card, "wall", RADIUS) - 1e4 * ON_WALL * areas[1],
    )


@needs.YADE
def test_yade(card: MaterialCard, tmp_path: Path) -> None:
    text = render(with_cohesion(card, STICKY, "dmt"), "yade")
    adhesion = '"adhesion": found.adhesionForce, "acts": contact_law.includeAdhesion,'
    write_yade(text, YADE.replace('"kno": found.kno,', adhesion), tmp_path / "test.py")
    log = run_yade("test.py", tmp_path)
    assert (tmp_path / "found.json").is_file(), log
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["particles"]["acts"]
    between = pull_off_force(BETWEEN, RADIUS / 2)
    assert found["particles"]["adhesion"] == pytest.approx(between)
    assert found["wall"]["adhesion"] == pytest.approx(pull_off_force(ON_WALL, RADIUS))


@pytest.mark.parametrize(
    ("of", "models", "to", "words"),
    [
        (STICKY, (), "liggghts", "jkr, which liggghts does not have. Use lammps"),
        (STICKY, (), "yade", "Use lammps, or calibrate with a model that yade has"),
        (DAMP, (), "lammps", "sjkr, which lammps does not have. Use liggghts"),
        ({**STICKY, **DAMP}, (), "lammps", "sjkr and jkr cannot act together"),
    ],
)
def test_no_card_for_a_program_without_the_model(
    card: MaterialCard, of: Mapping[str, float], models: tuple[str, ...], to: str, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        render(with_cohesion(card, of, *models), to)


@pytest.mark.parametrize(("calibrated", "to"), [("lammps", "yade"), ("yade", "lammps")])
def test_a_cohesive_card_for_another_program_says_how_its_friction_differs(
    card: MaterialCard, calibrated: str, to: str
) -> None:
    sticky = replace(with_cohesion(card, STICKY, "dmt"), programs=(Program(calibrated, ""),))
    text = " ".join(line.removeprefix("# ") for line in render(sticky, to).splitlines())

    assert of_dem.CALIBRATED_DIFFERENTLY.is_in(text)
    assert "Rolling friction is not quite the same in YADE" in text
    assert "LAMMPS plus twice the pull-off force: cohesive beds do not agree." in text
    assert "beds do not agree" not in render(sticky, calibrated)


FACTOR = 2.5
ENERGY = "particle_particle.surface_energy"


@pytest.fixture
def coarse(card: MaterialCard) -> MaterialCard:
    """Real particles of 4 mm with cohesion, simulated with 10 mm."""
    sticky = with_cohesion(card, STICKY, "dmt")
    parameters = [
        replace(p, interval=(0.2, 0.4), determination="determined") if p.name == ENERGY else p
        for p in sticky.parameters
    ]
    sizes = ParticleSizes((0.004,)).coarse_grained(FACTOR)
    return replace(sticky, parameters=tuple(parameters), sizes=sizes)


@pytest.mark.parametrize(
    ("to", "value", "in_contact"),
    [
        ("lammps", r"particle_particle_surface_energy +string (\S+) (.*)", r'"dmt(?: (\S+)){4}'),
        ("yade", r"'particle_particle.surface_energy': (\S+), (.*)", r"gamma=(\S+),"),
    ],
)
def test_all_values_of_a_solver_are_those_of_the_simulated_particles(
    coarse: MaterialCard, to: str, value: str, in_contact: str
) -> None:
    text = render(coarse, to)
    [(found, comment)] = re.findall(value, text)

    assert float(found) == FACTOR * BETWEEN
    assert float(re.findall(in_contact, text)[0]) == FACTOR * BETWEEN
    assert "2.5 times that of the real" in comment
    assert "95 % interval 0.5 to 1" in comment
    assert "2.5 times as large" in text
    assert "real ones (4 mm)" in text


def test_tables_and_data_have_real_and_simulated_values(coarse: MaterialCard) -> None:
    data = json.loads(render(coarse, "json"))
    [energy] = [one for one in data["parameters"] if one["name"] == ENERGY]
    [row] = [
        row for row in csv.DictReader(io.StringIO(render(coarse, "csv"))) if row["name"] == ENERGY
    ]

    for values in (energy, row):
        assert float(values["value"]) == BETWEEN
        assert float(values["simulated_value"]) == FACTOR * BETWEEN
    assert energy["interval_95"] == [0.2, 0.4]
    assert float(row["coarse_graining"]) == data["particle_sizes"]["coarse_graining"] == FACTOR
    assert data["particle_sizes"]["real_diameters"] == [0.004]
    assert data["particle_sizes"]["diameters"] == [0.01]
