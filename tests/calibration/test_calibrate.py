"""A whole calibration through the Python interface."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration import messages as of_calibration
from grainfit.calibration.messages import ALL_FAILED
from grainfit.metamodels import messages as of_metamodels
from grainfit.result import RunSummary
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies import messages
from grainfit.testing.materials import GLASS_BEADS
from grainfit.verdict import messages as of_verdict
from grainfit.work_folder.status import read_status

#: Seeds of the runs that were made: a function that held them itself would be another model.
CALLS: list[int] = []


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


@cache
def undisturbed() -> gf.Result:
    """A calibration that several tests compare theirs with."""
    return gf.calibrate(problem(), drum, seed=3)


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
            100 * (response.predicted - target) / target
        )
    result.to_json(tmp_path / "result.json")
    data = json.loads((tmp_path / "result.json").read_text())
    assert data["status"] == "calibrated"
    assert data["parameters"] == dict(result.parameters)
    assert set(data["responses"]["angle_10rpm"]) >= {
        "target",
        "predicted",
        "standard_error",
        "verified_mean",
        "verified_standard_error",
        "deviation_percent",
    }
    assert set(data["runs"]) == {
        "design",
        "optimisation",
        "verification",
        "failed",
        "reused",
        "total",
        "warm_start_runs",
        "sizes",
    }
    assert data["rayleigh_time_step"] is None
    assert data["wall_seconds"] > 0


def test_the_same_seed_and_one_worker_give_the_same_calibration_bit_for_bit() -> None:
    first, second = undisturbed(), gf.calibrate(problem(), drum, seed=3)
    assert first.parameters == second.parameters
    assert first.history == second.history
    assert first.responses == second.responses


def test_the_number_of_workers_changes_nothing_of_a_staged_calibration_but_the_time() -> None:
    one, four = (
        gf.calibrate(problem(), drum, strategy="staged", seed=3, workers=workers)
        for workers in (1, 4)
    )
    assert one.parameters == four.parameters


@pytest.mark.parametrize("workers", [1, 3])
def test_started_again_nothing_is_repeated(tmp_path: Path, workers: int) -> None:
    CALLS.clear()

    # Runs that were under way when it was decided come back after the answer: they must not
    # change it when it is all done again.
    def slow(parameters: dict[str, float], seed: int) -> dict[str, float]:
        CALLS.append(seed)
        time.sleep(0.01 + 0.02 * (seed % 3))
        return drum(parameters, seed)

    first, second = (
        gf.calibrate(problem(), slow, workdir=tmp_path, workers=workers, seed=2) for _ in range(2)
    )
    assert len(CALLS) == first.runs.total
    assert second.runs.reused == second.runs.total == first.runs.total
    assert second.parameters == first.parameters
    assert 0 < first.utilisation <= 1
    assert second.utilisation == 0


@pytest.mark.parametrize("interrupted_at", [3, 7, 9, 11])
def test_interrupted_and_started_again_it_asks_what_it_would_have_asked(
    tmp_path: Path, interrupted_at: int
) -> None:
    calls = 0

    def with_ctrl_c(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal calls
        calls += 1
        if calls == interrupted_at:
            raise KeyboardInterrupt
        return drum(parameters, seed)

    stopped = gf.calibrate(problem(), with_ctrl_c, workdir=tmp_path, seed=3)
    assert stopped.status == "interrupted"
    result = gf.calibrate(problem(), with_ctrl_c, workdir=tmp_path, seed=3)
    asked = [(run.stage, run.parameters, run.seed) for run in result.history]
    assert asked == [(run.stage, run.parameters, run.seed) for run in undisturbed().history]
    assert result.runs.reused == interrupted_at - 1


def test_interrupted_while_it_recalls_what_it_knows_it_forgets_nothing(tmp_path: Path) -> None:
    def stop_at(done: int) -> Callable[[gf.Progress], None]:
        def on_progress(progress: gf.Progress) -> None:
            if progress.done == done:
                raise KeyboardInterrupt

        return on_progress

    for done in (9, 0):
        stopped = gf.calibrate(problem(), drum, workdir=tmp_path, seed=3, on_progress=stop_at(done))
        assert stopped.status == "interrupted"
    result = gf.calibrate(problem(), drum, workdir=tmp_path, seed=3)
    assert result.runs.reused >= 9
    assert result.parameters == undisturbed().parameters


def test_a_finished_result_survives_ctrl_c_while_its_runs_are_recalled(tmp_path: Path) -> None:
    def stop(progress: gf.Progress) -> None:
        if progress.done == 5:
            raise KeyboardInterrupt

    first = gf.calibrate(problem(), drum, workdir=tmp_path, seed=3)
    kept = (tmp_path / "result.json").read_bytes()
    stopped = gf.calibrate(problem(), drum, workdir=tmp_path, seed=3, on_progress=stop)

    assert (tmp_path / "result.json").read_bytes() == kept
    assert read_status(tmp_path).state == first.status == "calibrated"
    assert stopped == replace(first, status="interrupted")


def test_a_result_has_every_run_that_was_under_way_at_its_end(tmp_path: Path) -> None:
    def scattering(parameters: dict[str, float], seed: int) -> dict[str, float]:
        time.sleep(0.02 * (seed % 5))
        return {"angle": 10 + 40 * parameters["x"] + 0.5 * (seed % 7 - 3)}

    wanted = gf.Problem([gf.Parameter("x", 0.1, 0.9)], [gf.Target("angle", 60.0, tolerance=1)])
    first = gf.calibrate(wanted, scattering, workdir=tmp_path, workers=4)
    shown = read_status(tmp_path)
    again = gf.calibrate(wanted, scattering, workdir=tmp_path, workers=4)

    assert first.status == "unreachable"
    assert first.runs.total == sum(shown.finished.values()) == sum(shown.asked.values())
    assert again.runs == replace(first.runs, reused=first.runs.total)
    assert again.parameters == first.parameters


def test_larger_and_larger_budgets_continue_one_history(tmp_path: Path) -> None:
    def wavy(parameters: dict[str, float], seed: int) -> dict[str, float]:
        return {
            "angle": 10 * parameters["x"] + 3 * np.sin(25 * parameters["x"]) + 1e-6 * (seed % 7)
        }

    wanted = gf.Problem([gf.Parameter("x", 0, 1)], [gf.Target("angle", 6.0, tolerance=0.05)])
    known: tuple[RunSummary, ...] = ()
    for max_runs in (9, 14, 40):
        result = gf.calibrate(wanted, wavy, workdir=tmp_path, max_runs=max_runs)
        assert result.runs.total <= max_runs
        assert result.runs.reused == len(known)
        assert result.history[: len(known)] == known
        known = result.history
    assert result.status == "calibrated"
    again = gf.calibrate(wanted, wavy, workdir=tmp_path, max_runs=40)
    assert again.history == result.history


def test_another_model_in_the_same_folder_does_not_take_up_the_old_history(tmp_path: Path) -> None:
    def other(parameters: dict[str, float], seed: int) -> dict[str, float]:
        responses = drum(parameters, seed)
        return {name: value - 3.0 for name, value in responses.items()}

    first = gf.calibrate(problem(), drum, workdir=tmp_path)
    second = gf.calibrate(problem(), other, workdir=tmp_path)
    assert second.runs.reused == 0
    assert second.parameters["rolling_friction"] > first.parameters["rolling_friction"]


def test_another_target_needs_few_runs_where_others_were_made(tmp_path: Path) -> None:
    first = gf.calibrate(problem(), drum, workdir=tmp_path)
    other = gf.calibrate(problem(first=35.0), drum, workdir=tmp_path)
    assert other.status == "calibrated"
    assert other.runs.warm_start_runs == first.runs.total
    assert other.runs.design == 0
    assert other.runs.total - other.runs.verification <= first.runs.total / 3


def test_a_target_out_of_reach_is_said_and_costs_no_verification() -> None:
    result = gf.calibrate(problem(first=60.0), drum)
    assert result.status == "unreachable"
    assert result.out_of_reach[0].target == "angle_10rpm"
    assert any(
        of_verdict.OUT_OF_REACH.is_in(notice, target="angle_10rpm", value=60)
        for notice in result.notices
    )
    assert result.responses["angle_10rpm"].verdict == "missed"
    assert result.runs.verification == 0


def test_what_is_out_of_reach_is_said_once_by_all_runs(tmp_path: Path) -> None:
    # The run that is under way when the search stops counts in the result.
    problem = just_out_of_reach(40.0, 0.5)
    said: list[str] = []
    result = gf.calibrate(
        problem,
        scattered,
        seed=1,
        workers=2,
        workdir=tmp_path,
        on_progress=lambda progress: said.extend(progress.notices),
    )
    assert result.status == "unreachable"
    [notice] = filter(of_verdict.OUT_OF_REACH.is_in, result.notices)
    assert notice == str(result.out_of_reach[0])
    assert not any(map(of_verdict.OUT_OF_REACH.is_in, said))
    again = gf.Result.from_json(tmp_path / "result.json")
    assert again.notices == result.notices
    assert notice not in again.other_notices


def test_an_answer_that_verification_refutes_is_not_called_calibrated() -> None:
    # The responses jump over the targets: no parameter set meets them.
    def biased(parameters: dict[str, float], seed: int) -> dict[str, float]:
        responses = drum(parameters, seed)
        if parameters["rolling_friction"] > 0.36:
            responses["angle_10rpm"] += 6.0
            responses["angle_30rpm"] -= 6.0
        else:
            responses["angle_10rpm"] -= 6.0
            responses["angle_30rpm"] += 6.0
        return responses

    result = gf.calibrate(problem(), biased)
    assert result.status in ("undecided", "out_of_tolerance", "unreachable")
    assert result.probability_all_met < 0.95


def scattered(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """At most 30 is expected."""
    scatter = 0.8 * np.random.default_rng(seed).standard_normal()
    return {"angle": 20 + 10 * parameters["friction"] + scatter}


def just_out_of_reach(value: float, tolerance: float) -> gf.Problem:
    return gf.Problem(
        [gf.Parameter("friction", 0, 1)], [gf.Target("angle", value, tolerance=tolerance)]
    )


@pytest.mark.parametrize("strategy", ["sequential", "staged"])
def test_what_is_reported_was_simulated_with_fresh_seeds_to_the_last_digit(strategy: str) -> None:
    result = gf.calibrate(problem(), drum, strategy=strategy, seed=3)
    assert result.status == "calibrated"
    there = [
        run
        for run in result.history
        if run.stage == "verification" and run.parameters == result.parameters
    ]
    assert len({run.seed for run in there}) >= 3
    assert all(float(f"{value:.4g}") == value for value in result.parameters.values())
    angle = result.responses["angle_10rpm"]
    assert set(angle.verified_seeds) <= {run.seed for run in there}
    assert angle.jams_not_excluded == pytest.approx(1 - 0.05 ** (1 / len(result.history)))


def test_a_target_just_out_of_reach_is_never_called_calibrated() -> None:
    for seed in (7, 8, 9):
        result = gf.calibrate(just_out_of_reach(30.8, 0.5), scattered, max_runs=40, seed=seed)
        assert result.status != "calibrated"
        assert result.responses["angle"].verdict in ("in doubt", "missed")


def test_an_interrupted_verification_is_continued_without_another_history(tmp_path: Path) -> None:
    def calibrate(stop_at: int | None = None, workdir: Path | None = None) -> gf.Result:
        def on_progress(progress: gf.Progress) -> None:
            if progress.done == stop_at:
                raise KeyboardInterrupt

        return gf.calibrate(one_angle, calm, seed=8, workdir=workdir, on_progress=on_progress)

    # One angle of one parameter, so that a search takes little time.
    one_angle = gf.Problem(problem().parameters[:1], problem().targets[:1])

    def calm(parameters: dict[str, float], seed: int) -> dict[str, float]:
        return calm_drum({**parameters, "cohesion": 2e4}, seed)

    result = calibrate()
    assert result.status == "calibrated"
    stages = [run.stage for run in result.history]
    first = stages.index("verification")
    for stop_at in (first - 1, first + 1):
        assert calibrate(stop_at, tmp_path).status == "interrupted"
    again = calibrate(workdir=tmp_path)
    assert again.history == result.history
    assert (again.status, again.parameters) == (result.status, result.parameters)


def test_a_smaller_budget_in_between_does_not_end_the_search(tmp_path: Path) -> None:
    # The small budget ends undecided; without one, the search goes on from there.
    def calibrate(**options: object) -> gf.Result:
        return gf.calibrate(problem(), noisy_drum, seed=3, workdir=tmp_path, **options)

    small = calibrate(max_runs=9)
    assert small.runs.total <= 9
    assert small.status != "calibrated"
    whole = calibrate()
    assert whole.status == "calibrated"
    assert whole.probability_all_met >= 0.95
    assert whole.history[:6] == small.history[:6]


def noisy_drum(parameters: dict[str, float], seed: int, scatter: float = 0.5) -> dict[str, float]:
    random = np.random.default_rng(seed)
    responses = drum(parameters, seed)
    return {name: value + scatter * random.standard_normal() for name, value in responses.items()}


def calm_drum(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return noisy_drum(parameters, seed, scatter=0.2)


def test_first_runs_that_all_fail_do_not_end_a_calibration_that_knows_others(
    tmp_path: Path,
) -> None:
    limit, calls = 0, 0

    def sometimes(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal calls
        calls += 1
        if calls <= limit:
            raise RuntimeError("no heap")
        return drum(parameters, seed)

    solver = PythonCallable(sometimes, identity="drum")
    gf.calibrate(problem(), solver, workdir=tmp_path)
    limit, calls = 4, 0
    result = gf.calibrate(problem(first=35.0), solver, workdir=tmp_path)
    assert result.runs.failed == limit
    assert result.status == "calibrated"


def drum_that_explodes(parameters: dict[str, float], seed: int) -> dict[str, float]:
    if parameters["cohesion"] > 6e4:
        raise RuntimeError("exploded")
    return drum(parameters, seed)


class Fragile(PythonCallable):
    """A solver with a mistake in its own code."""

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: gf.Workspace
    ) -> dict[str, gf.Response]:
        if parameters["cohesion"] > 6e4:
            raise ZeroDivisionError("division by zero")
        return super().run(parameters, seed, workspace)


@pytest.mark.parametrize("simulate", [drum_that_explodes, Fragile(drum)])
def test_single_failures_are_counted_and_cost_these_runs_alone(simulate: Any) -> None:
    result = gf.calibrate(problem(), simulate)
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
        ({"strategy": gf.Sequential(design_runs=2)}, "design_runs"),
        ({"strategy": gf.Sequential}, "strategy"),
        ({"keep": "some"}, "keep"),
        ({"simulate": 42}, "simulate"),
        ({"problem": "sand.toml"}, r"problem: .*load"),
        ({"simulate": {3: PythonCallable(drum)}}, "simulate"),
        ({"seed": 10**30}, "0 to 2147483647"),
        ({"workers": None}, "workers"),
        ({"name": None}, "name"),
        ({"workdir": 3}, "workdir"),
        ({"runs_from": 3}, "runs_from"),
        ({"runs_from": [3]}, "runs_from"),
        ({"relatives": [1]}, "relatives"),
        ({"twins": 3}, "twins"),
        ({"executor": 3}, "executor"),
        ({"provenance": 3}, "provenance"),
        ({"on_progress": 3}, "on_progress"),
        ({"near_runs": "yes"}, "near_runs"),
        ({"retry_failed": "yes"}, "retry_failed"),
        ({"progress": 1}, "progress"),
        ({"timeouts": 5}, "timeouts"),
        ({"timeouts": "10 s"}, "timeouts"),
        ({"timeouts": {"simulate": None}}, r"timeouts\.simulate"),
        ({"timeouts": {"simulate": "10"}}, r"timeouts\.simulate"),
        ({"holdouts": gf.Holdout("other", drum)}, "holdouts"),
        ({"holdouts": [3]}, "holdouts"),
        # An iterator would be empty when the hold-outs are predicted.
        ({"holdouts": iter([gf.Holdout("other", drum)])}, "holdouts"),
    ],
)
def test_arguments_that_cannot_be_used_are_named(options: dict[str, object], word: str) -> None:
    with pytest.raises(gf.InputError, match=word):
        gf.calibrate(**({"problem": problem(), "simulate": drum} | options))  # type: ignore[arg-type]


def test_numbers_of_numpy_are_numbers() -> None:
    counts = {"seed": np.int64(3), "workers": np.int64(1), "max_runs": np.int64(40)}
    result = gf.calibrate(problem(), drum, **counts)  # type: ignore[arg-type]
    assert result.runs.total <= 40


FREE = "particle_particle.rolling_friction"
STIFF = {**GLASS_BEADS, "particle.youngs_modulus": 1e8}
FIXED = {name: value for name, value in STIFF.items() if name != FREE}


def in_units(target: gf.Target | gf.CurveTarget, **held: Any) -> None:
    """Calibrate a heap, or a compression to a curve, far enough to be refused."""
    is_curve = isinstance(target, gf.CurveTarget)
    test = gf.tests.Compression if is_curve else gf.tests.Heap
    given = {"curves": [target]} if is_curve else {"targets": [target]}
    problem = gf.Problem(**{"parameters": [gf.Parameter(FREE, 0.1, 0.4)], "targets": [], **given})
    # A budget without room for any run ends it after all else was accepted.
    solver = gf.solvers.Lammps(test(diameter="10 mm"), FIXED)
    gf.calibrate(problem, solver, max_runs=1, **held)


@pytest.mark.parametrize(
    ("target", "place", "unit"),
    [
        (gf.Target("angle_of_repose", "22 mm"), "angle_of_repose: is in m", '"22 deg"'),
        (gf.Target("angle_of_repose", 22.0, uncertainty="1 mm"), "is in m", '"22 deg"'),
        (gf.Target("bulk_density", 1.5, unit="g/cm^3"), "bulk_density", "kg/m^3"),
        (
            gf.CurveTarget("stress", [0.01, 0.02], [1e3, 2e3], "2 %", unit="kPa"),
            "stress: is in kPa",
            "in Pa",
        ),
        (
            gf.CurveTarget("stress", [1.0, 2.0], [1e3, 2e3], "2 %", coordinate_unit="%"),
            "stress.coordinate_unit: is in %",
            "no unit",
        ),
    ],
)
def test_a_target_in_another_unit_than_its_response_is_refused(
    target: gf.Target | gf.CurveTarget, place: str, unit: str
) -> None:
    with pytest.raises(gf.InputError) as refused:
        in_units(target)
    assert place in str(refused.value)
    assert unit in str(refused.value)


@pytest.mark.parametrize(
    "target",
    [
        gf.Target("angle_of_repose", 95.0, uncertainty=1.0),
        gf.Target("angle_of_repose", "-3 deg", uncertainty=1.0),
        gf.Target("bulk_density", -1500.0),
    ],
    ids=["steep", "negative", "density"],
)
def test_a_target_that_is_physically_impossible_is_refused_as_in_a_file(target: gf.Target) -> None:
    with pytest.raises(gf.InputError, match=f"{target.name}: is {target.value:g}"):
        in_units(target)
    heap = gf.solvers.Lammps(gf.tests.Heap(diameter="10 mm"), FIXED)
    with pytest.raises(gf.InputError, match=f"other, {target.name}: is {target.value:g}"):
        in_units(
            gf.Target("angle_of_repose", "22 deg"), holdouts=[gf.Holdout("other", heap, [target])]
        )


def test_hold_outs_have_the_units_of_their_responses() -> None:
    packing = gf.solvers.Lammps(gf.tests.Packing(diameter="10 mm"), FIXED)
    held = gf.Holdout("packing", packing, [gf.Target("bulk_density", "15 mm")])
    with pytest.raises(gf.InputError, match="packing, bulk_density: is in m"):
        in_units(gf.Target("angle_of_repose", "22 deg"), holdouts=[held])


@pytest.mark.parametrize("target", [{"value": "0.4 rad"}, {"unit": "°"}, {"unit": "Neigung"}])
def test_units_that_mean_the_same_and_words_for_people_are_accepted(
    target: dict[str, Any],
) -> None:
    with pytest.raises(gf.InputError, match="max_runs"):
        in_units(gf.Target(**{"name": "angle_of_repose", "value": 22.0, **target}))


def test_an_interrupted_calibration_says_nothing_of_what_would_decide_it() -> None:
    made = 0

    def stopped(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        if made == 8:
            raise KeyboardInterrupt
        return {name: value + seed % 9 for name, value in drum(parameters, seed).items()}

    result = gf.calibrate(problem(), stopped)
    assert result.parameters
    assert not any(reason.gives_probability for reason in result.reasons)


def test_a_trend_of_few_runs_is_not_called_scatter() -> None:
    made = 0

    def stopped(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        if made == 6:
            raise KeyboardInterrupt
        return {"height": 0.2 * parameters["restitution"] ** 2}

    falling = gf.Problem(
        [gf.Parameter("restitution", 0.3, 0.95), gf.Parameter("friction", 0, 1)],
        [gf.Target("height", 0.12, tolerance=0.0012, unit="m")],
    )
    result = gf.calibrate(falling, stopped)
    quality = result.metamodels["height"]
    assert of_metamodels.FEW_RUNS.is_in(" ".join(quality.warnings), runs=5)
    assert quality.noise > 3 * 0.0012
    assert result.reasons == ()


@pytest.mark.usefixtures("ctrl_c")
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


def test_a_relative_work_folder_is_the_same_place_throughout(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def wandering(parameters: dict[str, float], seed: int) -> dict[str, float]:
        os.chdir(Path(__file__).parent)
        return drum(parameters, seed)

    gf.calibrate(problem(), wandering, workdir="here")
    assert (tmp_path / "here" / "result.json").is_file()


def test_runs_that_all_fail_stop_it_with_the_reason_and_it_can_be_started_again(
    tmp_path: Path,
) -> None:
    broken = True

    def model(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if broken:
            raise ImportError("no module named drum")
        return drum(parameters, seed)

    with pytest.raises(gf.RunFailedError, match=ALL_FAILED.pattern) as caught:
        gf.calibrate(problem(), model, workdir=tmp_path)
    assert "first 3 runs" in str(caught.value)
    assert "no module named drum" in str(caught.value)
    broken = False
    assert gf.calibrate(problem(), model, workdir=tmp_path).status == "calibrated"


def test_failures_that_differ_in_numbers_only_stop_it_as_equal_ones_do() -> None:
    def model(parameters: dict[str, float], seed: int) -> dict[str, float]:
        raise gf.RunFailedError(f"No rest within {seed % 100} s, see /runs/{seed}/log.")

    with pytest.raises(gf.RunFailedError) as caught:
        gf.calibrate(problem(), model)
    assert ALL_FAILED.is_in(str(caught.value), runs=3)


def test_a_target_that_is_added_later_is_found_in_the_runs_that_are_known(tmp_path: Path) -> None:
    both = problem()
    one = gf.Problem(both.parameters, both.targets[:1])
    solver = PythonCallable(drum, ["angle_10rpm"])
    first = gf.calibrate(one, solver, workdir=tmp_path)
    solver = PythonCallable(drum, ["angle_10rpm", "angle_30rpm"])
    result = gf.calibrate(both, solver, workdir=tmp_path)
    assert result.status == "calibrated"
    assert result.runs.warm_start_runs == first.runs.total


def test_a_target_that_no_run_yields_stops_early_and_says_what_there_is() -> None:
    misspelt = gf.Problem(problem().parameters, [gf.Target("angel_10rpm", 36.0)])
    calls = []

    def counted(parameters: dict[str, float], seed: int) -> dict[str, float]:
        calls.append(seed)
        return drum(parameters, seed)

    with pytest.raises(gf.RunFailedError, match=r"give angel_10rpm.*angle_10rpm, angle_30rpm"):
        gf.calibrate(misspelt, counted)
    assert len(calls) <= 4


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_the_budget_holds_with_verification_and_second_thoughts(seed: int) -> None:
    def rough(parameters: dict[str, float], seed: int) -> dict[str, float]:
        random = np.random.default_rng(seed)
        return {"y": 10 + 8 * parameters["x"] ** 2 + 1.5 * random.standard_normal()}

    tight = gf.Problem([gf.Parameter("x", 0, 1)], [gf.Target("y", 12.0, tolerance=0.1)])
    result = gf.calibrate(tight, rough, seed=seed, max_runs=28)
    assert result.runs.total <= 28
    assert result.status == "undecided"
    assert result.reasons[0].kind == "too much scatter"


def test_a_target_far_beyond_a_log_interval_is_out_of_reach_without_a_guess() -> None:
    far = gf.Problem([gf.Parameter("x", 1e-3, 1e3, "log")], [gf.Target("y", 1000.0)])
    result = gf.calibrate(far, lambda p, seed: {"y": 6 + np.log10(p["x"]) + 1e-3 * (seed % 7)})
    assert result.status == "unreachable"
    assert result.out_of_reach[0].suggestion is None


def test_verification_runs_that_fail_are_told_and_confirm_nothing() -> None:
    def drum_that_breaks_late(parameters: dict[str, float], seed: int) -> dict[str, float]:
        seen.append(seed)
        if len(seen) > 11:
            raise RuntimeError("worn out")
        return drum(parameters, seed)

    seen: list[int] = []
    few = gf.Staged(design_runs=8)
    result = gf.calibrate(problem(), drum_that_breaks_late, strategy=few)
    assert result.status == "undecided"
    assert any("worn out" in notice for notice in result.notices)
    assert result.responses["angle_10rpm"].verified_mean is None


def test_tests_that_never_both_succeed_end_with_the_reason() -> None:
    def either(parameters: dict[str, float], seed: int) -> dict[str, float]:
        responses = drum(parameters, seed)
        del responses["angle_10rpm" if seed % 2 else "angle_30rpm"]
        return responses

    with pytest.raises(gf.RunFailedError, match=messages.NO_ANSWER.pattern):
        gf.calibrate(problem(), either, strategy="staged")


@pytest.mark.parametrize("strategy", ["sequential", "staged"])
@pytest.mark.parametrize(("highest", "is_cut_off"), [(0.51, True), (0.9, False)])
def test_an_interval_that_cuts_off_what_agrees_is_named(
    strategy: str, highest: float, is_cut_off: bool
) -> None:
    narrow = gf.Problem(
        [gf.Parameter("friction", 0.1, highest), gf.Parameter("restitution", 0.1, 0.9)],
        [gf.Target("angle", 30.0, tolerance=1.0)],
    )

    def angle(parameters: dict[str, float], seed: int) -> dict[str, float]:
        scatter = 0.1 * np.random.default_rng(seed).standard_normal()
        return {"angle": 10 + 40 * parameters["friction"] + scatter}

    result = gf.calibrate(narrow, angle, strategy=strategy)
    notices = [notice for notice in result.notices if "its bound max = 0.51" in notice]
    assert bool(notices) == is_cut_off
    assert all(notice.startswith("friction ") for notice in notices)
    # That nothing depends on it is no reason for a wider interval.
    assert not any(
        of_calibration.AGREES_UP_TO_BOUND.is_in(notice, parameter="restitution")
        for notice in result.notices
    )


def test_a_rayleigh_weight_works_at_the_bounds_of_a_wide_interval() -> None:
    rayleigh = gf.RayleighTimeStep(
        0.005, {"particle.density": 2100.0, "particle.poissons_ratio": 0.2}
    )
    wide = gf.Problem(
        [gf.Parameter("particle.youngs_modulus", 1e3, 1e13)],
        [gf.Target("y", 5.0)],
        rayleigh,
        rayleigh_weight=0.1,
    )
    result = gf.calibrate(
        wide, lambda p, seed: {"y": 4 + p["particle.youngs_modulus"] / 1e13}, strategy="staged"
    )
    assert result.status in ("calibrated", "out_of_tolerance", "unreachable")


def test_a_result_that_cannot_be_written_is_returned_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "result.json").mkdir()
    result = gf.calibrate(problem(), drum, workdir=tmp_path)
    assert result.status == "calibrated"
    assert any("cannot be written" in notice for notice in result.notices)


def test_constant_responses_are_valid_json(tmp_path: Path) -> None:
    gf.calibrate(problem(), lambda p, seed: {"angle_10rpm": 36, "angle_30rpm": 44}).to_json(
        tmp_path / "result.json"
    )
    text = (tmp_path / "result.json").read_text()
    assert "NaN" not in text
    assert json.loads(text)["status"] == "calibrated"


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
    strategy = gf.Sequential(design_runs=20)
    result = gf.calibrate(problem, drum, workdir=sys.argv[1], workers=2, strategy=strategy)
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
