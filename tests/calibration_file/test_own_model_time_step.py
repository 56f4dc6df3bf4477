"""Own models whose parameters bear the names of the contact model: time step, `prefer`, card."""

from __future__ import annotations

from pathlib import Path

import pytest

import grainfit as gf
from grainfit.calibration_file import messages as of_calibration_file
from grainfit.calibration_file.plan import describe_plan

MODEL = """\
def drum(parameters, seed):
    friction = parameters["particle_particle.sliding_friction"]
    stiffness = parameters["particle.youngs_modulus"]
    return {"angle": 10 + 40 * friction + 1e-9 * stiffness + 0.01 * (seed % 3)}
"""
FILE = """\
name = "drum"
[particle]
density = 2500
poissons_ratio = 0.25
youngs_modulus = { min = "5 MPa", max = "500 MPa", scale = "log" }
[particle_particle]
sliding_friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:drum"
targets.angle = { value = 30, tolerance = 0.5, unit = "deg" }
[strategy]
workers = 1
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "model.py").write_text(MODEL)
    path = tmp_path / "drum.toml"
    path.write_text(FILE)
    monkeypatch.chdir(tmp_path)
    return path


def test_the_largest_time_step_is_preferred_and_on_the_card(file: Path) -> None:
    file.write_text(FILE.replace("[particle]", '[particle]\ndiameter = "5 mm"'))
    result = gf.load(file).calibrate()
    assert result.status == "calibrated"
    # Young's modulus hardly matters: the softest particles have the largest time step.
    assert result.parameters["particle.youngs_modulus"] < 10e6
    card = gf.open("drum.grainfit").card()
    assert card.rayleigh_time_step == pytest.approx(result.rayleigh_time_step)
    assert card.recommended_time_step == pytest.approx(0.12 * result.rayleigh_time_step)
    assert "particle.youngs_modulus" in {parameter.name for parameter in card.parameters}


def test_check_says_what_the_time_step_lacks(file: Path) -> None:
    [line] = [line for line in describe_plan(gf.load(file)).lines if "Rayleigh" in line]
    assert of_calibration_file.NO_RAYLEIGH_TIME_STEP.is_in(
        line, missing="particle.diameter", verb="is"
    )
    file.write_text(FILE.replace("poissons_ratio = 0.25\n", ""))
    [line] = [line for line in describe_plan(gf.load(file)).lines if "Rayleigh" in line]
    lacking = "particle.poissons_ratio and particle.diameter"
    assert of_calibration_file.NO_RAYLEIGH_TIME_STEP.is_in(line, missing=lacking, verb="are")


def test_names_that_seeds_have_are_taken(file: Path) -> None:
    file.write_text(FILE.replace("[[test]]", "[parameters]\nprime_seed = 4\n[[test]]"))
    with pytest.raises(gf.InputError, match=r"parameters\.prime_seed"):
        gf.load(file)
