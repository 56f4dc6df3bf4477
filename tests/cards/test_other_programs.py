"""Cards of programs that are not run here: their conventions, applied as their sources do."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from typer.testing import CliRunner

from grainfit.cards import FORMATS, CardParameter, MaterialCard, messages, render
from grainfit.cli.app import app
from grainfit.contact_models.hertz_mindlin.model import damping_factor, particle_moduli
from grainfit.contact_models.registry import MATERIAL_PARAMETERS, with_defaults
from grainfit.errors import InputError
from grainfit.materials.card_text import comment

MARKS = {
    "edem": "#",
    "rocky": "#",
    "mercurydpm": "//",
    "pfc": ";",
    "mfix": "!",
    "aspherix": "#",
}
#: What a line that is no comment looks like.
SYNTAX = {
    "edem": r"[A-Z][\w ()':,.-]* = \S.*",
    "rocky": r"[A-Z][\w ()':,.-]* = \S.*",
    "mercurydpm": r"[\w>-]+\([^()\n]*\);|auto \w+ = [\w.]+\([\w(), ]*\);",
    "pfc": r"\[\w+ = [-\w.+]+\]|ball attribute density [\d.e+-]+",
    "mfix": r"  [\w()]+ = ('\w+'|[-\d.e+]+)",
    "aspherix": r"(materials|material_\w+|particle_contact_model|wall_contact_model) .*",
}
DIAMETER = 0.010
OVERLAP = 2e-5


def with_models(card: MaterialCard, *names: str, **values: float) -> MaterialCard:
    """Return a card of other contact models, with more parameters between particles."""
    more = [
        CardParameter(f"{section}.{key}", "", "", "", value, "given")
        for section in ("particle_particle", "particle_wall")
        for key, value in values.items()
    ]
    own = {parameter.name for parameter in more}
    kept = [p for p in card.parameters if p.name not in own]
    return replace(card, parameters=(*kept, *more), contact_models=names)


def written(card: MaterialCard, to: str) -> dict[str, list[float]]:
    """Return the numbers of all settings that a card has, by name, in their order."""
    found: dict[str, list[float]] = {}
    for line in render(card, to).splitlines():
        if line.startswith(MARKS[to]) or not line.strip():
            continue
        name, _, rest = (
            line.strip("[]; ").replace("(1)", "").partition("=" if to != "mercurydpm" else "(")
        )
        numbers = [float(n) for n in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", rest)]
        found.setdefault(name.strip(), []).extend(numbers)
    return found


def hertz(values: dict[str, float], body: str) -> tuple[float, float, float, float, float]:
    """Return k_n = 4/3 E* a, k_t = 8 G* a, c_n, c_t and R* of the calibration at an overlap."""
    moduli = particle_moduli(values, body)
    radius = DIAMETER / (4 if body == "particle" else 2)
    a = math.sqrt(radius * OVERLAP)
    mass = values["particle.density"] * math.pi / 6 * DIAMETER**3
    reduced = mass / 2 if body == "particle" else mass
    beta = damping_factor(values[f"particle_{body}.restitution"])
    normal = 2 * math.sqrt(5 / 6) * beta * math.sqrt(2 * moduli.young * a * reduced)
    tangential = 2 * math.sqrt(5 / 6) * beta * math.sqrt(8 * moduli.shear * a * reduced)
    return 4 / 3 * moduli.young * a, 8 * moduli.shear * a, normal, tangential, radius


def reduced_mass(values: dict[str, float], body: str) -> float:
    mass = values["particle.density"] * math.pi / 6 * DIAMETER**3
    return mass / 2 if body == "particle" else mass


def ratio(restitution: float) -> float:
    """Return |ln e| / sqrt(ln^2 e + pi^2), as the programs compute it."""
    return abs(math.log(restitution)) / math.sqrt(math.pi**2 + math.log(restitution) ** 2)


@pytest.mark.parametrize("body", ["particle", "wall"])
def test_mfix_computes_the_springs_dashpots_and_largest_torque_of_the_calibration(
    card: MaterialCard, body: str
) -> None:
    values = with_defaults(card.values)
    _, _, normal, tangential, radius = hertz(values, body)
    moduli = particle_moduli(values, body)
    found = written(card, "mfix")
    middle, end = ("", "") if body == "particle" else ("_WALL", "W")
    [en], [et] = found[f"DES_EN{middle}_INPUT"], found[f"DES_ET{middle}_INPUT"]
    mass = reduced_mass(values, body)
    # check_solids_dem.f and calc_force_dem.f of version 25.2.1.
    hertz_kn = 4 / 3 * math.sqrt(radius) * moduli.young
    hertz_kt = 8 * math.sqrt(radius) * moduli.shear
    root = math.sqrt(math.sqrt(OVERLAP))
    assert math.sqrt(5 * hertz_kn * mass) * ratio(en) * root == pytest.approx(normal)
    assert math.sqrt(5 * hertz_kt * 2 / 7 * mass) * ratio(et) * root == pytest.approx(tangential)
    [rolling] = found[f"MEW_R{end}"]
    friction = values[f"particle_{body}.rolling_friction"]
    assert rolling * DIAMETER == pytest.approx(friction * radius)
    # Version 21.3.2 has 2 in place of sqrt(5), and lengths for rolling friction.
    notes = " ".join(render(card, "mfix").replace("!", " ").split())
    number = r"(\d\.\d+(?:e-\d+)?)"
    old_en = re.findall(rf"2 in its place and wants {number} DES_EN", notes)
    old_et = re.findall(rf"version 21.3.2 wants {number} DES_ET", notes)
    old_rolling = re.findall(rf"Version 21.3.2 has MEW_R F_n, and wants {number} \(m\)", notes)
    index = 0 if body == "particle" else 1
    en, et, length = (float(one[index]) for one in (old_en, old_et, old_rolling))
    assert 2 * math.sqrt(hertz_kn * mass) * ratio(en) * root == pytest.approx(normal)
    assert 2 * math.sqrt(hertz_kt * 2 / 7 * mass) * ratio(et) * root == pytest.approx(tangential)
    assert length == pytest.approx(friction * radius)


@pytest.mark.parametrize(("body", "owner"), [("particle", "particle"), ("wall", "particle_wall")])
def test_mercurydpm_computes_the_springs_dashpots_and_largest_torque_of_the_calibration(
    card: MaterialCard, body: str, owner: str
) -> None:
    values = with_defaults(card.values)
    k_n, k_t, normal, tangential, radius = hertz(values, body)
    found = written(card, "mercurydpm")
    modulus, restitution = found[f"{owner}->setEffectiveElasticModulusAndRestitutionCoefficient"]
    [shear] = found[f"{owner}->setEffectiveShearModulus"]
    [sliding] = found[f"{owner}->setSlidingDissipation"]
    mass = reduced_mass(values, body)
    # HertzianViscoelasticInteraction.cc and MindlinInteraction.cc.
    stiffness = 4 / 3 * modulus * math.sqrt(radius * OVERLAP)
    logarithm = math.log(restitution) ** 2
    dissipation = math.sqrt(5 * logarithm / (logarithm + math.pi**2))
    zero = 8 * shear * math.sqrt(radius * OVERLAP)
    assert stiffness == pytest.approx(k_n)
    assert dissipation * math.sqrt(mass * stiffness) == pytest.approx(normal)
    assert 2 / 3 * zero == pytest.approx(k_t)
    assert sliding * math.sqrt(mass * zero) == pytest.approx(tangential)
    # MindlinRollingTorsionInteraction.cc: the lever of the rolling force is R*.
    [rolling] = found[f"{owner}->setRollingFrictionCoefficient"]
    assert rolling * radius == pytest.approx(values[f"particle_{body}.rolling_friction"] * radius)


def test_constant_torques_of_edem_and_rocky_are_those_of_the_calibration(
    card: MaterialCard,
) -> None:
    values = with_defaults(card.values)
    torques = [
        values[f"particle_{body}.rolling_friction"] * DIAMETER / divisor
        for body, divisor in (("particle", 4), ("wall", 2))
    ]
    edem = written(card, "edem")
    standard = edem["Coefficient of Rolling Friction (Standard)"]
    assert [one * DIAMETER / 2 for one in standard] == pytest.approx(torques)
    pair, wall = edem["Coefficient of Rolling Friction (RVD)"]
    assert [pair * DIAMETER / 4, wall * DIAMETER / 2] == pytest.approx(torques)
    [rocky] = written(card, "rocky")["Rolling Resistance (Type A: constant moment)"]
    assert rocky * DIAMETER / 2 == pytest.approx(torques[0])


@pytest.mark.parametrize("to", MARKS)
def test_what_has_no_counterpart_or_no_public_formula_is_not_written(
    card: MaterialCard, to: str
) -> None:
    assert to in FORMATS
    linear = with_models(card, "linear", "epsd2", normal_stiffness=1500.0)
    sticky = with_models(card, "hertz_mindlin", "epsd", "jkr", surface_energy=0.0123)
    for one in (linear, sticky):
        assert "NOT WRITTEN" in render(one, to)
    assert not any(0.0123 in numbers for numbers in written(sticky, to).values())
    springs = {1500.0} if to != "pfc" else set()
    assert not springs & {n for numbers in written(linear, to).values() for n in numbers}
    if to == "pfc":
        assert written(linear, to)["kn"] == [1500.0, 1500.0]
        assert "rolling friction" in render(card, to)
        assert "rr_fric" not in written(linear, to)
    if to in ("edem", "rocky"):
        assert not any("Type C" in name for name in written(card, to))


@pytest.mark.parametrize("to", MARKS)
def test_every_value_has_its_note_and_every_card_its_sources(card: MaterialCard, to: str) -> None:
    lines = render(card, to).splitlines()
    for before, line in pairwise(lines):
        if line.strip() and not line.startswith(MARKS[to]):
            assert re.fullmatch(SYNTAX[to], line), line
            assert before.startswith(MARKS[to]), "the conversion stands above the value"
            assert len(before.removeprefix(MARKS[to]).strip()) > 2
    text = "\n".join(lines)
    assert "Sources of the conventions:" in text
    assert messages.NOT_RUN.is_in(" ".join(text.replace(MARKS[to], " ").split()))
    for parameter in card.parameters:
        assert f"{parameter.name} = {parameter.value!r}" in text


@pytest.mark.parametrize("to", MARKS)
def test_names_that_are_up_to_no_good_stay_in_comments(nasty_card: MaterialCard, to: str) -> None:
    lines = render(replace(nasty_card, name="beads\\"), to).splitlines()
    assert not any(line.endswith("\\") for line in lines)
    for line in lines:
        assert not line.strip() or line.startswith(MARKS[to]) or re.fullmatch(SYNTAX[to], line)
    assert comment("beads\\").endswith("\\"), "what a C++ comment must not end with"


@pytest.mark.parametrize("to", MARKS)
def test_a_card_without_a_value_that_is_needed_names_it(card: MaterialCard, to: str) -> None:
    kept = tuple(p for p in card.parameters if p.name != "particle_wall.restitution")
    with pytest.raises(InputError, match=r"needs particle_wall\.restitution"):
        render(replace(card, parameters=kept), to)


def test_several_walls_have_contacts_of_their_own(card: MaterialCard) -> None:
    named = [
        replace(p, name=p.name.replace(".", ".rubber.", 1), value=0.9)
        for p in card.parameters
        if p.name == "particle_wall.sliding_friction"
    ]
    needed = [n for n, known in MATERIAL_PARAMETERS.items() if known.default is None]
    more = [
        CardParameter(n.replace(".", ".rubber.", 1), "", "", "", card.values[n], "given")
        for n in needed
        if n.startswith(("wall.", "particle_wall.")) and n != "particle_wall.sliding_friction"
    ]
    walls = replace(card, parameters=(*card.parameters, *named, *more))
    assert 0.9 in written(walls, "edem")["Coefficient of Static Friction"]
    assert "particle_wall_rubber->setSlidingFrictionCoefficient(0.9);" in render(
        walls, "mercurydpm"
    )
    assert "NOT WRITTEN: MEW_W: MFiX has one material for all walls" in render(walls, "mfix")


def test_the_command_writes_them(beads: Path, tmp_path: Path) -> None:
    file = tmp_path / "beads.txt"
    done = CliRunner().invoke(app, ["export", str(beads), "--to", "edem", "-o", str(file)])
    assert done.exit_code == 0, done.output
    assert "Coefficient of Static Friction = " in file.read_text(encoding="utf-8")
