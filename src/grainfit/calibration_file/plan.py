"""Plan of a calibration: its work and cost, before anything is run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

from grainfit.bulk_tests.abilities import is_of_user
from grainfit.bulk_tests.apparatus import ApparatusValue, apparatus_lines
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.workload import workload
from grainfit.calibration.holdout import Holdout, require_holdouts
from grainfit.calibration.messages import GUIDED_BY_ATLAS
from grainfit.calibration.readiness import Obstacle, obstacles
from grainfit.calibration_file import messages
from grainfit.calibration_file.apparatus import simulated_apparatus
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.checks.context import context_of
from grainfit.calibration_file.checks.registry import findings
from grainfit.calibration_file.contact_lines import chosen_model_lines, cohesion_lines
from grainfit.calibration_file.fault_lines import (
    FileFinding,
    faults_with_lines,
    with_key_lines,
    with_lines,
)
from grainfit.calibration_file.relatives import what_differs
from grainfit.calibration_file.run_time import (
    ExpectedRuns,
    RunTime,
    costs_of_runs,
    expected_runs,
    run_time,
)
from grainfit.calibration_file.twins import first_twins, series_of_sizes
from grainfit.campaign.cluster.executor import describe_cluster, executed_by
from grainfit.errors import Fault, GrainfitError, InputError
from grainfit.formatting import counted, duration, in_a_row, millimetres, percent
from grainfit.materials.sizes import ParticleSizes
from grainfit.one_thread import one_thread
from grainfit.problem import CurveTarget, Parameter, Problem, Target
from grainfit.solvers.base import Solver
from grainfit.solvers.speed import Speed
from grainfit.verdict.options import HOLDOUT

#: Share of the time of a run above which the price of particles is not stated.
_HARDLY_FASTER = 0.8
#: Share of the mass, in the finest particles, of which the price is stated.
_FINEST = 0.05
#: Only ratios of times are shown, which are the same at any speed.
_ANY_SPEED = Speed(1.0)


@dataclass(frozen=True)
class Plan:
    """A calibration as `grainfit check` shows it.

    Parameters
    ----------
    name : str
        Name of the calibration.
    parameters, targets, curves : sequence
        Free parameters, and targets and measured curves to meet.
    lines : tuple of str
        Solvers, time step, and cost.
    executes : tuple of str
        Programs, functions and shell lines that a run executes.
    findings : tuple of FileFinding
        What the checks found, with its lines.
    problems : tuple of str
        Problems that keep it from running; empty when there are none.
    seconds : pair of float, optional
        Smallest and largest usual wall time in all, s; None if the cost of a run is not known.
    apparatus : mapping of str to tuple of ApparatusValue
        Apparatus of each built-in test.
    runs : pair of int, optional
        Smallest and largest usual number of runs in all; None if the options do not fit.
    """

    name: str
    parameters: Sequence[Parameter]
    targets: Sequence[Target]
    curves: Sequence[CurveTarget]
    lines: tuple[str, ...]
    executes: tuple[str, ...]
    findings: tuple[FileFinding, ...]
    problems: tuple[str, ...]
    seconds: tuple[float, float] | None = None
    apparatus: Mapping[str, tuple[ApparatusValue, ...]] = field(default_factory=dict)
    runs: tuple[int, int] | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """Texts of the findings."""
        return tuple(finding.text for finding in self.findings)


@one_thread()
def describe_plan(setup: CalibrationSetup, *, call_scenes: bool = True) -> Plan:
    """Describe what a calibration will do; starts no simulation.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration.
    call_scenes : bool
        Call the functions that describe scenes of the user, to find their faults and their cost.
        No other code of the user is executed, and none at all without this.
    """
    problems: list[str] = []
    apparatus = simulated_apparatus(setup)
    lines = list(_correlation_lines(setup.problem))
    executes: list[str] = []
    without_cost: list[Obstacle] = []
    for test, solver in setup.solvers.items():
        try:
            # Before the check, so that it is shown even if the check fails.
            executes += [f"test {test}: {line}" for line in solver.executes()]
            solver.check()
            lines.append(f"Test {test}: {solver.readiness()}")
        except GrainfitError:
            # One of the obstacles.
            continue
        try:
            if call_scenes or not is_of_user(solver.bulk_test):
                lines += _cost_lines(solver, setup.problem)
        except GrainfitError as error:
            without_cost.append(Obstacle(test, error))
    found = [*obstacles(setup.problem, setup.solvers)]
    refused = {obstacle.test for obstacle in found}
    found += [obstacle for obstacle in without_cost if obstacle.test not in refused]
    problems += chain(*(_words(setup, obstacle) for obstacle in found))
    for test, values in apparatus.items():
        lines += apparatus_lines(test, values)
    lines += _relative_lines(setup)
    lines += _twin_lines(setup)
    _add_holdouts(setup, call_scenes, lines, executes, problems)
    lines += chosen_model_lines(setup.file)
    lines += setup.file.measured_angles.values()
    lines += [f"Table {line}." for line in setup.file.tables]
    lines += chain(*(one.lines() for one in setup.file.photographs))
    lines += size_lines(setup.file.sizes, setup.bulk_tests, _middle(setup))
    lines += cohesion_lines(setup.file, setup.bulk_tests)
    lines += _rayleigh_lines(setup)
    cluster = setup.cluster or setup.file.cluster
    if cluster is not None:
        lines += describe_cluster(cluster)
        executes += [f"cluster: {line}" for line in executed_by(cluster)]
    runs: ExpectedRuns | None = None
    time: RunTime | None = None
    costs: dict[str, float] = {}
    try:
        with with_lines(setup.file.path):
            runs = _expected_runs(setup)
        if call_scenes or not any(is_of_user(one.bulk_test) for one in setup.solvers.values()):
            costs = costs_of_runs(setup.problem, setup.simulated)
            time = run_time(runs, costs, setup.repeats, setup.workers)
        lines += _run_lines(setup, runs, time)
    except InputError as error:
        where = f"{error.source}: " if error.source else ""
        problems += [f"{where}{fault}" for fault in error.faults]
    context = context_of(setup.file, setup.problem, setup.solvers, costs, time)
    return Plan(
        setup.name,
        setup.problem.parameters,
        setup.problem.targets,
        setup.problem.curves,
        tuple(lines),
        tuple(executes),
        with_key_lines(setup.file.path, findings(context)),
        tuple(problems),
        time.seconds if time else None,
        apparatus,
        runs.total if runs else None,
    )


def _add_holdouts(
    setup: CalibrationSetup,
    call_scenes: bool,
    lines: list[str],
    executes: list[str],
    problems: list[str],
) -> None:
    """Add what hold-outs simulate and execute, and what keeps them from it."""
    for holdout in setup.holdouts:
        try:
            model = holdout.model
            executes += [f"hold-out {holdout.name}: {line}" for line in model.executes()]
            require_holdouts(setup.problem, setup.solvers, [holdout])
            if call_scenes or not is_of_user(model.bulk_test):
                lines.append(holdout_line(holdout, setup.problem, setup.workers))
        except GrainfitError as error:
            problems += _words(setup, Obstacle("", error))


def _words(setup: CalibrationSetup, obstacle: Obstacle) -> list[str]:
    if not isinstance(obstacle.error, InputError):
        return [f"Test {obstacle.test}: {obstacle.error}"]
    test = f"test {obstacle.test}" if obstacle.test else ""
    path, source = setup.file.path, obstacle.error.source
    faults: Sequence[Fault] = [
        replace(fault, key=", ".join(filter(None, (test, fault.key))))
        for fault in obstacle.error.faults
    ]
    if not source:
        faults = faults_with_lines(path, faults)
    return [f"{source or path}: {fault}" for fault in faults]


def _middle(setup: CalibrationSetup) -> dict[str, float]:
    """Return all parameters in the middle of their intervals."""
    problem = setup.problem
    return {**setup.file.fixed, **problem.middle}


def _correlation_lines(problem: Problem) -> Iterator[str]:
    pairs = [f"{first} and {second} {value:g}" for first, second, value in problem.correlations]
    if pairs:
        yield messages.CORRELATIONS(pairs="; ".join(pairs))


def _rayleigh_lines(setup: CalibrationSetup) -> Iterator[str]:
    problem = setup.problem
    if problem.rayleigh is not None:
        smallest, largest = problem.rayleigh.limits(problem.intervals)
        yield messages.RAYLEIGH_TIME_STEP(smallest=smallest, largest=largest)
    elif missing := setup.missing_for_time_step:
        verb = "is" if len(missing) == 1 else "are"
        yield messages.NO_RAYLEIGH_TIME_STEP(missing=in_a_row(missing), verb=verb)


def _cost_lines(solver: Solver, problem: Problem) -> Iterator[str]:
    cost = solver.estimate_cost(problem.middle)
    if cost is not None:
        yield f"  {messages.COST_IN_THE_MIDDLE(cost=cost)}"
    test = solver.bulk_test
    if test is not None and test.sizes.coarse_graining != 1:
        yield f"  {messages.PARTICLES_ARE_ENLARGED(factor=test.sizes.coarse_graining)}"


def _relative_lines(setup: CalibrationSetup) -> Iterator[str]:
    for relative in setup.relative_costs:
        yield messages.PART_OF_SEARCH(
            test=relative.of,
            what=what_differs(setup.strategy),
            share=100 * (relative.cost or 0.0),
        )


def _twin_lines(setup: CalibrationSetup) -> Iterator[str]:
    if setup.strategy.twins is None:
        return
    if not setup.twins:
        yield messages.ALL_SMALL(twins=setup.strategy.twins)
        return
    found = first_twins(setup.solvers, setup.twins, setup.problem)
    tests = in_a_row(f"{one.test} ({one.simulated:,} particles)" for one in found.tests)
    real = in_a_row(map(str, found.tests))
    yield messages.TWINS_SIMULATED(tests=tests, real=real)


def _expected_runs(setup: CalibrationSetup) -> ExpectedRuns:
    problem = replace(setup.problem, relatives=setup.relative_costs)
    runs = expected_runs(setup.file, problem, setup.solvers)
    if not setup.twins:
        return runs
    return replace(runs, series=series_of_sizes(setup.solvers, setup.twins, setup.problem))


def _run_lines(setup: CalibrationSetup, runs: ExpectedRuns, time: RunTime | None) -> Iterator[str]:
    yield messages.DEM_RUNS(runs=runs, workers=setup.workers)
    if runs.guided:
        yield GUIDED_BY_ATLAS(tests=in_a_row(runs.guided))
    if runs.series is not None:
        yield messages.RUNS_WITH_SIZES(
            series=runs.series,
            time=duration(runs.series.seconds / setup.workers),
            low=runs.total[0],
            high=runs.total[1],
        )
    if time is not None:
        yield messages.TIME_OF_RUNS(time=time)
    for test, count in setup.repeats.items():
        if count > 1:
            yield messages.REPEATS(test=test, count=count)


def holdout_line(holdout: Holdout, problem: Problem, workers: int) -> str:
    """Return what will be simulated of a hold-out after the verdict."""
    cost = holdout.model.estimate_cost(problem.middle)
    time = "" if cost is None else f", about {duration(holdout.runs * cost.wall_seconds / workers)}"
    known = messages.HOLDOUT_MEASURED if holdout.measured else messages.HOLDOUT_UNMEASURED
    return messages.HOLDOUT_LINE(
        test=holdout.name,
        runs=counted(holdout.runs, "run"),
        at_answer=HOLDOUT.answer_seeds * holdout.repeats,
        time=time,
        measured=known(),
    )


def size_lines(
    sizes: ParticleSizes | None, bulk_tests: Mapping[str, BulkTest], material: Mapping[str, float]
) -> Iterator[str]:
    """Yield the particle sizes and the price of the finest ones, in words.

    Parameters
    ----------
    sizes : ParticleSizes, optional
        Of the particles; nothing is yielded for a single diameter.
    bulk_tests : mapping of str to BulkTest
        Simulated tests by name.
    material : mapping of str to float
        Material parameters by dotted name, in the middle of their intervals.
    """
    if sizes is None or len(sizes.diameters) == 1:
        return
    if sizes.origin is not None:
        yield from sizes.origin.describe(sizes.real)
    tests = [test for test in bulk_tests.values() if not is_of_user(test)]
    if tests:
        yield from _price(sizes, tests, material)


def _price(
    sizes: ParticleSizes, tests: list[BulkTest], material: Mapping[str, float]
) -> Iterator[str]:
    try:
        whole = _seconds(tests, material)
        finest = min(range(len(sizes.diameters)), key=lambda i: sizes.diameters[i])
        share = _seconds(_with_sizes(tests, sizes.without(finest)), material) / whole
        if share > _HARDLY_FASTER:
            return
        finest_class = messages.FINEST_CLASS(
            diameter=millimetres(sizes.real.diameters[finest]),
            mass=percent(sizes.mass_fractions[finest]),
            particles=percent(sizes.number_fractions[finest]),
            share=share,
        )
        yield f"  {finest_class}"
        if sizes.origin is not None:
            limit, rest = sizes.origin.without_finest(_FINEST)
            rest = replace(rest, shape=sizes.shape).coarse_grained(sizes.coarse_graining)
            share = _seconds(_with_sizes(tests, rest), material) / whole
            without_finest = messages.WITHOUT_FINEST(
                smallest=1000 * limit,
                which="another" if sizes.origin.is_cut_below else "the finest",
                mass=percent(_FINEST),
                share=share,
            )
            yield f"  {without_finest}"
    except InputError:
        # A test that is impossible with other sizes has no price.
        return


def _with_sizes(tests: list[BulkTest], sizes: ParticleSizes) -> list[BulkTest]:
    return [test.with_sizes(sizes) for test in tests]


def _seconds(tests: list[BulkTest], material: Mapping[str, float]) -> float:
    """Return the estimated time of a run of each test; only ratios have a meaning."""
    return sum(_ANY_SPEED.cost(workload(test, material)).wall_seconds for test in tests)
