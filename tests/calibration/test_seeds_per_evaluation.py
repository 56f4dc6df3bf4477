"""`repeats`: the mean of runs with several seeds is one evaluation, each run a run of its own."""

from __future__ import annotations

import math
import threading
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration.scopes import with_scopes
from grainfit.calibration_file import messages as of_calibration_file
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.campaign import messages
from grainfit.campaign.campaign import Campaign, CampaignOptions, evaluation_of
from grainfit.campaign.repeats import mean_outcome, seeds_of
from grainfit.campaign.reuse import runs_of
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import Curve, Proposal, Response
from grainfit.problem import TestScope
from grainfit.run_definition import RunDefinition
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies.run_costs import RunCosts
from grainfit.which_test.simulation import Simulation

calls: list[int] = []
interrupt_at: list[int] = []


def drum(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """A noisy test; it counts its runs and can be interrupted."""
    calls.append(seed)
    if len(calls) in interrupt_at:
        raise KeyboardInterrupt
    noise = np.random.default_rng(seed).standard_normal()
    return {"angle": 40 * parameters["friction"] + 0.3 * noise}


@pytest.fixture(autouse=True)
def _fresh() -> None:
    calls.clear()
    interrupt_at.clear()


def problem() -> gf.Problem:
    return gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 20.0, tolerance=0.5)]
    )


def record(number: int, responses: Mapping | None = None, **changes: object) -> RunRecord:
    definition = RunDefinition({"solver": "drum"}, {}, number)
    known = RunRecord(definition.identity, "drum", "finished", definition, responses or {})
    return replace(known, **changes)


def failed(number: int, reason: str = "it broke", kind: str = "simulation") -> RunRecord:
    return record(number, status="failed", reason=reason, kind=kind)


# The mean ---------------------------------------------------------------------------------------


def test_the_mean_of_an_evaluation_has_the_standard_error_of_the_sample() -> None:
    runs = [record(n, {"angle": Response(v)}) for n, v in enumerate((19.0, 20.0, 24.0))]
    mean = mean_outcome(runs).responses["angle"]
    assert mean == Response(21.0, pytest.approx(math.sqrt(7.0 / 3)))


def test_runs_that_agree_by_chance_have_at_least_the_error_of_their_own() -> None:
    runs = [record(n, {"angle": Response(20.0, 0.4)}) for n in range(4)]
    assert mean_outcome(runs).responses["angle"] == Response(20.0, pytest.approx(0.2))


def test_the_mean_of_curves_is_over_the_coordinates_that_all_reach() -> None:
    long = record(1, {"stress": Curve([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0])})
    short = record(2, {"stress": Curve([0.5, 2.5], [1.5, 3.5])})
    mean = mean_outcome([long, short]).responses["stress"]
    assert mean == Curve([0.5, 1.0, 2.0, 2.5], [1.0, 1.5, 2.5, 3.0])


def test_a_curve_that_stays_counts_beyond_its_end() -> None:
    runs = [
        record(1, {"mass": Curve([0.0, 1.0], [0.0, 1.0], stays=True)}),
        record(2, {"mass": Curve([0.0, 2.0], [0.0, 4.0], stays=True)}),
    ]
    mean = mean_outcome(runs).responses["mass"]
    assert mean == Curve([0.0, 1.0, 2.0], [0.0, 1.5, 2.5], stays=True)


def test_curves_without_common_coordinates_fail_the_evaluation() -> None:
    apart = [Curve([0.0, 1.0], [0.0, 1.0]), Curve([2.0, 3.0], [0.0, 1.0])]
    outcome = mean_outcome([record(n, {"stress": one}) for n, one in enumerate(apart)])
    assert messages.NOTHING_IN_COMMON.is_in(outcome.reason)


def test_runs_of_which_some_yield_a_curve_and_others_a_number_fail_the_evaluation() -> None:
    run = RunDefinition({}, {}, 1)
    records = [
        RunRecord("a", "drum", "finished", run, {"angle": Response(1.0)}),
        RunRecord("b", "drum", "finished", run, {"angle": Curve([0.0, 1.0], [1.0, 2.0])}),
    ]

    assert messages.NUMBER_AND_CURVE.is_in(mean_outcome(records).reason)


def test_a_failed_run_leaves_the_mean_of_the_others_if_half_succeeded() -> None:
    runs = [failed(1), record(2, {"angle": Response(20.0)})]
    one = Proposal({}, 1, "design")
    found = evaluation_of(one, {"drum": runs[0], "drum, seed 2": runs[1]}, 1)
    assert found.responses == {"angle": Response(20.0)}
    assert not found.failures
    assert found.failed_runs == {"drum": "it broke"}


def test_an_evaluation_fails_with_most_of_its_runs_and_says_why() -> None:
    runs = {"drum": failed(1), "drum, seed 2": record(2, {"angle": Response(20.0)})}
    runs["drum, seed 3"] = failed(3, "it jammed", "machine")
    found = evaluation_of(Proposal({}, 1, "design"), runs, 1)
    assert not found.responses
    assert found.failures == {"drum": "2 of 3 runs failed: it jammed"}
    assert not found.failed_by_machine


def test_seeds_of_an_evaluation_begin_with_that_of_its_proposal() -> None:
    three = seeds_of(7, 3)
    assert three[0] == 7
    assert len(set(three)) == 3
    assert seeds_of(7, 5)[:3] == three
    assert not set(three[1:]) & set(seeds_of(8, 3))


# Campaigns --------------------------------------------------------------------------------------


def test_the_runs_of_an_evaluation_use_all_workers_and_are_kept_one_by_one() -> None:
    at_once: list[int] = []
    running = threading.Semaphore(0)
    order = seeds_of(4, 3)

    def slow(parameters: dict[str, float], seed: int) -> dict[str, float]:
        running.release()
        # The last seed ends first.
        time.sleep(0.4 - 0.1 * order.index(seed))
        at_once.append(running._value)
        return {"angle": float(seed)}

    store = RunStore.in_memory()
    options = CampaignOptions(3, repeats={"drum": 3})
    campaign = Campaign({"drum": PythonCallable(slow)}, store, None, options)
    campaign.start(Proposal({"friction": 0.5}, 4, "design"))
    ended = campaign.wait()
    while campaign.has_pending:
        ended += campaign.wait()
    campaign.close()
    [found] = ended
    assert at_once[0] == 3
    assert list(found.runs) == ["drum", "drum, seed 2", "drum, seed 3"]
    assert sorted(run.definition.seed for run in store.runs("finished")) == sorted(seeds_of(4, 3))
    assert found.responses["angle"].value == pytest.approx(np.mean(seeds_of(4, 3)))


def test_known_seeds_are_reused_and_only_the_others_are_run() -> None:
    store, proposal = RunStore.in_memory(), Proposal({"friction": 0.5}, 4, "design")
    for repeats in (1, 3):
        options = CampaignOptions(repeats={"drum": repeats})
        campaign = Campaign({"drum": PythonCallable(drum)}, store, None, options)
        campaign.start(proposal)
        [found] = campaign.wait()
        campaign.close()
    assert calls == seeds_of(4, 3)
    assert (found.reused, len(found.runs)) == (1, 3)


def test_stored_runs_of_one_evaluation_are_found_as_one() -> None:
    solver = PythonCallable(drum)
    values = {"friction": 0.5}

    def known(seed: int) -> RunRecord:
        definition = solver.definition(values, seed)
        angle = {"angle": Response(float(seed))}
        return RunRecord(definition.identity, "drum", "finished", definition, angle)

    records = [known(seed) for seed in (*reversed(seeds_of(4, 3)), 99)]
    found = runs_of(problem(), {"drum": solver}, records, {"drum": 3})
    assert [(e.proposal.seed, len(e.runs)) for e in found] == [(4, 3), (99, 1)]
    assert found[0].responses["angle"].value == pytest.approx(np.mean(seeds_of(4, 3)))
    assert found[0].proposal.tests is None


# Calibrations -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Whole:
    """A calibration, its folder, and what it was seen to do."""

    result: gf.Result
    folder: Path
    calls: list[int]
    told: list[gf.Progress]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    folder = tmp_path_factory.mktemp("drum")
    told: list[gf.Progress] = []
    calls.clear()
    result = gf.calibrate(
        problem(), drum, repeats=3, max_runs=36, workdir=folder, workers=1, on_progress=told.append
    )
    return Whole(result, folder, list(calls), told)


def test_a_calibration_counts_its_runs_and_keeps_to_its_budget(whole: Whole) -> None:
    result, made = whole.result, whole.calls
    assert result.status == "calibrated"
    assert result.runs.total == len(made) == len(set(made)) == whole.told[-1].done <= 36
    assert all(len(run.runs) == 3 for run in result.history)


def test_a_saved_calibration_has_the_means_and_every_run(whole: Whole) -> None:
    saved = gf.open(whole.folder)
    assert len(saved.records) == len(whole.calls)
    assert [e.responses["angle"].value for e in saved.evaluations] == [
        run.responses["angle"] for run in whole.result.history
    ]
    assert all(e.proposal.tests is None for e in saved.evaluations)
    assert f"{len(whole.calls)} runs ended" in str(saved)


def test_a_budget_below_the_design_is_refused_in_runs() -> None:
    with pytest.raises(InputError, match="Allow at least 21"):
        gf.calibrate(problem(), drum, repeats=3, max_runs=20)


@pytest.mark.parametrize("interrupted_at", [5, "verification"])
def test_interrupted_between_the_seeds_of_an_evaluation_it_repeats_no_run(
    tmp_path: Path, whole: Whole, interrupted_at: int | str
) -> None:
    if isinstance(interrupted_at, str):
        first = [run.stage for run in whole.result.history].index("verification")
        interrupted_at = 3 * first + 2
    interrupt_at.append(interrupted_at)
    # With more workers, runs that are under way at the interrupt are repeated, too.
    options = {"repeats": {"simulate": 3}, "max_runs": 36, "workdir": tmp_path, "workers": 1}
    stopped = gf.calibrate(problem(), drum, **options)
    assert stopped.status == "interrupted"
    result = gf.calibrate(problem(), drum, **options)
    assert [(r.seed, r.parameters) for r in result.history] == [
        (r.seed, r.parameters) for r in whole.result.history
    ]
    assert [n for n in Counter(calls).values() if n > 1] in ([], [2]), "only the interrupted run"
    assert len(calls) == whole.result.runs.total + 1


def test_an_evaluation_of_several_seeds_costs_as_much_as_its_runs() -> None:
    scopes = [
        TestScope("heap", ["heap.angle"], ["friction"], 60.0, repeats=4),
        TestScope("drum", ["drum.angle"], ["friction"], 60.0),
    ]
    targets = [gf.Target(name, 20.0) for name in ("heap.angle", "drum.angle")]
    two = replace(problem(), targets=targets, tests=scopes)
    costs = RunCosts(two, [])
    middle = np.array([[0.5]])
    assert costs.seconds(scopes[0], middle) == pytest.approx(4 * costs.seconds(scopes[1], middle))


def test_a_search_counts_the_runs_of_tests_with_unequal_repeats() -> None:
    two = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9), gf.Parameter("bounce", 0.1, 0.9)],
        [
            gf.Target("heap.angle", 15.0, tolerance=0.4),
            gf.Target("drop.rebound", 20.0, tolerance=4.0),
        ],
        tests=[
            TestScope("heap", ["heap.angle"], ["friction"], repeats=4),
            TestScope("drop", ["drop.rebound"], ["bounce"]),
        ],
    )
    search = gf.Sequential().start(two, seed=1, max_evaluations=10)
    runs = 0
    while (proposal := search.ask()) is not None:
        noise = np.random.default_rng(proposal.seed).standard_normal()
        values = proposal.parameters
        responses = {
            "heap.angle": Response(30 * values["friction"] + 5 * noise),
            "drop.rebound": Response(40 * values["bounce"]),
        }
        asked = [scope for scope in two.tests if proposal.asks_for(scope.name)]
        runs += sum(scope.repeats for scope in asked)
        names = {scope.targets[0] for scope in asked}
        told = {name: found for name, found in responses.items() if name in names}
        search.tell(proposal, gf.Evaluation(proposal, told))
    # Ten sets of five runs each: another evaluation of the heap might not fit.
    assert 46 <= runs <= 50


def test_several_tests_get_their_own_repeats() -> None:
    targets = [gf.Target(name, 20.0, tolerance=0.4) for name in ("heap.angle", "drum.angle")]
    solvers = {"heap": PythonCallable(drum), "drum": PythonCallable(drum)}
    two = with_scopes(replace(problem(), targets=targets), solvers, {"heap": 5})
    assert [scope.repeats for scope in two.tests] == [5, 1]


@pytest.mark.parametrize("given", [0, 2.5, {"simulate": 0}, {"drum": 2}])
def test_repeats_that_are_no_count_or_of_no_test_are_refused(given: object) -> None:
    with pytest.raises(InputError, match="repeats"):
        gf.calibrate(problem(), drum, repeats=given)  # type: ignore[arg-type]


def test_failures_of_single_runs_are_counted_and_told() -> None:
    def fragile(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if seed % 5 == 0:
            raise RunFailedError("the drum broke")
        return drum(parameters, seed)

    result = gf.calibrate(problem(), fragile, repeats=4, max_runs=28)
    lost = sum(len(run.runs) for run in result.history) - len(calls)
    assert result.runs.failed == lost > 0
    assert result.runs.total == len(calls) + lost


# The calibration file ---------------------------------------------------------------------------

FILE = """\
name = "sand"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:drum"
repeats = %s
targets.angle = { value = 20, tolerance = 0.5, unit = "deg" }
[strategy]
max_runs = 40
"""
MODEL = """\
import random

def drum(parameters, seed):
    return {"angle": 40 * parameters["friction"] + random.Random(seed).gauss(0, 0.3)}
"""


def test_repeats_in_a_file_are_planned_and_made(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text(MODEL)
    (tmp_path / "sand.toml").write_text(FILE % 2)
    setup = load_calibration(tmp_path / "sand.toml")
    assert setup.repeats == {"python": 2}
    lines = " ".join(describe_plan(setup).lines)
    assert "8 of them for" in lines
    assert of_calibration_file.REPEATS.is_in(lines, test="python", count=2)
    result = setup.calibrate(tmp_path / "work")
    assert all(len(run.runs) == 2 for run in result.history)
    # The scatter of single runs is shown, from which repeats are chosen.
    shown = gf.repeat_runs(setup, repeat=3, workdir=tmp_path / "simulated")
    assert len(shown["angle"].values) == 3
    assert all(len(one.runs) == 1 for one in shown.evaluations)


@pytest.mark.parametrize("given", ["0", "1.5", '"three"'])
def test_repeats_in_a_file_must_be_a_count(tmp_path: Path, given: str) -> None:
    (tmp_path / "sand.toml").write_text(FILE % given)
    with pytest.raises(InputError, match="repeats"):
        load_calibration(tmp_path / "sand.toml")


@pytest.mark.parametrize("given", [np.int64(2), {"simulate": np.int32(2)}])
def test_counts_of_numpy_are_whole_numbers(given: Any, tmp_path: Path) -> None:
    result = gf.calibrate(problem(), drum, repeats=given, max_runs=24, workdir=tmp_path)
    assert result.runs.total > 0
    scope = TestScope("heap", ["heap.angle"], ["friction"], repeats=np.int64(4))
    holdout = gf.Holdout("drum", drum, [gf.Target("angle", 20.0)], repeats=np.int64(4))
    assert {type(scope.repeats), type(holdout.repeats)} == {int}
    plan = Simulation(tmp_path, np.int64(1), np.int64(2))
    assert (type(plan.workers), type(plan.seeds)) == (int, int)
