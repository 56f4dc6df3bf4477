"""A whole calibration through the Python interface."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf


def drum(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """Dynamic angles of a drum at two speeds, with the scatter of real runs."""
    random = np.random.default_rng(seed)
    friction, cohesion = parameters["rolling_friction"], parameters["cohesion"] / 7e4
    return {
        "angle_10rpm": 25 + 25 * friction + 4 * cohesion + 0.5 * random.standard_normal(),
        "angle_30rpm": 35 + 14 * friction + 9 * cohesion + 0.5 * random.standard_normal(),
    }


def problem(first: float = 36.0) -> gf.Problem:
    return gf.Problem(
        parameters=[
            gf.Parameter("rolling_friction", 0.05, 0.7),
            gf.Parameter("cohesion", 0, 7e4),
        ],
        targets=[
            gf.Target("angle_10rpm", first, uncertainty=0.5),
            gf.Target("angle_30rpm", 44.0, uncertainty=0.5),
        ],
    )


def test_the_python_interface_calibrates_and_writes_its_result(tmp_path: Path) -> None:
    result = gf.calibrate(
        problem(), simulate=drum, strategy="staged", max_runs=60, workers=2, seed=1
    )
    assert result.status == "calibrated"
    assert result.runs.design == 26
    assert result.runs.total <= 60
    assert result.runs.total == (
        result.runs.design + result.runs.optimisation + result.runs.verification
    )
    for name, target in (("angle_10rpm", 36.0), ("angle_30rpm", 44.0)):
        response = result.responses[name]
        assert response.verified_mean == pytest.approx(target, abs=0.5)
        assert response.deviation_percent == pytest.approx(
            100 * (response.verified_mean - target) / target
        )
    result.to_json(tmp_path / "result.json")
    data = json.loads((tmp_path / "result.json").read_text())
    assert data["status"] == "calibrated"
    assert data["parameters"] == dict(result.parameters)
    assert set(data["responses"]["angle_10rpm"]) >= {
        "target",
        "predicted",
        "std_error",
        "verified_mean",
        "verified_std_error",
        "deviation_percent",
    }
    assert set(data["runs"]) == {
        "design",
        "optimisation",
        "verification",
        "failed",
        "reused",
        "total",
    }
    assert data["rayleigh_time_step"] is None
    assert data["wall_seconds"] > 0


def test_the_same_seed_and_one_worker_give_the_same_calibration_bit_for_bit() -> None:
    first, second = (gf.calibrate(problem(), drum, seed=3) for _ in range(2))
    assert first.parameters == second.parameters
    assert first.history == second.history
    assert first.responses == second.responses


def test_the_number_of_workers_changes_nothing_but_the_time() -> None:
    one, four = (gf.calibrate(problem(), drum, seed=3, workers=workers) for workers in (1, 4))
    assert one.parameters == four.parameters


def test_started_again_nothing_is_repeated(tmp_path: Path) -> None:
    calls = []

    def counted(parameters: dict[str, float], seed: int) -> dict[str, float]:
        calls.append(seed)
        return drum(parameters, seed)

    first = gf.calibrate(problem(), counted, workdir=tmp_path)
    made = len(calls)
    second = gf.calibrate(problem(), counted, workdir=tmp_path)
    assert len(calls) == made == first.runs.total
    assert second.runs.reused == second.runs.total == first.runs.total
    assert second.parameters == first.parameters


def test_another_target_reuses_the_design(tmp_path: Path) -> None:
    gf.calibrate(problem(), drum, workdir=tmp_path)
    other = gf.calibrate(problem(first=35.0), drum, workdir=tmp_path)
    assert other.runs.reused >= 26


def test_a_target_out_of_reach_is_said_and_verified() -> None:
    result = gf.calibrate(problem(first=60.0), drum)
    assert result.status == "unreachable"
    assert result.out_of_reach[0].target == "angle_10rpm"
    assert any("angle_10rpm = 60 is out of reach" in notice for notice in result.notices)
    assert result.responses["angle_10rpm"].verified_mean is not None


def test_an_answer_that_verification_refutes_is_not_called_calibrated() -> None:
    # The responses jump for verification seeds, as if the design had misled us.
    def biased(parameters: dict[str, float], seed: int) -> dict[str, float]:
        responses = drum(parameters, seed)
        if parameters["rolling_friction"] > 0.36:
            responses["angle_10rpm"] += 6.0
            responses["angle_30rpm"] -= 6.0
        else:
            responses["angle_10rpm"] -= 6.0
            responses["angle_30rpm"] += 6.0
        return responses

    assert gf.calibrate(problem(), biased).status in ("out_of_tolerance", "unreachable")


def test_runs_that_all_fail_stop_the_calibration_with_the_reason() -> None:
    def broken(parameters: dict[str, float], seed: int) -> dict[str, float]:
        raise ValueError("no licence")

    with pytest.raises(gf.RunFailedError, match=r"first 3 runs all failed.*no licence"):
        gf.calibrate(problem(), broken)


def test_single_failures_are_counted_and_left_out() -> None:
    def sometimes(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if parameters["cohesion"] > 6e4:
            raise RuntimeError("exploded")
        return drum(parameters, seed)

    result = gf.calibrate(problem(), sometimes)
    assert result.runs.failed > 0
    assert result.status == "calibrated"


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"strategy": "guess"}, "strategy"),
        ({"max_runs": 0}, "max_runs"),
        ({"max_runs": 7}, "max_runs"),
        ({"workers": 0}, "workers"),
        ({"seed": -1}, "seed"),
        ({"verification_runs": 1}, "verification_runs"),
        ({"design_runs": 2}, "design_runs"),
    ],
)
def test_arguments_that_cannot_be_used_are_named(options: dict[str, object], word: str) -> None:
    with pytest.raises(gf.InputError, match=word):
        gf.calibrate(problem(), drum, **options)  # type: ignore[arg-type]


def test_something_that_cannot_simulate_is_refused() -> None:
    with pytest.raises(gf.InputError, match="simulate"):
        gf.calibrate(problem(), 42)  # type: ignore[arg-type]


def test_ctrl_c_ends_with_an_interrupted_result_and_a_restart_goes_on(tmp_path: Path) -> None:
    made = 0

    def interrupting(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        if made == 10:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.2)
        return drum(parameters, seed)

    result = gf.calibrate(problem(), interrupting, workdir=tmp_path)
    assert result.status == "interrupted"
    assert json.loads((tmp_path / "result.json").read_text())["status"] == "interrupted"
    again = gf.calibrate(problem(), interrupting, workdir=tmp_path)
    assert again.status == "calibrated"
    assert made <= again.runs.total + 1


SCRIPT = textwrap.dedent(
    """
    import sys, time
    import numpy as np
    import grainfit as gf

    def drum(parameters, seed):
        time.sleep(0.02)
        with open(sys.argv[2], "a") as log:
            log.write("x")
        random = np.random.default_rng(seed)
        friction = parameters["friction"]
        return {"angle": 25 + 25 * friction + 0.5 * random.standard_normal()}

    problem = gf.Problem(
        [gf.Parameter("friction", 0.05, 0.7)], [gf.Target("angle", 36.0, uncertainty=0.5)]
    )
    result = gf.calibrate(problem, drum, workdir=sys.argv[1], workers=2, design_runs=20)
    print(result.status, result.runs.total, result.parameters["friction"])
    """
)


def run_script(script: Path, folder: Path, kill_after: int | None = None) -> str:
    process = subprocess.Popen(
        [sys.executable, str(script), str(folder), str(folder.with_suffix(".log"))],
        stdout=subprocess.PIPE,
        text=True,
    )
    log = folder.with_suffix(".log")
    if kill_after is not None:
        while not log.exists() or len(log.read_text()) < kill_after:
            assert process.poll() is None, "ended before it could be killed"
            time.sleep(0.005)
        process.kill()
    return process.communicate()[0]


def test_kill_dash_nine_costs_at_most_the_runs_under_way(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    undisturbed = run_script(script, tmp_path / "calm")
    for moment in (4, 11):
        run_script(script, tmp_path / "disturbed", kill_after=moment)
    assert run_script(script, tmp_path / "disturbed") == undisturbed
    calm = len((tmp_path / "calm.log").read_text())
    disturbed = len((tmp_path / "disturbed.log").read_text())
    assert disturbed <= calm + 2 * 2, "each of the two kills may cost the two runs under way"
