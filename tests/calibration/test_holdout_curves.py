"""Curves that are not fitted are predicted as numbers are."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.analysis.curve_prediction import predict_curve
from grainfit.analysis.prediction import HoldoutEvaluations
from grainfit.arrays import Array
from grainfit.calibration import messages as of_calibration
from grainfit.calibration.registrations import hash_of_targets
from grainfit.calibration_file import messages as of_calibration_file
from grainfit.cli.app import app
from grainfit.evaluation import Curve, Evaluation, Proposal
from grainfit.report.section import ReportContext
from grainfit.report.sections.holdout.section import holdout as section
from grainfit.verdict import messages

#: Modulus of the material, in units of 100 kPa.
MODULUS = 2.0
STRAINS = np.array([0.005, 0.010, 0.015, 0.020, 0.025, 0.030, 0.035, 0.040])
MODEL = """\
import numpy as np

def heap(parameters, seed):
    return {"angle": 10 * parameters["modulus"] + 0.3 * np.random.default_rng(seed).normal()}

def press(parameters, seed):
    strains = np.linspace(0.0, 0.05, 40)
    scatter = 1 + 0.02 * np.random.default_rng([seed, 1]).normal()
    stresses = 1e5 * parameters["modulus"] * strains * (1 + 10 * strains)
    return {"stress": {"coordinates": list(strains), "values": list(scatter * stresses)}}
"""
FILE = """\
name = "sand"
[parameters]
modulus = { min = 1.0, max = 4.0 }
[[test]]
type = "python"
name = "heap"
function = "model.py:heap"
targets.angle = { value = 20.0, uncertainty = 0.5, unit = "deg" }
"""
HELD = """\
[[holdout]]
type = "python"
name = "press"
function = "model.py:press"
targets.stress = { curve = "stress.csv", y_unit = "Pa", uncertainty = "1 %", systematic = "2 %" }
"""


def stresses(modulus: float, strains: Array = STRAINS) -> Array:
    return np.asarray(1e5 * modulus * strains * (1 + 10 * strains))


def press(parameters: dict[str, float], seed: int) -> dict[str, gf.Curve]:
    strains = np.linspace(0.0, 0.05, 40)
    scatter = 1 + 0.02 * np.random.default_rng(seed).normal()
    return {"stress": gf.Curve(strains, scatter * stresses(parameters["modulus"], strains))}


def heap(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"angle": 10 * parameters["modulus"] + 0.3 * np.random.default_rng(seed).normal()}


def held(name: str, values: Array, systematic: str = "2 %") -> gf.Holdout:
    curve = gf.CurveTarget(
        "stress", STRAINS, values, "1 %", systematic, unit="Pa", coordinate="strain"
    )
    return gf.Holdout(name, press, curves=[curve])


@pytest.fixture(scope="module")
def predicted(tmp_path_factory: pytest.TempPathFactory) -> tuple[gf.Result, Path]:
    """Result and work folder of a calibration with three measured curves that are not fitted."""
    folder = tmp_path_factory.mktemp("held") / "work"
    problem = gf.Problem(
        [gf.Parameter("modulus", 1.0, 4.0)], [gf.Target("angle", 10 * MODULUS, uncertainty=0.5)]
    )
    bent = stresses(MODULUS) * (1 + 0.15 * np.linspace(0, 1, 8))
    holdouts = [
        held("right", 1.02 * stresses(MODULUS)),
        held("bent", bent),
        held("blurred", stresses(MODULUS), "40 %"),
    ]
    return gf.calibrate(problem, heap, workdir=folder, holdouts=holdouts), folder


def test_a_curve_is_predicted_refuted_or_tells_nothing(
    predicted: tuple[gf.Result, Path],
) -> None:
    result, folder = predicted
    right, bent, blurred = (one.curves["stress"] for one in result.holdouts)
    assert right.verdict == "predicts"
    assert right.predicted == pytest.approx(stresses(MODULUS).tolist(), rel=0.05)
    assert max(map(abs, right.deviations)) < 1
    assert right.share_of_prior < 0.5
    assert len(right.at_answer) == 3
    # Where it is bent most, and where else it leaves the band.
    assert bent.verdict == "does not predict"
    assert STRAINS[bent.farthest] == 0.04
    outside = sum(abs(one) > 1 for one in bent.deviations)
    assert f"8 points, {outside} lie" in str(result.holdouts[1])
    assert bent.probability < 0.05
    assert blurred.verdict == "does not tell"
    said = (
        messages.HOLDOUT_CURVE_PREDICTED,
        messages.HOLDOUT_CURVE_REFUTED,
        messages.HOLDOUT_CURVE_TELLS_NOTHING,
    )
    for message, one in zip(said, result.holdouts, strict=True):
        assert message.is_in(str(one))
    # What was measured takes no part, but for its errors.
    assert bent.predicted == pytest.approx(right.predicted)
    assert gf.Result.from_json(folder / "result.json") == result
    for one in result.holdouts:
        assert one.registration is not None
    hashes = {one.registration.targets_hash for one in result.holdouts if one.registration}
    assert len(hashes) == 3


def test_report_and_figure_show_the_bands(predicted: tuple[gf.Result, Path]) -> None:
    result, folder = predicted
    saved = gf.open(folder)
    shown = section(ReportContext(saved, saved.analyse()))
    assert shown is not None
    assert len(shown.figures) == 3
    for verdict in ("predicts", "does not predict", "does not tell"):
        assert f" {verdict}</span>" in shown.html
    right = result.holdouts[0].curves["stress"]
    traces = {trace["name"]: trace for trace in shown.figures["holdout-0"].data}
    assert traces["expected"]["y"] == list(right.predicted)
    assert traces["measured, with 95 % intervals"]["y"] == list(right.measured)
    bands = [trace["y"] for trace in traces.values() if trace.get("fill") == "toself"]
    assert [*right.prior_high, *reversed(right.prior_low)] in bands
    assert [*right.high, *reversed(right.low)] in bands
    assert len(gf.plots.holdout(saved).data) == 3 * 5


def test_a_file_holds_a_curve_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("model.py").write_text(MODEL)
    lines = (f"{x},{y}" for x, y in zip(STRAINS, stresses(MODULUS), strict=True))
    Path("stress.csv").write_text("\n".join(["strain,stress [Pa]", *lines, ""]))
    path = Path("sand.toml")
    path.write_text(FILE + HELD)

    def invoke(*arguments: str) -> str:
        done = CliRunner().invoke(app, list(arguments))
        assert done.exit_code == 0, done.output
        return done.output

    assert of_calibration_file.HOLDOUT_MEASURED.is_in(invoke("check", "sand.toml"))
    shown = invoke("run", "sand.toml", "--no-report")
    assert messages.HOLDOUT_CURVE_PREDICTED.is_in(shown)
    status = json.loads(invoke("status", "sand.grainfit", "--json"))
    assert status["holdouts"][0]["curves"]["stress"]["verdict"] == "predicts"
    [setup] = gf.load(path).holdouts
    assert status["holdouts"][0]["registration"]["targets_hash"] == hash_of_targets(setup.measured)
    # The curve of a test, for another material: it is far too stiff.
    path.write_text(FILE + HELD.replace("[[holdout]]", "[[test]]"))
    Path("values.toml").write_text("[parameters]\nmodulus = 3.0\n")
    found = gf.predict(path, tests=["press"], answer_of="values.toml", workdir="kept")["press"]
    assert found.curves["stress"].verdict == "does not predict"


def test_curves_are_fitted_and_numbers_held_out() -> None:
    curve = gf.CurveTarget("stress", STRAINS, stresses(MODULUS), "1 %", systematic="2 %")
    problem = gf.Problem([gf.Parameter("modulus", 1.0, 4.0)], [], curves=[curve])
    angle = gf.Target("angle", 10 * MODULUS, uncertainty=0.5)
    result = gf.calibrate(problem, press, holdouts=[gf.Holdout("heap", heap, [angle])])
    assert result.holdouts[0].responses["angle"].verdict == "predicts"


def test_what_is_no_measured_curve_is_refused() -> None:
    problem = gf.Problem([gf.Parameter("modulus", 1.0, 4.0)], [gf.Target("angle", 20.0)])
    curve = gf.CurveTarget("stress", STRAINS, stresses(MODULUS), "1 %")
    wrong: list[dict[str, Any]] = [
        {"targets": [curve]},
        {"targets": curve},
        {"curves": [gf.Target("stress", 1.0)]},
        {"curves": [curve, curve]},
    ]
    for given in wrong:
        with pytest.raises(gf.InputError, match="holdout press"):
            gf.calibrate(problem, heap, holdouts=[gf.Holdout("press", press, **given)])


def test_a_curve_that_no_run_gives_is_said() -> None:
    problem = gf.Problem([gf.Parameter("modulus", 1.0, 4.0)], [gf.Target("angle", 20.0)])
    far = gf.CurveTarget("stress", [0.01, 0.1], [1e3, 2e4], "1 %")
    result = gf.calibrate(problem, heap, holdouts=[gf.Holdout("press", press, curves=[far])])
    [found] = result.holdouts
    assert result.status == "calibrated"
    assert found.state == "failed"
    assert "shortest is 0 to 0.05" in found.why
    solver = gf.solvers.PythonCallable(heap, ["angle"])
    with pytest.raises(gf.InputError) as refused:
        gf.calibrate(problem, heap, holdouts=[gf.Holdout("press", solver, curves=[far])])
    assert of_calibration.HOLDOUT_WITHOUT_RESPONSE.is_in(str(refused.value))


def test_bands_hold_as_many_curves_as_they_state() -> None:
    # 17 or fewer of 20 at 95 % have a probability of 8 %, 16 or fewer of 3 %.
    assert sum(_is_inside(seed) for seed in range(20)) >= 17


def _is_inside(seed: int) -> bool:
    """Predict the curve, with both kinds of errors, of a parameter that is known to ± 0.1."""
    random = np.random.default_rng(seed)
    middle = random.uniform(0.3, 0.7)
    truth, *sample = middle + 0.1 * random.standard_normal(401)
    places = np.linspace(0.1, 1.0, 12)

    def mean(place: float) -> Array:
        return np.asarray(20 * places + 10 * place**2 * places**2)

    def runs(at: Any) -> list[Evaluation]:
        return [
            Evaluation(
                Proposal({"friction": float(place)}, number + 1, "design"),
                {},
                curves={"flow": Curve(places, mean(place) * (1 + 0.02 * random.standard_normal()))},
            )
            for number, place in enumerate(at)
        ]

    parts = HoldoutEvaluations(runs([middle] * 3), runs(sample[:8]), runs((np.arange(8) + 0.5) / 8))
    errors = 0.02 * random.standard_normal() + 0.01 * random.standard_normal(12)
    measured = gf.CurveTarget("flow", places, mean(truth) * (1 + errors), "1 %", systematic="2 %")
    wanted = gf.Problem([gf.Parameter("friction", 0.0, 1.0)], [gf.Target("other", 1.0)])
    found = predict_curve(wanted, measured, parts, np.array(sample)[:, None])
    return found.verdict != "does not predict"
