"""Targets of zero and below: tolerance, misfit, verdict, terminal, report and cards."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.calibration_file.plan import describe_plan
from grainfit.formatting import deviation_off
from grainfit.verdict import messages
from grainfit.verdict.out_of_reach import OutOfReach

MODEL = """\
import random

def shear(parameters, seed):
    friction, stiffness = parameters["friction"], parameters["stiffness"]
    scatter = random.Random(seed)
    return {
        "dilatancy": 2 * (friction - 0.5) + scatter.gauss(0, 0.02),
        "force": -10 * stiffness - 20 * friction + scatter.gauss(0, 0.1),
    }
"""
FILE = """\
name = "shear"
[parameters]
friction = { min = 0.1, max = 0.9 }
stiffness = { min = 0.5, max = 3 }
[[test]]
type = "python"
function = "model.py:shear"
targets.dilatancy = { value = "0 mm", tolerance = "50 um", unit = "mm" }
targets.force = { value = -30, uncertainty = "2 %", unit = "N" }
[strategy]
workers = 1
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "model.py").write_text(MODEL)
    path = tmp_path / "shear.toml"
    path.write_text(FILE)
    monkeypatch.chdir(tmp_path)
    return path


@pytest.mark.parametrize("strategy", ["sequential", pytest.param("staged", marks=pytest.mark.slow)])
def test_responses_that_cross_zero_are_calibrated(file: Path, strategy: str) -> None:
    setup = gf.load(file)
    result = setup.calibrate(strategy=strategy)
    assert result.status == "calibrated"
    # 2 (f - 0.5) = 0 and -10 s - 20 f = -30.
    assert result.parameters == pytest.approx({"friction": 0.5, "stiffness": 2.0}, rel=0.05)
    dilatancy, force = result.responses["dilatancy"], result.responses["force"]
    assert dilatancy.deviation_percent is None
    assert force.deviation_percent is not None
    assert force.deviation_percent == pytest.approx(100 * (force.predicted + 30) / 30)
    [line] = [line for line in str(result).splitlines() if line.startswith("dilatancy ")]
    assert " mm" in line.split("±")[-1], "the deviation has the unit instead of percent"
    assert "%" not in line
    if strategy == "sequential":
        _require_sound_outputs()


def _require_sound_outputs() -> None:
    """Report and cards of the calibration show both targets, and no number that is none."""
    saved = gf.open("shear.grainfit")
    page = saved.report().read_text(encoding="utf-8")
    assert "dilatancy" in page
    shown = re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.DOTALL)
    for word in ("nan", "inf", "infinity"):
        assert not re.search(rf"\b{word}\b", shown, re.IGNORECASE), word
    blocks = re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', page, re.DOTALL)
    for block in blocks:
        json.loads(block, parse_constant=pytest.fail)
    assert blocks
    card = saved.card()
    card.write("json", "card.json")
    found = {
        response["name"]: response
        for response in json.loads(Path("card.json").read_text())["responses"]
    }
    assert found["dilatancy"]["deviation_percent"] is None
    assert abs(found["force"]["deviation_percent"]) < 2
    card.write("csv", "card.csv")
    assert "nan" not in Path("card.csv").read_text().lower()
    assert gf.Result.from_json("shear.grainfit/result.json") == saved.result
    posterior = saved.analyse().posterior
    low, high = posterior.interval("friction")
    assert low < 0.5 < high
    assert high - low < 0.2


def test_check_and_run_agree_on_the_tolerances(file: Path) -> None:
    plan = describe_plan(gf.load(file))
    tolerances = {target.name: target.tolerance for target in plan.targets}
    assert tolerances == pytest.approx({"dilatancy": 0.05, "force": 0.6})
    assert plan.problems == ()


@pytest.mark.parametrize(
    ("given", "key", "words"),
    [
        ("{ value = 0 }", "dilatancy.tolerance", "2 % of the value, the default, is nothing"),
        ('{ value = 0, uncertainty = "1 %" }', "dilatancy.uncertainty", "1 %. Give it in the unit"),
        (
            '{ value = 0, tolerance = "5 %", uncertainty = 1 }',
            "dilatancy.tolerance",
            "5 %. Give it",
        ),
        ("{ value = -1, tolerance = -0.1 }", "dilatancy.tolerance", "-0.1"),
        ("{ value = nan, tolerance = 0.1 }", "dilatancy.value", "nan"),
    ],
)
def test_faults_in_the_file_name_key_and_remedy(
    file: Path, given: str, key: str, words: str
) -> None:
    lines = [
        f"targets.dilatancy = {given}" if line.startswith("targets.dilatancy") else line
        for line in FILE.splitlines()
    ]
    file.write_text("\n".join(lines))
    with pytest.raises(gf.InputError) as caught:
        gf.load(file)
    assert key in str(caught.value)
    assert words in str(caught.value)


def test_measurements_about_zero_have_their_standard_error(file: Path) -> None:
    file.write_text(
        FILE.replace('value = "0 mm", tolerance = "50 um"', "measurements = [-0.1, 0.1]")
    )
    target = gf.load(file).problem.targets[0]
    # Student's t of 0.975 with 1 degree of freedom is 12.7062.
    assert target.value == 0.0
    assert target.tolerance == pytest.approx(12.7062 / 1.96 * 0.1, rel=1e-4)


def test_faults_in_python_name_key_and_remedy() -> None:
    with pytest.raises(gf.InputError, match=r"force\.tolerance: is missing"):
        gf.Target("force", 0.0)
    with pytest.raises(gf.InputError, match=r"force\.uncertainty: is '1 %'"):
        gf.Target("force", 0.0, uncertainty="1 %")  # type: ignore[arg-type]
    with pytest.raises(gf.InputError, match=r"force\.value: is inf"):
        gf.Target("force", math.inf, tolerance=1.0)


def test_relative_deviations_only_where_zero_is_outside_the_tolerance() -> None:
    positive, negative = gf.Target("a", 50.0), gf.Target("a", -50.0)
    assert negative.tolerance == positive.tolerance == 1.0
    assert positive.relative_deviation(51.0) == pytest.approx(0.02)
    assert negative.relative_deviation(-49.0) == pytest.approx(0.02), "larger is positive"
    about_zero = gf.Target("a", -0.5, tolerance=1.0)
    assert about_zero.relative_deviation(0.5) is None
    # One tolerance counts as much as one of 2 % of a value.
    assert about_zero.misfit(0.5) == pytest.approx(positive.misfit(51.0))
    assert gf.Target("a", "-2 mm", tolerance="10 %").tolerance == pytest.approx(2e-4)  # type: ignore[arg-type]


def test_deviations_are_shown_with_the_unit_where_percent_makes_no_sense() -> None:
    assert deviation_off(3.5, 1.0, 1.0, "mm") == "+3.50 %"
    assert deviation_off(None, -0.0312, 0.05, "mm") == "-0.031 mm"
    assert deviation_off(None, -1e-12, 0.05, "") == "+0.000"
    assert deviation_off(None, 12.3, 0.0001, "°") == "+12.30000°"
    assert deviation_off(None, -1.234e9, 1e7, "Pa") == "-1.234e+09 Pa"


def test_target_of_zero_that_is_out_of_reach_is_told_without_a_percentage() -> None:
    words = str(OutOfReach("dilatancy", 0.0, 1.0, 0.02))

    assert messages.OUT_OF_REACH.is_in(
        words, target="dilatancy", value=0, nearest="1.000 ± 0.039", share=""
    )
    assert "%" not in words
