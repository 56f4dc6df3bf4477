"""A value whose bias is known is never called determined alone: every face says the same."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from grainfit.analysis.soft_particles import known_biases
from grainfit.bulk_tests.heap import Heap
from grainfit.cards import material_card, render
from grainfit.cli.app import app
from grainfit.problem import Parameter, Problem, Target
from grainfit.testing.materials import GLASS_BEADS
from grainfit.watch.rows import parameter_rows
from grainfit.which_test.determination import interval_of
from grainfit.work_folder.saved_calibration import SavedCalibration

DENSITY = "particle.density"
SLIDING = "particle_particle.sliding_friction"
KIND = "determined, but biased"
SOFT = "soft particles raise bulk_density by about 14 %"

FREE_DENSITY = Parameter(DENSITY, 1400.0, 2800.0, unit="kg/m^3")
TARGET = Target("bulk_density", 1500.0, uncertainty=15.0, unit="kg/m^3")


def biases(*parameters: Parameter, target: Target = TARGET, **changes: float) -> dict[str, str]:
    material = {**GLASS_BEADS, DENSITY: 2100.0, "particle.youngs_modulus": 0.36e6, **changes}
    test = Heap(diameter="10 mm")
    return known_biases(Problem([*parameters], [target]), {"heap": test}, material)


def test_soft_particles_bias_the_density_or_what_else_is_free() -> None:
    assert biases(FREE_DENSITY) == {DENSITY: SOFT}
    friction = Parameter(SLIDING, 0.1, 0.9)
    assert biases(FREE_DENSITY, friction) == {DENSITY: SOFT}
    assert biases(friction) == {SLIDING: SOFT}
    assert biases(FREE_DENSITY, **{"particle.youngs_modulus": 1e9}) == {}
    angle = Target("angle_of_repose", 22.0, tolerance=0.5, unit="deg")
    assert biases(FREE_DENSITY, target=angle) == {}


def test_a_bias_is_said_of_narrow_intervals_and_not_of_measured_values() -> None:
    assert interval_of(FREE_DENSITY, 2000.0, 2050.0, SOFT).determination == KIND
    assert interval_of(FREE_DENSITY, 2000.0, 2700.0, SOFT).determination == "narrowed"
    assert interval_of(FREE_DENSITY, 2000.0, 2050.0).determination == "determined"
    own = replace(FREE_DENSITY, measured=2500.0, uncertainty=10.0)
    assert interval_of(own, 2480.0, 2520.0, SOFT).determination == "determined"


@pytest.fixture(scope="module")
def saved(beads: Path) -> SavedCalibration:
    return SavedCalibration.open(beads)


def test_result_report_watch_and_status_agree(saved: SavedCalibration, beads: Path) -> None:
    assert saved.result is not None
    found = saved.result.intervals[DENSITY]
    assert found.determination == KIND
    assert found.bias.startswith("soft particles raise bulk_density by about ")
    assert f"but biased: {found.bias}" in found.in_words(saved.result.parameters[DENSITY])
    printed = " ".join(str(saved.result).split())
    assert KIND in printed
    assert f"Biased: {DENSITY}: {found.bias}" in printed

    analysis = saved.analyse()
    assert analysis.intervals[DENSITY].determination == KIND
    assert analysis.identifiability is not None
    [verdict] = [v for v in analysis.identifiability.verdicts if v.startswith(DENSITY)]
    assert verdict.endswith(f", but biased: {found.bias}.")

    [row] = [row for row in parameter_rows(saved, saved.result) if row["name"] == DENSITY]
    assert (row["determination"], row["bias"]) == (KIND, found.bias)

    status = CliRunner().invoke(app, ["status", str(beads), "--json"])
    stated = json.loads(status.output)["parameters"][DENSITY]
    assert (stated["determination"], stated["bias"]) == (KIND, found.bias)

    page = beads / "page.html"
    done = CliRunner().invoke(app, ["report", str(beads), "--output", str(page)])
    assert done.exit_code == 0, done.output
    html = page.read_text(encoding="utf-8")
    assert f'data-explanation="{found.bias}">! {KIND}<' in html


@pytest.mark.parametrize("to", ["lammps", "liggghts", "yade"])
def test_a_card_says_why(saved: SavedCalibration, to: str) -> None:
    assert saved.result is not None
    bias = saved.result.intervals[DENSITY].bias
    assert f"determined, but biased: {bias}" in render(material_card(saved.folder), to)


def test_tables_of_a_card_have_kind_and_reason(saved: SavedCalibration) -> None:
    assert saved.result is not None
    bias = saved.result.intervals[DENSITY].bias
    card = material_card(saved.folder)
    [found] = [p for p in json.loads(render(card, "json"))["parameters"] if p["name"] == DENSITY]
    assert (found["determination"], found["bias"]) == (KIND, bias)
    head, *lines = render(card, "csv").splitlines()
    assert "determination,bias" in head
    [line] = [line for line in lines if f",{DENSITY}," in line]
    assert f'"{KIND}",{bias}' in line
