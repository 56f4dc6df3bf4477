"""Material cards of another contact model, and for another solver than that of the runs."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from grainfit.cards import render
from grainfit.contact_models import messages as contact_messages
from grainfit.errors import InputError
from grainfit.materials.card import MaterialCard, Program


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
        ("lammps", "# EPSD2 of LIGGGHTS:  k = k_t"),
        ("yade", "the rolling friction EPSD2 of LIGGGHTS"),
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


def test_a_card_with_damping_that_its_model_does_not_have_is_refused(card: MaterialCard) -> None:
    with pytest.raises(InputError, match=contact_messages.NO_EFFECT.pattern):
        render(replace(card, contact_models=("epsd2",)), "lammps")


def comment_of(card: MaterialCard, to: str) -> str:
    return " ".join(line.removeprefix("# ") for line in render(card, to).splitlines())


def test_a_card_for_the_other_solver_says_how_much_it_differs(card: MaterialCard) -> None:
    assert card.programs[0].name == "lammps"

    text = comment_of(card, "liggghts")
    assert "CHECK: the values were calibrated with LAMMPS. LAMMPS has one rolling stiffness" in text
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
    assert "calibrated with LAMMPS, which agrees without a rolling dashpot." in text


def test_yade_is_always_to_be_checked(undamped_card: MaterialCard) -> None:
    text = comment_of(undamped_card, "yade")
    assert "CHECK: the values were calibrated with LAMMPS." in text
    assert "Rolling friction is not quite the same in YADE" in text
    other = replace(undamped_card, programs=(Program("yade", "2023.02a"),))
    assert "CHECK" in comment_of(other, "liggghts")
