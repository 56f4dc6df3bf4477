"""Advice for a calibration: simulate further tests along the directions that are open."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis.advice import Advice, CandidateTest, OpenParameters, advice
from grainfit.analysis.bench import Bench, other_tests
from grainfit.analysis.information import Knowledge
from grainfit.analysis.slopes import Cloud, Run, simulated_measurable
from grainfit.calibration_file.accuracies import Accuracies, accuracy_of, read_accuracies
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.study import ExpectedWork, Study, simulate_study
from grainfit.checks import as_number
from grainfit.errors import Fault, InputError
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.solvers.base import Solver
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.solvers_of_runs import solvers_of

#: Seeds of each parameter set: by default, and most where the time allows more.
SEEDS, MOST_SEEDS = 2, 4


def advise(
    saved: SavedCalibration,
    *,
    tests: Sequence[str] = (),
    accuracies: Mapping[str, str | float] | None = None,
    seeds: int | None = None,
    max_seconds: float | None = None,
    workers: int | None = None,
    workdir: str | Path | None = None,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> Advice:
    """Compute which further test would settle the parameters that the runs leave open.

    Every bulk test that the calibration does not have is simulated at a few parameter sets that
    agree with the measurements, spread along the principal directions of the posterior
    distribution. A test helps as far as its responses differ between them by more than they scatter
    and by more than a laboratory measures.

    Parameters
    ----------
    saved : SavedCalibration
        A calibration, finished or not.
    tests : sequence of str
        Types of test to compare; by default all of the bench.
    accuracies : mapping of str to str or float, optional
        Accuracies of measurements that replace the usual ones, by name of the response.
    seeds : int, optional
        Seeds of each parameter set; by default 2, or as many as ``max_seconds`` allows.
    max_seconds : float, optional
        Wall time after which no more is simulated, s.
    workers : int, optional
        Runs at a time; by default those of the calibration.
    workdir : path, optional
        Where runs are kept; by default the work folder. After Ctrl-C, another call continues.
    on_start : callable, optional
        Called with the expected work before the first run; it may raise to stop.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

    Returns
    -------
    Advice
        `print` shows it as a table and in words.

    Raises
    ------
    InputError
        The calibration has no posterior yet, its tests are models of the user, or an option is
        impossible.
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used, for example because the calibration is running.

    Examples
    --------
    >>> import grainfit as gf
    >>> print(gf.open("beads.grainfit").advise())  # doctest: +SKIP
    """
    given = read_accuracies(accuracies or {})
    _require_possible(seeds, max_seconds, workers)
    values = _posterior_values(saved)
    cloud = Cloud.of(saved.problem, values)
    solvers = solvers_of(saved)
    medians = dict(zip(cloud.names, np.median(values, axis=0).tolist(), strict=True))
    today = _today(saved, cloud.knowledge, medians, solvers)
    if not today.parameters:
        return Advice(today)
    material = _material(solvers, medians)
    bench = other_tests(saved.problem, solvers, material, tests)
    if not bench.solvers:
        return Advice(today, refused=bench.refused)
    points = [dict(zip(cloud.names, values[i].tolist(), strict=True)) for i in cloud.spread()]
    count = seeds or affordable_seeds(bench.solvers, points, workers or saved.workers, max_seconds)
    evaluations = simulate_points(
        bench.solvers,
        points,
        count,
        Path(workdir or saved.folder),
        workers or saved.workers,
        max_seconds,
        on_start,
        on_progress,
    )
    candidates, failed = candidate_tests(bench, cloud, points, evaluations, given)
    return advice(today, candidates, {**bench.refused, **failed}, len(points), count)


def _require_possible(seeds: object, max_seconds: object, workers: object) -> None:
    faults = [
        Fault(key, f"is {value!r}.", "Give a whole number from 1 on.")
        for key, value in (("seeds", seeds), ("workers", workers))
        if value is not None
        and (not isinstance(value, int) or isinstance(value, bool) or value < 1)
    ]
    if max_seconds is not None and not as_number(max_seconds) > 0:
        faults.append(Fault("max_seconds", f"is {max_seconds!r}.", "Give a time above 0 s."))
    if faults:
        raise InputError(faults)


def _posterior_values(saved: SavedCalibration) -> NDArray[np.float64]:
    """Return a sample of the parameter sets that agree with the measurements."""
    folder = str(saved.folder)
    if saved.why_nothing_agrees:
        raise InputError(
            Fault("", saved.why_nothing_agrees, "Widen an interval first: see the report."), folder
        )
    analysis = saved.analyse()
    if analysis.posterior is None:
        why = " ".join(analysis.notes) or "There are too few runs."
        raise InputError(Fault("", why, "Let the calibration make more runs first."), folder)
    return analysis.posterior.values


def _material(solvers: Mapping[str, Solver], values: Mapping[str, float]) -> dict[str, float]:
    """Return all material parameters, from the first solver of a bulk test."""
    found = (solver.run_parameters(values) for solver in solvers.values() if solver.bulk_test)
    return next(found, dict(values))


def _today(
    saved: SavedCalibration,
    knowledge: Knowledge,
    medians: Mapping[str, float],
    solvers: Mapping[str, Solver],
) -> OpenParameters:
    intervals = saved.intervals
    answer = saved.result.parameters if saved.result else {}
    free = [p for p in saved.problem.parameters if intervals[p.name].determination != "determined"]
    seconds = sum(seconds_of(solver, medians) for solver in solvers.values())
    return OpenParameters(tuple(free), intervals, {**medians, **answer}, knowledge, seconds)


def affordable_seeds(
    solvers: Mapping[str, Solver],
    points: Sequence[Mapping[str, float]],
    workers: int,
    max_seconds: float | None,
) -> int:
    """Return as many seeds of each parameter set as the time allows, at least one."""
    if max_seconds is None:
        return SEEDS
    costs = [solver.estimate_cost(point) for solver in solvers.values() for point in points]
    seconds = sum(cost.wall_seconds for cost in costs if cost is not None) / workers
    return max(1, min(MOST_SEEDS, int(max_seconds / max(seconds, 1e-9))))


def simulate_points(
    solvers: Mapping[str, Solver],
    points: Sequence[Mapping[str, float]],
    seeds: int,
    folder: Path,
    workers: int,
    max_seconds: float | None = None,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> list[Evaluation]:
    """Simulate parameter sets in every test, with the same seeds at all of them."""
    # All points with one seed first: when the time is over, every direction has been seen.
    proposals = [Proposal(p, s, "design") for s in range(1, seeds + 1) for p in points]
    timeouts = {name: _timeout(solver, points) for name, solver in solvers.items()}
    known = {name: seconds for name, seconds in timeouts.items() if seconds is not None}
    study = Study(solvers, proposals, CampaignOptions(workers, known), max_seconds)
    return simulate_study(study, folder, on_start, on_progress)


def _timeout(solver: Solver, points: Sequence[Mapping[str, float]]) -> float | None:
    found = [solver.default_timeout(point) for point in points]
    return max((seconds for seconds in found if seconds is not None), default=None)


def candidate_tests(
    bench: Bench,
    cloud: Cloud,
    points: Sequence[Mapping[str, float]],
    evaluations: Sequence[Evaluation],
    accuracies: Accuracies,
) -> tuple[list[CandidateTest], dict[str, str]]:
    """Return the simulated tests with their slopes, and reasons for those that have none.

    Parameters
    ----------
    bench : Bench
        The tests.
    cloud : Cloud
        Parameter sets among which they are to decide.
    points : sequence of mapping of str to float
        Simulated parameter sets.
    evaluations : sequence of Evaluation
        Runs at these points.
    accuracies : mapping of str to Accuracy
        Those that replace the usual ones.
    """
    numbers = {tuple(point.values()): i for i, point in enumerate(points)}
    where = cloud.relative(points)
    found, failed = [], {}
    for test, solver in bench.solvers.items():
        assert solver.bulk_test is not None, "the bench has bulk tests only"
        responses = []
        for name, info in solver.bulk_test.responses.items():
            key = response_name(test, name, len(bench.solvers))
            runs = [
                Run(
                    numbers[tuple(evaluation.proposal.parameters.values())],
                    evaluation.proposal.seed,
                    evaluation.responses[key].value,
                )
                for evaluation in evaluations
                if key in evaluation.responses
            ]
            accuracy = accuracy_of(test, name, info.unit, accuracies)
            seen = simulated_measurable(f"{test}.{name}", accuracy, cloud, where, runs)
            responses += [seen] if seen is not None else []
        if responses:
            found.append(CandidateTest(test, seconds_of(solver, points[0]), tuple(responses)))
        else:
            failed[test] = _why_failed(test, evaluations)
    return found, failed


def seconds_of(solver: Solver, point: Mapping[str, float]) -> float:
    """Return the estimated wall time of a run, s; 0 if it is unknown."""
    cost = solver.estimate_cost(point)
    return 0.0 if cost is None else cost.wall_seconds


def _why_failed(test: str, evaluations: Sequence[Evaluation]) -> str:
    reasons = dict.fromkeys(e.failures[test] for e in evaluations if test in e.failures)
    if reasons:
        return f"Its runs failed: {next(iter(reasons))}"
    return "Too few of its runs ended in time."
