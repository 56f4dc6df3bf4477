"""Plan of a calibration: its work and cost, before anything is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from grainfit.calibration.readiness import Obstacle, obstacles
from grainfit.calibration.verification import VERIFICATION_RUNS
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.campaign.cluster.executor import describe_cluster, executed_by
from grainfit.errors import GrainfitError, InputError
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.base import Solver
from grainfit.strategies.budget import start_search


@dataclass(frozen=True)
class Plan:
    """A calibration as `grainfit check` shows it.

    Parameters
    ----------
    name : str
        Name of the calibration.
    parameters, targets : sequence
        Free parameters, and targets to meet.
    lines : tuple of str
        Solvers, time step, and cost.
    executes : tuple of str
        Programs, functions and shell lines that a run executes.
    notes : tuple of str
        Free parameters that the tests will leave open, and the effect of soft particles.
    problems : tuple of str
        Problems that keep it from running; empty when there are none.
    """

    name: str
    parameters: Sequence[Parameter]
    targets: Sequence[Target]
    lines: tuple[str, ...]
    executes: tuple[str, ...]
    notes: tuple[str, ...]
    problems: tuple[str, ...]


def describe_plan(setup: CalibrationSetup) -> Plan:
    """Describe what a calibration will do; starts no simulation and none of the user's code."""
    problems: list[str] = []
    lines: list[str] = []
    executes: list[str] = []
    for test, solver in setup.solvers.items():
        try:
            # Before the check, so that it is shown even if the check fails.
            executes += [f"test {test}: {line}" for line in solver.executes()]
            solver.check()
            lines.append(f"Test {test}: {solver.readiness()}")
            lines += _cost_lines(solver, setup.problem)
        except GrainfitError:
            # One of the obstacles.
            continue
    problems += chain(*(_words(setup, found) for found in obstacles(setup.problem, setup.solvers)))
    lines += _rayleigh_lines(setup.problem)
    cluster = setup.cluster or setup.file.cluster
    if cluster is not None:
        lines += describe_cluster(cluster)
        executes += [f"cluster: {line}" for line in executed_by(cluster)]
    try:
        lines += _run_lines(setup)
    except InputError as error:
        problems += [str(fault) for fault in error.faults]
    problem = setup.problem
    return Plan(
        setup.name,
        problem.parameters,
        problem.targets,
        tuple(lines),
        tuple(executes),
        setup.notes(),
        tuple(problems),
    )


def _words(setup: CalibrationSetup, obstacle: Obstacle) -> list[str]:
    test = f"test {obstacle.test}" if obstacle.test else ""
    if isinstance(obstacle.error, InputError):
        source = obstacle.error.source or f"{setup.file.path}"
        where = f"{source}: {test}, " if test else f"{source}: "
        return [f"{where}{fault}" for fault in obstacle.error.faults]
    return [f"Test {obstacle.test}: {obstacle.error}"]


def _rayleigh_lines(problem: Problem) -> Iterator[str]:
    if problem.rayleigh is not None:
        smallest, largest = problem.rayleigh.limits(problem.intervals)
        yield f"Rayleigh time step within the intervals: {smallest:.4g} to {largest:.4g} s."


def _cost_lines(solver: Solver, problem: Problem) -> Iterator[str]:
    cost = solver.estimate_cost(problem.from_unit([0.5] * problem.dimension))
    if cost is not None:
        yield f"  In the middle of the intervals: {cost}."


def _run_lines(setup: CalibrationSetup) -> Iterator[str]:
    dimension = setup.problem.dimension
    strategy = setup.strategy
    verification = strategy.verification_runs or VERIFICATION_RUNS
    tests = len(setup.solvers)
    search = start_search(
        strategy.strategy,
        setup.problem,
        tests,
        seed=1,
        max_runs=strategy.max_runs,
        verification_runs=verification,
    )
    design = search.runs_of_design
    behind = max(search.expected_left - design, verification * tests)
    yield (
        f"DEM runs: {design} for the design, then usually {behind} to "
        f"{4 * behind}, more where a run scatters by more than the tolerance; the last "
        f"{verification * tests} or more are fresh seeds at the answer. {setup.workers} at a time. "
        f"Strategy: {search.name}."
    )
    if dimension > len(setup.problem.targets):
        yield (
            f"Note: {dimension} free parameters and {len(setup.problem.targets)} targets: many "
            "parameter sets will fit equally well. Fix a parameter or measure another response."
        )
