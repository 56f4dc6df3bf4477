"""Material cards of another contact model, and for another solver than that of the runs."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import pytest

import grainfit
from grainfit.calibration_file.starter import starter_file
from grainfit.cards import material_card, render
from grainfit.contact_models import messages as contact_messages
from grainfit.contact_models.base import RESTITUTION_WITH_COHESION
from grainfit.contact_models.registry import contact_law
from grainfit.errors import InputError
from grainfit.materials.card import MaterialCard, Program
from grainfit.materials.time_step import RAYLEIGH_EQUATIONS
from grainfit.solvers.dem import messages as of_dem
from tests.evaluated_equations import evaluate


def with_damping(card: MaterialCard, damping: float) -> MaterialCard:
    return replace(
        card,
        parameters=tuple(
            replace(p, value=damping) if p.name.endswith("rolling_damping") else p
            for p in card.parameters
        ),
    )


@pytest.fixture
def undamped_card(card: MaterialCard) -> MaterialCard:
    kept = tuple(p for p in card.parameters if not p.name.endswith("rolling_damping"))
    return replace(card, parameters=kept, contact_models=("epsd2",))


@pytest.mark.parametrize(
    ("to", "words"),
    [
        ("liggghts", "hertz tangential history rolling_friction epsd2"),
        ("lammps", "#   rolling spring: k_r = k_t R*^2; constant"),
        ("yade", "#   rolling spring: k_r = k_t R*^2; constant"),
    ],
)
def test_a_card_has_the_contact_model_of_the_runs(
    undamped_card: MaterialCard, to: str, words: str
) -> None:
    text = render(undamped_card, to)
    assert words in text
    assert "RollingViscousDamping" not in text


def test_the_rolling_spring_of_a_card_has_no_damping(undamped_card: MaterialCard) -> None:
    text = render(undamped_card, "lammps")
    contacts = [line for line in text.splitlines() if "rolling sds" in line and "string" in line]
    assert len(contacts) >= 2
    assert all(line.split("rolling sds ")[1].split()[1] == "0.0" for line in contacts)


def test_programs_read_the_contact_model(undamped_card: MaterialCard, card: MaterialCard) -> None:
    assert json.loads(render(undamped_card, "json"))["contact_models"] == ["epsd2"]
    assert json.loads(render(card, "json"))["contact_models"] == ["hertz_mindlin", "epsd"]


def solver_text(card: MaterialCard, to: str) -> str:
    """Return the comments of a card in one line."""
    return " ".join(render(card, to).replace("#", " ").split())


@pytest.mark.parametrize("to", ["lammps", "liggghts", "yade"])
def test_a_card_has_the_equation_of_every_term_as_its_solver_computes_it(
    card: MaterialCard, to: str
) -> None:
    law = contact_law(card.values, card.contact_models)
    text = solver_text(card, to)

    for equation in law.equations(to):
        assert equation.words in text
    for convention in law.conventions:
        assert f"{convention.symbol} ({convention.key}): {convention.meaning}" in text
    other = {e.formula for e in law.equations()} - {e.formula for e in law.equations(to)}
    assert bool(other) == (to != "liggghts"), "LIGGGHTS is the reference"
    assert not any(formula in text for formula in other)


@pytest.mark.parametrize(
    ("cohesion", "key"),
    [
        ("jkr", "surface_energy"),
        ("dmt", "surface_energy"),
        ("sjkr", "cohesion_energy_density"),
        ("sjkr2", "cohesion_energy_density"),
    ],
)
def test_the_restitution_of_a_cohesive_card_is_that_without_cohesion(
    card: MaterialCard, cohesion: str, key: str
) -> None:
    values = {**card.values, f"particle_particle.{key}": 0.05}
    law = contact_law(values, (*card.contact_models, cohesion))
    assert [one for one in law.conventions if one.key == "restitution"] == [
        RESTITUTION_WITH_COHESION
    ]


def test_rolling_friction_is_said_to_be_a_multiple_of_the_reduced_radius(
    card: MaterialCard,
) -> None:
    text = solver_text(card, "liggghts")
    assert "rolling limit: k_r theta <= mu_r R* F_n" in text
    assert "mu_r (rolling_friction): largest rolling torque over F_n R*, with the reduced" in text


@pytest.mark.parametrize("to", ["lammps", "liggghts", "yade"])
def test_the_time_step_of_a_card_is_that_of_the_equation_beside_it(
    card: MaterialCard, to: str
) -> None:
    text = solver_text(card, to)
    formula = RAYLEIGH_EQUATIONS[-1].formula
    assert formula in text
    radius = float(text.partition("here, R = ")[2].split()[0])
    values = {"E": "youngs_modulus", "nu": "poissons_ratio", "rho": "density"}
    known = {symbol: card.values[f"particle.{key}"] for symbol, key in values.items()}
    found = evaluate(RAYLEIGH_EQUATIONS, known | {"R": radius})["Rayleigh time step"]
    assert found == pytest.approx(card.rayleigh_time_step)
    assert "10 % of the Rayleigh" in text
    assert card.recommended_time_step == pytest.approx(0.1 * found)


def test_programs_read_the_equations_and_what_solvers_compute_in_another_way(
    card: MaterialCard,
) -> None:
    law = contact_law(card.values, card.contact_models)
    own = law.differing_terms
    expected = [*((None, equation) for equation in law.equations()), *own]

    data = json.loads(render(card, "json"))
    found = data["contact_law"]
    assert found["equations"] == [{"solver": s, **vars(e)} for s, e in expected]
    assert {one["parameter"] for one in found["conventions"]} >= {"rolling_friction", "restitution"}
    assert data["time_step"]["equations"] == [vars(one) for one in RAYLEIGH_EQUATIONS]
    rows = list(csv.DictReader(io.StringIO(render(card, "csv"), newline="")))
    equations = [(row["origin"], row["formula"]) for row in rows if row["kind"] == "equation"]
    assert equations == [(s or "contact law", e.formula) for s, e in expected]
    conventions = {row["name"]: row["meaning"] for row in rows if row["kind"] == "convention"}
    assert "reduced radius" in conventions["rolling_friction"]


@pytest.mark.parametrize("to", ["json", "csv"])
def test_a_card_of_an_own_model_has_no_contact_law(card: MaterialCard, to: str) -> None:
    text = render(replace(card, contact_models=()), to)
    assert "rolling limit" not in text


OWN_MODEL = """\
[[test]]
type = "python"
function = "model.py:simulate"
targets.slope = { value = 5, uncertainty = 0.5 }
"""


def test_a_card_of_an_own_model_has_the_contact_models_of_its_file(tmp_path: Path) -> None:
    material = starter_file(["heap"]).partition("\n[[test]]")[0]
    springs = '\n[contact_models]\ncontact = "linear"\n\n'
    path = tmp_path / "own.toml"
    path.write_text(material + springs + OWN_MODEL)
    (tmp_path / "model.py").write_text(
        "def simulate(parameters, seed):\n"
        "    return {'slope': 10 * parameters['particle_particle.sliding_friction']}\n"
    )
    grainfit.load(path).calibrate(tmp_path / "own.grainfit", max_runs=12)
    # What was calibrated counts.
    path.write_text(material + "\n" + OWN_MODEL)

    card = material_card(tmp_path / "own.grainfit")

    assert card.contact_models == ("linear", "epsd")
    # Linear springs of walls gave a rebound of 0.86 instead of 0.82 at 12 %.
    assert card.time_step_fraction == 0.04
    assert "Contact law: linear and epsd in LIGGGHTS" in render(card, "liggghts")
    assert "Contact law of the calibration: linear and epsd" in render(card, "mfix")


def test_a_card_with_damping_that_its_model_does_not_have_is_refused(card: MaterialCard) -> None:
    with pytest.raises(InputError, match=contact_messages.NO_EFFECT.pattern):
        render(replace(card, contact_models=("epsd2",)), "lammps")


def comment_of(card: MaterialCard, to: str) -> str:
    return " ".join(line.removeprefix("# ") for line in render(card, to).splitlines())


def test_a_card_for_the_other_solver_says_how_much_it_differs(card: MaterialCard) -> None:
    assert card.programs[0].name == "lammps"

    text = comment_of(card, "liggghts")
    assert of_dem.CALIBRATED_DIFFERENTLY.is_in(text, solvers="LAMMPS")
    assert "LAMMPS has one rolling stiffness" in text
    assert "LAMMPS limits the rolling dashpot" in text
    assert "0.5° (glass beads) to 2° (sliding friction 0.5, rolling friction 0.2) larger" in text
    assert "CHECK" not in comment_of(card, "lammps")


def test_without_a_dashpot_the_other_solver_matters_little(
    card: MaterialCard, undamped_card: MaterialCard
) -> None:
    text = comment_of(with_damping(card, 0.0), "liggghts")
    assert "LAMMPS limits the rolling dashpot" not in text
    assert "bulk densities on LIGGGHTS and YADE are up to 0.5 % lower" in text
    # The card without the parameter has EPSD2, which agrees.
    text = comment_of(undamped_card, "liggghts")
    assert "CHECK" not in text
    assert of_dem.CALIBRATED_ALIKE.is_in(text, solvers="LAMMPS")


def test_yade_is_always_to_be_checked(undamped_card: MaterialCard) -> None:
    text = comment_of(undamped_card, "yade")
    assert of_dem.CALIBRATED_DIFFERENTLY.is_in(text, solvers="LAMMPS")
    assert "Rolling friction is not quite the same in YADE" in text
    other = replace(undamped_card, programs=(Program("yade", "2023.02a"),))
    assert "CHECK" in comment_of(other, "liggghts")
