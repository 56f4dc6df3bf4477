"""Calibrations of the study: by grainfit, and by the method's original tools."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from grainfit.calibration.calibrate import calibrate
from grainfit.calibration.progress import Progress
from grainfit.campaign.store.store import RunStore
from grainfit.errors import RunFailedError
from grainfit.problem import Problem
from grainfit.result import Result
from grainfit.strategies.registry import make_strategy
from studies.rackl2016.peer import calibrate_with_octave, settings_of
from studies.rackl2016.runs import Runs, fresh_seeds
from studies.rackl2016.setting import RESPONSES
from studies.rackl2016.tasks import Context, Record

_TIMEOUT = 1800.0
#: Runs of step 3 that are no finite differences.
_STEP = "step"


def calibrate_with_grainfit(
    context: Context,
    problem: Problem,
    *,
    strategy: Literal["staged", "sequential"],
    seed: int,
    design_runs: int | None = None,
    most_search_runs: int | None = None,
    verification_runs: int = 0,
) -> Record:
    """Calibrate in the task's folder; an interrupted one goes on.

    With a limit of the search, every verification is paid for besides: one that fails is followed
    by more search up to the limit, as when a user starts again with a larger budget.
    """
    folder = context.folder / "grainfit"
    options = {} if design_runs is None else {"design_runs": design_runs}

    def show(progress: Progress) -> None:
        context.report(progress.done, progress.done + progress.to_come.about, progress.stage)

    def start(max_runs: int | None) -> Result:
        result = calibrate(
            problem,
            {"heap": context.solver},
            strategy=make_strategy(strategy, options),
            seed=seed,
            workers=context.workers,
            workdir=folder,
            name=context.folder.parent.name,
            max_runs=max_runs,
            verification_runs=verification_runs or None,
            timeouts={"heap": _TIMEOUT},
            keep="results",
            on_progress=show,
        )
        if result.status == "interrupted":
            raise KeyboardInterrupt
        return result

    if most_search_runs is None:
        return _record(start(None), folder)
    budget = 0
    affordable = most_search_runs + verification_runs
    while affordable > budget:
        budget = affordable
        result = start(budget)
        if result.status == "out_of_tolerance":
            affordable = most_search_runs + result.runs.verification + verification_runs
    return _record(result, folder)


def _record(result: Result, folder: Path) -> Record:
    current_problem = [run for run in result.history if run.stage != "verification"]
    return {
        "status": result.status,
        "parameters": dict(result.parameters),
        "responses": {name: asdict(response) for name, response in result.responses.items()},
        "design_runs": result.runs.design,
        "optimisation_runs": result.runs.optimisation,
        "verification_runs": result.runs.verification,
        "verification_seconds": verification_seconds(folder, result.identity),
        "failed_runs": result.runs.failed,
        "runs_made": result.runs.total,
        "last_run": dict(current_problem[-1].responses),
        "rayleigh_time_step": result.rayleigh_time_step,
        "rayleigh_time_step_before": result.rayleigh_time_step_before,
        "probability_all_met": result.probability_all_met,
        "notices": list(result.notices),
        "out_of_reach": [asdict(miss) for miss in result.out_of_reach],
        "version": result.version,
    }


def verification_seconds(folder: Path, calibration: str) -> float:
    """Wall time during which runs of a verification were under way in a work folder, s."""
    store = RunStore.read_only(folder)
    try:
        requests = store.requests(calibration)
        asked = {run for r in requests if r.stage == "verification" for run in r.runs.values()}
        runs = store.find_many(asked).values()
    finally:
        store.close()
    total, covered_until = 0.0, 0.0
    for begun, ended in sorted((run.ended - run.seconds, run.ended) for run in runs):
        total += max(0.0, ended - max(begun, covered_until))
        covered_until = max(covered_until, ended)
    return total


def calibrate_with_peer(
    context: Context, problem: Problem, *, seed: int, weight: float, design_runs: int
) -> Record:
    """Calibrate with Octave's tools, with one insertion seed for all runs as in the paper."""
    settings = settings_of(problem, seed, weight, design_runs)
    with Runs(context.solver, context.folder / "runs", context.workers) as runs:

        def show(ended: int, asked: int) -> None:
            context.report(ended, asked, "runs that Octave asks for")

        found = calibrate_with_octave(problem, settings, runs, context.folder, show)
    history = found.pop("history")
    names = [parameter.name for parameter in problem.parameters]
    parameters = dict(zip(names, map(float, found["parameters"]), strict=True))
    behind_design = [run for run in history if run["purpose"] != "design"]
    steps = [run for run in behind_design if run["purpose"] == _STEP]
    assert problem.rayleigh is not None, "this material has a Rayleigh time step"
    return {
        "status": "stopped" if found["reason"] else "finished",
        "parameters": parameters,
        "design_runs": len(history) - len(behind_design),
        "optimisation_runs": len(behind_design),
        "difference_runs": sum(run["purpose"] == "differences" for run in behind_design),
        "serial_runs": len(steps),
        "verification_runs": 0,
        "verification_seconds": 0.0,
        "failed_runs": sum(run["responses"] is None for run in history),
        "runs_made": len(_different(history)),
        "last_run": _nearest(steps, parameters)["responses"],
        "rayleigh_time_step": problem.rayleigh_time_step(parameters),
        "notices": [found["reason"]] if found["reason"] else [],
        "out_of_reach": [],
        "octave": {key: found[key] for key in ("start", "convergence", "iterations", "versions")},
    }


def _nearest(steps: list[dict[str, Any]], parameters: dict[str, float]) -> dict[str, Any]:
    """The run of the best step, which the fit returns; numbers come back with fewer digits."""

    def distance(run: dict[str, Any]) -> float:
        point: dict[str, float] = run["parameters"]
        return max(abs(point[name] / value - 1) for name, value in parameters.items())

    return min(steps, key=distance)


def _different(history: list[dict[str, Any]]) -> set[tuple[float, ...]]:
    return {tuple(run["parameters"].values()) for run in history}


def expected_responses(
    context: Context, parameters: dict[str, float], runs: int, name: str
) -> Record:
    """Responses of fresh insertion seeds at one parameter set, by response."""
    orders = [(parameters, seed) for seed in fresh_seeds(name, runs)]
    with Runs(context.solver, _store(context), context.workers) as making:
        made = making.make(orders, lambda ended, asked: context.report(ended, asked, "fresh seeds"))
    finished = [responses for responses in made if responses is not None]
    if len(finished) < 2:
        raise RunFailedError(f"{name}: {len(made) - len(finished)} of {len(made)} runs failed.")
    return {
        "parameters": parameters,
        "values": {response: [run[response] for run in finished] for response in RESPONSES},
        "failed_runs": len(made) - len(finished),
        "runs_made": len(made),
    }


def _store(context: Context) -> Path:
    return context.folder / "runs"
