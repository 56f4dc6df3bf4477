"""Stiffness of particles: the bulk density that their overlap adds, and what is said about it."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

import grainfit as gf
from grainfit.analysis.soft_particles import stiffness_notes
from grainfit.bulk_tests.stiffness import (
    IN_SHEAR,
    UNDER_A_STRESS,
    UNDER_OWN_WEIGHT,
    stiffness_number,
)
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.starter import starter_file
from grainfit.cli.console import print_plan
from grainfit.testing.materials import GLASS_BEADS
from grainfit.which_test import messages

EXAMPLE = Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml"
MODULUS, DENSITY = "particle.youngs_modulus", "particle.density"


def notes(answer: dict[str, float] | None = None, **changes: float) -> tuple[str, ...]:
    setup = gf.load(EXAMPLE)
    fixed = {**setup.file.fixed, **{f"particle.{k}": v for k, v in changes.items()}}
    return stiffness_notes(setup.problem, setup.bulk_tests, fixed, answer)


def test_the_number_is_that_of_the_same_heap_at_every_size_and_density() -> None:
    heap = gf.tests.Heap(diameter="10 mm")
    assert stiffness_number(heap, GLASS_BEADS) == pytest.approx(1747, abs=1)
    moon = gf.tests.Heap(diameter="50 mm", gravity=1.62)
    scaled = {**GLASS_BEADS, MODULUS: 3.6e5 * 5 * 1.62 / 9.81 * 2, DENSITY: 4200.0}
    assert stiffness_number(moon, scaled) == pytest.approx(1747, abs=1)


@pytest.mark.parametrize(
    "measured",
    [
        # Frictions 0.5 and 0.2; glass beads of the example: E/(rho g d), solid fraction.
        {525: 0.673, 1750: 0.609, 5250: 0.573, 17_500: 0.553, 52_500: 0.543},
        {1747: 0.6463, 6990: 0.6009, 27_960: 0.5812, 111_840: 0.5696, 447_000: 0.5684},
    ],
)
def test_the_excess_is_that_of_measured_heaps(measured: dict[float, float]) -> None:
    stiff = [
        fraction / (1 + UNDER_OWN_WEIGHT.excess(number)) for number, fraction in measured.items()
    ]
    assert max(stiff) / min(stiff) < 1.006


@pytest.mark.parametrize(
    "measured",
    [
        # Rolling friction 0.66; frictions 0.5 and 0.2: E/stress, bulk density.
        {1000: 1240.0, 4000: 1205.3, 16_000: 1183.7, 64_000: 1174.0},
        {1000: 1186.5, 4000: 1141.6, 16_000: 1126.3},
    ],
)
def test_the_excess_under_a_stress_is_that_of_measured_compressions(
    measured: dict[float, float],
) -> None:
    stiff = [density / (1 + UNDER_A_STRESS.excess(number)) for number, density in measured.items()]
    assert max(stiff) / min(stiff) < 1.008


def test_the_excess_in_shear_is_that_of_measured_beds() -> None:
    measured = {720: 1237.9, 2880: 1171.4, 11_520: 1149.4, 46_080: 1144.6}
    stiff = [density / (1 + IN_SHEAR.excess(number)) for number, density in measured.items()]
    assert max(stiff) / min(stiff) < 1.008


def test_softer_particles_never_have_less_excess() -> None:
    for law in (UNDER_OWN_WEIGHT, UNDER_A_STRESS, IN_SHEAR):
        many = [law.excess(number) for number in (100, 525, 1000, 1750, 9000, 52_500, 1e7)]
        assert many == sorted(many, reverse=True)
        assert many[-1] == 0.0


def test_the_number_of_an_excess_has_that_excess() -> None:
    for excess in (0.4, 0.1, 0.02, 0.01):
        assert UNDER_OWN_WEIGHT.excess(UNDER_OWN_WEIGHT.number_with(excess)) == pytest.approx(
            excess
        )


def test_the_example_of_the_paper_is_told_its_excess_and_a_modulus() -> None:
    [note] = notes()
    assert "E/(ρ g d) = 1750: bulk_density is about 14 % above that of stiff particles" in note
    assert "(11 to 16 % within the intervals)" in note
    assert "the fitted particle density is too low" in note
    assert "2 % with 7.1 MPa (2.7 times as many time steps)" in note
    assert "angle_of_repose" not in note


def test_an_answer_has_one_value_and_stiff_particles_are_not_mentioned() -> None:
    [note] = notes({DENSITY: 2300.0, "particle_particle.rolling_friction": 0.5})
    assert "within the intervals" not in note
    assert notes(youngs_modulus=4e8) == ()


def test_nothing_is_said_where_no_target_depends_on_it() -> None:
    setup = gf.load(EXAMPLE)
    angle = replace(setup.problem, targets=[setup.problem.targets[1]])
    assert stiffness_notes(angle, setup.bulk_tests, setup.file.fixed) == ()


def compression_notes(stress: str) -> tuple[str, ...]:
    problem = gf.Problem(
        [gf.Parameter(DENSITY, 2000.0, 3000.0)],
        [gf.Target("bulk_density", 1500.0), gf.Target("loading_modulus", 3e5)],
    )
    test = gf.tests.Compression(diameter="10 mm", stress=stress)
    return stiffness_notes(problem, {"press": test}, {**GLASS_BEADS, MODULUS: 1e7})


def test_the_note_of_a_compression_depends_on_its_stress() -> None:
    [note] = compression_notes("10 kPa")
    assert "E/stress = 1000: bulk_density is about 6.1 % above" in note
    assert "loading_modulus" not in note
    assert "within the intervals" not in note
    [note] = compression_notes("2.5 kPa")
    assert "E/stress = 4000: bulk_density is about 2.4 % above" in note
    assert compression_notes("200 Pa") == ()


def test_nothing_is_said_of_a_response_that_does_not_depend_on_the_modulus() -> None:
    problem = gf.Problem(
        [gf.Parameter(DENSITY, 2000.0, 3000.0)],
        [gf.Target("bulk_density", 1500.0), gf.Target("mass_flow", 1.0)],
    )
    [note] = stiffness_notes(
        problem, {"discharge": gf.tests.Discharge(diameter="10 mm")}, GLASS_BEADS
    )
    assert "bulk_density is about" in note
    assert "mass_flow" not in note


def test_a_material_that_is_not_known_or_impossible_has_no_note() -> None:
    setup = gf.load(EXAMPLE)
    tests, fixed = setup.bulk_tests, setup.file.fixed
    unknown = {name: value for name, value in fixed.items() if name != MODULUS}
    assert stiffness_notes(setup.problem, tests, unknown) == ()
    impossible = gf.Problem([gf.Parameter(DENSITY, 0.0, 3000.0)], setup.problem.targets)
    assert stiffness_notes(impossible, tests, fixed) == ()


def test_the_starter_file_has_particles_that_are_stiff_enough(tmp_path: Path) -> None:
    path = tmp_path / "beads.toml"
    path.write_text(starter_file())
    setup = gf.load(path)
    [test] = setup.bulk_tests.values()
    middle = setup.problem.from_unit([0.5] * setup.problem.dimension)
    number = stiffness_number(test, {**setup.file.fixed, **middle})
    assert UNDER_OWN_WEIGHT.excess(number) < 0.0205


def test_check_says_it(tmp_path: Path) -> None:
    setup = gf.load(EXAMPLE)
    [note] = [note for note in setup.notes() if note.startswith("The particles are soft")]
    assert "about 14 % above" in note
    console = Console(file=io.StringIO(), width=1000)
    print_plan(console, describe_plan(setup))
    assert isinstance(console.file, io.StringIO)
    assert f"Note: {note}\n" in console.file.getvalue()
    text = EXAMPLE.read_text().replace(
        "sliding_friction = 0.18", "sliding_friction = { min = 0.1, max = 0.8 }"
    )
    path = tmp_path / "beads.toml"
    path.write_text(text)
    _, frictions, soft, *_ = gf.load(path).notes()
    assert messages.HARDLY_TOLD_APART.is_in(frictions, tests="heap")
    assert soft == note
