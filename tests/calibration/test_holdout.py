"""Tests that are not fitted are registered before the first run, and predicted after it."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import textwrap
import time
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.analysis.prediction import HoldoutEvaluations, predict_response
from grainfit.calibration import live_file
from grainfit.calibration import messages as of_calibration
from grainfit.calibration.holdout import require_not_fitted
from grainfit.calibration.registrations import HOLDOUTS_NAME, hash_of_targets
from grainfit.calibration_file import messages as of_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.campaign.campaign import CampaignOptions
from grainfit.cli.app import app
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.report.section import ReportContext
from grainfit.report.sections.holdout.section import holdout as section
from grainfit.report.verdict import shown_verdict
from grainfit.result import HoldoutResult
from grainfit.result import messages as of_result
from grainfit.result.holdout import HoldoutState, holdouts_in_short
from grainfit.run_definition import identity_of
from grainfit.verdict import messages
from grainfit.verdict.options import HOLDOUT
from grainfit.watch.state import read_folder, state_of
from grainfit.work_folder import messages as of_work_folder
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.status import WorkdirStatus, read_status

RUNS = HOLDOUT.sets
#: Friction of the material, and what it gives in the test that is not fitted.
FRICTION = 0.5
FLOW = 5 + 20 * FRICTION**2
MODEL = """\
import numpy as np

def heap(parameters, seed):
    scatter = 0.2 * np.random.default_rng(seed).standard_normal()
    return {"angle": 10 + 40 * parameters["friction"] + scatter}

def drum(parameters, seed):
    scatter = 0.2 * np.random.default_rng([seed, 1]).standard_normal()
    return {"flow": 5 + 20 * parameters["friction"] ** 2 + scatter}
"""
FILE = """\
name = "sand"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
name = "heap"
function = "model.py:heap"
targets.angle = { value = 30.0, uncertainty = 0.4, unit = "deg" }
"""
HELD = """\
[[holdout]]
type = "python"
name = "drum"
function = "model.py:drum"
targets.flow = { value = FLOW, uncertainty = 0.2, unit = "kg/s" }
"""


def files(folder: Path, held: str = HELD.replace("FLOW", str(FLOW)), heap: str = FILE) -> Path:
    """Write model and calibration file, and return the latter."""
    (folder / "model.py").write_text(MODEL)
    path = folder / "sand.toml"
    path.write_text(heap + held)
    return path


def heap(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"angle": 10 + 40 * parameters["friction"] + 0.2 * standard_normal(seed)}


def standard_normal(seed: int) -> float:
    return float(np.random.default_rng(seed).standard_normal())


def problem() -> gf.Problem:
    target = gf.Target("angle", 10 + 40 * FRICTION, uncertainty=0.4, unit="deg")
    return gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [target])


class Drum:
    """A test that is not fitted, which counts its runs."""

    def __init__(self) -> None:
        self.seeds: list[int] = []

    def __call__(self, parameters: dict[str, float], seed: int) -> dict[str, float]:
        return {"flow": 5 + 20 * parameters["friction"] ** 2 + 0.2 * standard_normal(seed + 1)}


def drum_solver(drum: Drum) -> gf.solvers.PythonCallable:
    def flow(parameters: dict[str, float], seed: int) -> dict[str, float]:
        drum.seeds.append(seed)
        return drum(parameters, seed)

    return gf.solvers.PythonCallable(flow, ["flow"], identity="drum 1")


def held(name: str, value: float, uncertainty: float, drum: Drum | None = None) -> gf.Holdout:
    targets = [gf.Target("flow", value, uncertainty=uncertainty, unit="kg/s")]
    return gf.Holdout(name, drum_solver(drum or Drum()), targets)


@pytest.fixture(scope="module")
def predicted(tmp_path_factory: pytest.TempPathFactory) -> tuple[gf.Result, Path]:
    """Result and work folder of a calibration with four hold-outs."""
    folder = tmp_path_factory.mktemp("held") / "work"
    holdouts = [
        held("right", FLOW, 0.2),
        held("wrong", 14.0, 0.2),
        held("blurred", 11.0, 4.0),
        gf.Holdout("unmeasured", drum_solver(Drum())),
    ]
    return gf.calibrate(problem(), heap, workdir=folder, holdouts=holdouts), folder


def test_a_hold_out_is_predicted_refuted_or_tells_nothing(
    predicted: tuple[gf.Result, Path],
) -> None:
    result, folder = predicted
    right, wrong, blurred, unmeasured = result.holdouts
    found = right.responses["flow"]
    assert found.verdict == "predicts"
    assert found.predicted == pytest.approx(FLOW, abs=0.5)
    assert found.interval[0] < FLOW < found.interval[1]
    assert found.prior[0] < 7
    assert found.prior[1] > 18
    assert (len(found.at_answer), len(found.over_posterior), len(found.over_prior)) == (3, 8, 8)
    assert messages.HOLDOUT_PREDICTS.is_in(str(right))
    assert wrong.responses["flow"].verdict == "does not predict"
    assert messages.HOLDOUT_REFUTED.is_in(str(wrong))
    # An inexact measurement is within any interval that is wide enough for it.
    assert blurred.responses["flow"].verdict == "does not tell"
    assert messages.HOLDOUT_TELLS_NOTHING.is_in(str(blurred))
    without = unmeasured.responses["flow"]
    assert (without.verdict, without.probability, unmeasured.registration) == (None, None, None)
    assert messages.HOLDOUT_EXPECTED.is_in(str(unmeasured))
    # The tests of one material take no part in each other: all predict the same.
    assert {one.responses["flow"].predicted for one in result.holdouts} == {found.predicted}
    assert gf.Result.from_json(folder / "result.json") == result
    assert str(right) in str(result)


def test_a_hold_out_changes_nothing_of_the_calibration(predicted: tuple[gf.Result, Path]) -> None:
    result, _ = predicted
    alone = gf.calibrate(problem(), heap)
    assert (alone.identity, alone.parameters, alone.history) == (
        result.identity,
        result.parameters,
        result.history,
    )
    assert alone.intervals == result.intervals
    assert alone.holdouts == ()


def test_report_card_and_figure_show_hold_outs(predicted: tuple[gf.Result, Path]) -> None:
    saved = gf.open(predicted[1])
    shown = section(ReportContext(saved, saved.analyse()))
    assert shown is not None
    for verdict in ("predicts", "does not predict", "does not tell"):
        assert f" {verdict}</span>" in shown.html
    registration = predicted[0].holdouts[0].registration
    assert registration is not None
    assert registration.targets_hash in shown.html
    assert len(shown.figures) == 4
    rows = [trace["y"][0] for trace in shown.figures["holdout-0"].data]
    assert rows == [rows[0], rows[1], rows[0], rows[1], rows[1], "measured"]
    assert len(gf.plots.holdout(saved).data) >= 4 * 5
    assert any(messages.HOLDOUT_REFUTED.is_in(notice) for notice in saved.card().notices)
    assert section(ReportContext(replace(saved, result=None), saved.analyse())) is None


def test_report_and_watch_say_how_hold_outs_ended(predicted: tuple[gf.Result, Path]) -> None:
    result, folder = predicted
    saved = gf.open(folder)
    shown = shown_verdict(ReportContext(saved, saved.analyse()))
    watched = state_of(read_folder(folder), None)["verdict"]

    words = messages.HOLDOUT_WORDS
    found = "; ".join(
        f"{test}.flow {words[verdict]}"
        for test, verdict in (
            ("wrong", "does not predict"),
            ("blurred", "does not tell"),
            ("right", "predicts"),
        )
    )
    # As in the sentences that the terminal prints.
    for one in result.holdouts[:3]:
        assert f", {words[one.responses['flow'].verdict]}:" in str(one)
    assert shown.details[0] == messages.HOLDOUTS_IN_SHORT(found=found)
    assert watched["details"] == list(shown.details)
    # A refuted prediction is not simply good.
    assert watched["grade"] == shown.grade == "warn"
    kept = replace(result, holdouts=result.holdouts[:1])
    fine = shown_verdict(ReportContext(replace(saved, result=kept), saved.analyse()))
    assert fine.grade == "good"


def test_hold_outs_without_a_prediction_are_told_in_short() -> None:
    names: list[HoldoutState] = ["failed", "interrupted", "pending", "not calibrated"]
    said = holdouts_in_short([HoldoutResult(f"drum {name}", name) for name in names])

    assert all(f"drum {name}: {messages.HOLDOUT_STATES[name]}" in said for name in names[:3])
    assert "not calibrated" not in said
    assert holdouts_in_short([HoldoutResult("drum", "not calibrated")]) == ""


def test_targets_are_registered_before_the_first_run(tmp_path: Path) -> None:
    there: list[Any] = []

    def looking(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if not there:
            there.append(json.loads((tmp_path / HOLDOUTS_NAME).read_text())["registrations"])
        return heap(parameters, seed)

    one = held("drum", FLOW, 0.2)
    looked = gf.solvers.PythonCallable(looking, ["angle"], identity="heap 1")
    first = gf.calibrate(problem(), looked, workdir=tmp_path, holdouts=[one])
    [[registered]] = there
    assert registered["targets_hash"] == hash_of_targets(one.targets)
    assert registered["runs"] == 0
    [found] = first.holdouts
    assert found.registration is not None
    assert found.registration.targets_hash == hash_of_targets(one.targets)
    assert len([*found.sentences()]) == 1
    # Another value, after the prediction is known: said for ever.
    drum = Drum()
    other = held("drum", FLOW + 0.3, 0.2, drum)
    late = held("late", FLOW, 0.2, drum)
    again = gf.calibrate(problem(), looked, workdir=tmp_path, holdouts=[other, late])
    changed, registered_late = again.holdouts
    assert messages.HOLDOUT_CHANGED.is_in(str(changed))
    assert changed.registration is not None
    assert changed.registration.targets_hash == hash_of_targets(one.targets)
    assert messages.HOLDOUT_LATE.is_in(str(registered_late))
    assert not drum.seeds, "finished runs are not repeated"


def test_stopped_in_a_hold_out_the_verdict_is_kept_and_no_run_repeated(tmp_path: Path) -> None:
    drum = Drum()

    def stop(progress: gf.Progress) -> None:
        if progress.stage == "hold-out" and progress.done == 4:
            raise KeyboardInterrupt

    one = held("drum", FLOW, 0.2, drum)
    stopped = gf.calibrate(problem(), heap, workdir=tmp_path, holdouts=[one], on_progress=stop)
    assert stopped.status == "calibrated"
    assert stopped.holdouts[0].state == "interrupted"
    assert messages.HOLDOUT_INTERRUPTED.is_in(str(stopped))
    assert gf.Result.from_json(tmp_path / "result.json") == stopped
    before = len(drum.seeds)
    assert 4 <= before < RUNS
    done = gf.calibrate(problem(), heap, workdir=tmp_path, holdouts=[one])
    # One may have been under way: its function cannot be ended.
    assert RUNS <= len(drum.seeds) <= RUNS + 1
    assert len(set(drum.seeds)) == RUNS
    assert done.holdouts[0].state == "simulated"
    assert done.parameters == stopped.parameters


def test_a_calibration_runs_while_hold_outs_are_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_file, "_INTERVAL_SECONDS", 0.0)
    seen: list[tuple[WorkdirStatus, SavedCalibration]] = []

    def look(progress: gf.Progress) -> None:
        if progress.stage == "hold-out":
            seen.append((read_status(tmp_path), gf.open(tmp_path)))

    drums = [held("drum", FLOW, 0.2), held("other", FLOW, 0.3)]
    gf.calibrate(problem(), heap, workdir=tmp_path, holdouts=drums, on_progress=look)

    assert {status.state for status, _ in seen} == {"running"}
    asked = {(now.finished["hold-out"], now.asked["hold-out"]) for now, _ in seen}
    assert {of for _, of in asked} == {2 * RUNS}
    # Both are simulated alike, so that runs of the first are those of the second.
    assert {0, 1, RUNS, 2 * RUNS} <= {done for done, _ in asked}
    assert max(status.running for status, _ in seen) == 1
    status, saved = seen[-1]
    # The answer can be used meanwhile.
    assert (saved.in_holdouts, saved.state, bool(saved.result)) == (True, "calibrated", True)
    assert status.result is not None
    ended = read_status(tmp_path)
    assert (ended.state, ended.running, ended.asked["hold-out"]) == ("calibrated", 0, 2 * RUNS)
    assert not gf.open(tmp_path).in_holdouts


def test_killed_in_a_hold_out_nothing_finished_is_lost(tmp_path: Path) -> None:
    path = files(tmp_path)
    head = "def drum(parameters, seed):\n"
    slow = MODEL.replace(head, f"{head}    note(seed)\n")
    (tmp_path / "model.py").write_text(
        slow
        + textwrap.dedent("""\
        def note(seed):
            import pathlib, time
            here = pathlib.Path(__file__).parent
            with (here / "calls").open("a") as file:
                file.write(f"{seed}\\n")
            if (here / "slow").exists():
                time.sleep(0.1)
        """)
    )
    (tmp_path / "slow").touch()
    calls = tmp_path / "calls"
    command = [sys.executable, "-m", "grainfit", "run", str(path), "--no-report"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 300
    while not calls.exists() or calls.read_text().count("\n") < 5:
        assert time.monotonic() < end
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    kept = gf.Result.from_json(tmp_path / "sand.grainfit/result.json")
    assert (kept.status, kept.holdouts[0].state) == ("calibrated", "pending")
    assert read_status(tmp_path / "sand.grainfit").state == "calibrated"
    assert messages.HOLDOUT_PENDING.is_in(str(kept))
    (tmp_path / "slow").unlink()
    result = gf.load(path).calibrate(tmp_path / "sand.grainfit")
    assert result.holdouts[0].responses["flow"].verdict == "predicts"
    made = calls.read_text().split()
    workers = gf.load(path).workers
    assert len(set(made)) == RUNS
    assert RUNS <= len(made) <= RUNS + workers, "only what was under way is made again"


def test_a_material_that_is_not_calibrated_predicts_nothing(tmp_path: Path) -> None:
    drum = Drum()
    far = replace(problem(), targets=[gf.Target("angle", 80.0, uncertainty=0.4)])
    result = gf.calibrate(far, heap, holdouts=[held("drum", FLOW, 0.2, drum)])
    assert result.status == "unreachable"
    assert messages.HOLDOUT_NOT_CALIBRATED.is_in(str(result))
    assert not drum.seeds


@pytest.mark.parametrize(("reasons", "runs"), [(1, 3), (26, 8)])
def test_a_hold_out_that_always_fails_is_given_up(tmp_path: Path, reasons: int, runs: int) -> None:
    tries: list[int] = []
    said: list[str] = []

    def broken(parameters: dict[str, float], seed: int) -> dict[str, float]:
        tries.append(seed)
        if (tmp_path / "mended").exists():
            return {"flow": parameters["friction"]}
        raise gf.RunFailedError(f"stuck drum {ascii_lowercase[len(tries) % reasons]}")

    def hear(progress: gf.Progress) -> None:
        if progress.stage == "hold-out":
            said.extend(progress.notices)

    stuck = gf.Holdout("stuck", gf.solvers.PythonCallable(broken, ["flow"], identity="drum 2"))
    holdouts = [stuck, gf.Holdout("drum", drum_solver(Drum()))]
    result = gf.calibrate(problem(), heap, workdir=tmp_path, holdouts=holdouts, on_progress=hear)

    assert result.status == "calibrated"
    given_up, other = result.holdouts
    assert (given_up.state, given_up.runs, given_up.failed) == ("failed", runs, runs)
    assert of_calibration.HOLDOUT_GIVEN_UP.is_in(given_up.why, runs=runs, responses="responses")
    assert "stuck drum" in given_up.why
    assert len(tries) == runs
    assert (other.state, other.runs) == ("simulated", RUNS)
    assert str(given_up) in said, "it is said while the other one is simulated"
    counted = of_result.HOLDOUT_RUNS(runs=f"{runs + RUNS} runs", failed=runs)
    assert counted in result.runs_in_words
    assert read_status(tmp_path).failed_in_holdouts == runs
    # As in a search, what failed is made again: its cause may be mended.
    (tmp_path / "mended").touch()
    again = gf.calibrate(problem(), heap, workdir=tmp_path, holdouts=holdouts)
    assert (again.holdouts[0].state, again.holdouts[0].failed) == ("simulated", 0)


def test_a_hold_out_that_fails_at_the_answer_alone_is_not_given_up() -> None:
    asked: list[float] = []

    def narrow(parameters: dict[str, float], seed: int) -> dict[str, float]:
        asked.append(parameters["friction"])
        if parameters["friction"] == asked[0]:
            raise gf.RunFailedError("the drum is stuck")
        return {"flow": parameters["friction"]}

    [found] = gf.calibrate(problem(), heap, holdouts=[gf.Holdout("drum", narrow)]).holdouts

    assert (found.state, found.runs) == ("simulated", RUNS)
    assert found.failed >= HOLDOUT.answer_seeds


def test_a_hold_out_that_the_machine_fails_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    tries: list[int] = []

    def unlicensed(parameters: dict[str, float], seed: int) -> dict[str, float]:
        tries.append(seed)
        if len(tries) > 5:
            raise gf.RunFailedError("no licence", kind="machine")
        return {"flow": parameters["friction"]}

    monkeypatch.setattr(
        import_module("grainfit.calibration.calibrate"),
        "CampaignOptions",
        partial(CampaignOptions, retry_pauses=()),
    )
    [found] = gf.calibrate(problem(), heap, holdouts=[gf.Holdout("drum", unlicensed)]).holdouts

    assert (found.state, found.runs, found.failed) == ("failed", 8, 3)
    assert "no licence" in found.why


def test_the_time_of_hold_outs_counts() -> None:
    def slow(parameters: dict[str, float]) -> dict[str, float]:
        time.sleep(0.02)
        return {"flow": parameters["friction"]}

    alone = gf.calibrate(problem(), heap)
    result = gf.calibrate(problem(), heap, holdouts=[gf.Holdout("drum", slow)])

    assert result.wall_seconds > 0.02 * RUNS
    assert result.utilisation * result.wall_seconds > 0.02 * RUNS
    assert result.runs == alone.runs


def test_a_hold_out_is_not_called_like_a_fitted_test() -> None:
    with pytest.raises(gf.InputError, match=of_calibration.HOLDOUT_OF_SAME_NAME.pattern):
        gf.calibrate(problem(), heap, holdouts=[held("simulate", FLOW, 0.2)])
    other = gf.Holdout("drum", drum_solver(Drum()), [gf.Target("angle", 30.0)])
    with pytest.raises(gf.InputError, match="yields no angle"):
        gf.calibrate(problem(), heap, holdouts=[other])


def test_what_is_fitted_is_no_hold_out_under_another_name(tmp_path: Path) -> None:
    test = FILE[FILE.index("[[test]]") :].replace('"heap"', '"other_heap"')
    path = files(tmp_path, test.replace("[[test]]", "[[holdout]]"))

    problems = " ".join(describe_plan(gf.load(path)).problems)
    with pytest.raises(gf.InputError) as refused:
        gf.load(path).calibrate(tmp_path / "work")

    for text in (problems, str(refused.value)):
        assert of_calibration.HOLDOUT_WAS_FITTED.is_in(text, test="heap")
        assert "other_heap" in text


@pytest.mark.parametrize(
    ("other", "is_new"),
    [
        ("value = 31.0, uncertainty = 0.4", True),
        ("value = 30.0, uncertainty = 0.2", True),
        ("value = 30.0, uncertainty = 0.4, weight = 2", False),
        ("value = 30.0, uncertainty = 0.4, tolerance = 1", False),
    ],
)
def test_another_measurement_of_a_fitted_response_may_be_held_out(
    tmp_path: Path, other: str, is_new: bool
) -> None:
    test = FILE[FILE.index("[[test]]") :].replace('"heap"', '"other_heap"')
    held_out = test.replace("[[test]]", "[[holdout]]")
    path = files(tmp_path, held_out.replace("value = 30.0, uncertainty = 0.4", other))

    problems = " ".join(describe_plan(gf.load(path)).problems)

    assert of_calibration.HOLDOUT_WAS_FITTED.is_in(problems, test="heap") is not is_new


def test_another_measurement_of_a_fitted_curve_may_be_held_out() -> None:
    curve = gf.CurveTarget("stress", [0.01, 0.02, 0.03], [2e3, 5e3, 9e3], "2 %")
    fitted = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [], curves=[curve])
    solver = drum_solver(Drum())
    hashes = {"cell": identity_of(solver.model())}

    other = replace(curve, values=[2.1e3, 5e3, 9e3])
    require_not_fitted(fitted, hashes, [gf.Holdout("other", solver, curves=[other])])

    accepted = replace(curve, tolerance="9 %")
    for same in (curve, gf.CurveTarget.from_json(accepted.to_json())):
        with pytest.raises(gf.InputError):
            require_not_fitted(fitted, hashes, [gf.Holdout("same", solver, curves=[same])])


def test_another_response_of_a_fitted_test_may_be_held_out(tmp_path: Path) -> None:
    model = MODEL.replace('return {"angle": 10', 'return {"height": 7.0, "angle": 10')
    path = files(
        tmp_path,
        FILE[FILE.index("[[test]]") :]
        .replace("[[test]]", "[[holdout]]")
        .replace('"heap"', '"other_heap"')
        .replace("targets.angle = { value = 30.0", "targets.height = { value = 7.0"),
    )
    (tmp_path / "model.py").write_text(model)

    assert not describe_plan(gf.load(path)).problems


def test_the_command_predicts_later_for_folder_card_and_values(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = files(tmp_path, "")
    assert gf.load(path).calibrate("sand.grainfit").status == "calibrated"
    text = FILE + HELD.replace("FLOW", str(FLOW))
    path.write_text(text)

    def invoke(*arguments: str, code: int = 0) -> str:
        done = CliRunner().invoke(app, list(arguments))
        assert done.exit_code == code, done.output
        return done.output

    assert "Hold-out drum" in invoke("check", "sand.toml")
    shown = invoke("predict", "sand.toml")
    assert messages.HOLDOUT_PREDICTS.is_in(shown)
    assert messages.HOLDOUT_LATE.is_in(shown)
    # Now it belongs to the calibration.
    assert messages.HOLDOUT_PREDICTS.is_in(invoke("status", "sand.grainfit"))
    status = json.loads(invoke("status", "sand.grainfit", "--json"))
    assert status["holdouts"][0]["responses"]["flow"]["verdict"] == "predicts"
    with pytest.raises(gf.InputError) as refused:
        gf.predict(path, tests=["heap"])
    assert of_calibration.HOLDOUT_WAS_FITTED.is_in(str(refused.value), test="heap")
    # The same runs, and parameter sets, whoever asks.
    drawn = json.loads(Path("sand.grainfit", HOLDOUTS_NAME).read_text())["draws"]
    assert len(drawn) == 1
    gf.load(path).calibrate("sand.grainfit")
    assert json.loads(Path("sand.grainfit", HOLDOUTS_NAME).read_text())["draws"] == drawn
    invoke("export", "sand.grainfit", "--to", "json", "--output", "card.json")
    card = json.loads(invoke("predict", "sand.toml", "--answer-of", "card.json", "--json"))
    [found] = card["holdouts"]
    assert found["basis"] == "intervals"
    assert found["responses"]["flow"]["verdict"] == "predicts"
    # Also with a byte order mark, as some editors write it.
    values = f"[parameters]\nfriction = {FRICTION}\n"
    Path("values.toml").write_text(values, encoding="utf-8-sig")
    path.write_text(FILE + HELD.partition("targets")[0])
    exact = gf.predict(path, answer_of="values.toml")["drum"]
    assert exact.basis == "values"
    assert messages.HOLDOUT_OF_VALUES.is_in(str(exact))
    assert exact.responses["flow"].predicted == pytest.approx(FLOW, abs=0.3)
    # Less wide: the parameter counts as exact.
    width = np.diff(exact.responses["flow"].interval)[0]
    assert width < np.diff(found["responses"]["flow"]["interval"])[0]


def test_faults_of_a_hold_out_name_its_line(tmp_path: Path) -> None:
    def fault(heap_file: str, held_out: str) -> str:
        with pytest.raises(gf.InputError) as refused:
            gf.load(files(tmp_path, held_out, heap_file))
        return str(refused.value)

    same = HELD.replace('"drum"', '"heap"').replace("FLOW", "10")
    assert "line 11, holdout 1, name" in fault(FILE, same)
    curve = HELD.partition("targets")[0] + 'targets.flow = { curve = "flow.csv" }\n'
    assert of_calibration_file.NO_UNCERTAINTY_OF_CURVE.is_in(fault(FILE, curve))
    wrong = HELD.replace("model.py:drum", "7").replace("FLOW", "10")
    assert "holdout 1, function" in fault(FILE, wrong)


def test_intervals_of_predictions_hold_what_they_state() -> None:
    """Of some materials nearly all are predicted; `benchmarks/holdouts.py` has the share."""
    friction = gf.Problem(
        [gf.Parameter("friction", 0.0, 1.0)], [gf.Target("flow", 1.0, uncertainty=1.0)]
    )
    # 9 or fewer of 12 at 95 % have a probability of 2 %.
    assert sum(_is_inside(friction, seed) for seed in range(12)) >= 10


def _is_inside(wanted: gf.Problem, seed: int) -> bool:
    """Predict a material whose parameter is known to ±0.1."""
    random = np.random.default_rng(seed)
    middle = random.uniform(0.3, 0.7)
    truth, sample = (
        middle + 0.1 * random.standard_normal(),
        middle + 0.1 * random.standard_normal(400),
    )

    def mean(place: float) -> float:
        return 20 + 10 * place**2

    def runs(places: Any) -> list[Evaluation]:
        return [
            Evaluation(
                Proposal({"friction": float(place)}, number + 1, "design"),
                {"flow": Response(mean(place) + 0.5 * random.standard_normal())},
            )
            for number, place in enumerate(places)
        ]

    parts = HoldoutEvaluations(runs([middle] * 3), runs(sample[:8]), runs((np.arange(8) + 0.5) / 8))
    measured = gf.Target("flow", mean(truth) + 0.3 * random.standard_normal(), uncertainty=0.3)
    found = predict_response(wanted, "flow", parts, np.array(sample)[:, None], measured)
    return found.verdict != "does not predict"


def test_what_ifs_and_other_files_leave_the_result_of_a_calibration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path, work = files(tmp_path), tmp_path / "sand.grainfit"
    answer = gf.load(path).calibrate(work).parameters["friction"]
    kept = (work / "result.json").read_bytes()

    other = gf.predict(path, settings=["friction=0.3"])
    assert other["drum"].responses["flow"].verdict == "does not predict"
    [said] = other.remarks
    assert of_work_folder.ANOTHER_MATERIAL.is_in(said, name="friction", value="0.3")
    assert (work / "result.json").read_bytes() == kept

    with pytest.raises(gf.InputError) as refused:
        gf.predict(path, settings=["friction=5"])
    assert of_work_folder.FAR_FROM_RUNS.is_in(str(refused.value), value="5", low="0.1", high="0.9")

    elsewhere = tmp_path / "drum.toml"
    text = path.read_text().replace(f"value = {FLOW}", "value = 17.0")
    free = "friction = { min = 0.1, max = 0.9 }"
    elsewhere.write_text(text.replace(free, "friction = 0.2\ncolour = { min = 0, max = 1 }"))
    before = {path: path.read_bytes() for path in work.rglob("*") if path.is_file()}
    found = gf.predict(elsewhere, tests=["drum"], answer_of=gf.open(work), settings=["colour=0.5"])
    assert {path: path.read_bytes() for path in work.rglob("*") if path.is_file()} == before
    assert (tmp_path / "drum.simulated" / "holdouts.json").is_file()
    assert found["drum"].responses["flow"].measured == 17.0
    fixed, foreign = found.remarks
    shown = f"{answer:.4g}"
    assert of_work_folder.IN_PLACE_OF_FIXED.is_in(fixed, name="friction", value=shown, fixed="0.2")
    assert of_work_folder.OF_ANOTHER_FILE.is_in(foreign, file="drum.toml")

    # In the folder of the calibration, if that is wanted, it is beside the test of that name.
    gf.predict(elsewhere, tests=["drum"], answer_of=work, settings=["colour=0.5"], workdir=work)
    assert (work / "result.json").read_bytes() == kept

    # Neither has changed what this file registered, and what is put back is as it was.
    changed = path.read_text().replace(f"value = {FLOW}", f"value = {FLOW + 0.1}")
    original = path.read_text()
    path.write_text(changed)
    assert gf.predict(path)["drum"].registration.changed
    path.write_text(original)
    assert not gf.predict(path)["drum"].registration.changed


@pytest.mark.parametrize(
    "wrong",
    [
        {"name": 3},
        {"solver": "model.py:drum"},
        {"targets": None},
        {"curves": [3]},
        {"repeats": "2"},
        {"repeats": 0},
        {"timeout": "10"},
        {"timeout": -1},
    ],
)
def test_a_hold_out_that_cannot_be_simulated_is_refused_before_the_search(
    wrong: dict[str, Any],
) -> None:
    with pytest.raises(gf.InputError, match="holdout"):
        gf.Holdout(**{"name": "drum", "solver": Drum(), **wrong})


def test_the_time_out_of_a_hold_out_may_have_a_unit() -> None:
    assert gf.Holdout("drum", Drum(), timeout="2 min").timeout == 120
    assert gf.Holdout("drum", Drum(), timeout=math.inf).timeout == math.inf


def test_a_prediction_names_why_some_of_its_runs_failed() -> None:
    tries: list[int] = []

    def jams(parameters: dict[str, float], seed: int) -> dict[str, float]:
        tries.append(seed)
        if len(tries) % 5 == 4:
            raise gf.RunFailedError("the slot is choked")
        return {"flow": parameters["friction"]}

    drum = gf.Holdout("drum", gf.solvers.PythonCallable(jams, ["flow"], identity="jams"))
    (found,) = gf.calibrate(problem(), heap, holdouts=[drum]).holdouts

    assert found.state == "simulated"
    said = {"failed": found.failed, "runs": f"{RUNS} runs", "why": found.why}
    assert found.failed == len(tries) // 5 + (len(tries) % 5 == 4)
    assert messages.HOLDOUT_SOME_FAILED(test="drum", **said) in str(found)
    assert "the slot is choked" in found.why
