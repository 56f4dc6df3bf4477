"""Check that a calibration can run, before its first run: `check` and `run` say the same."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from grainfit.bulk_tests.abilities import CurveRange, curve_range
from grainfit.bulk_tests.response_info import CurveInfo
from grainfit.calibration import messages
from grainfit.errors import Fault, GrainfitError, InputError
from grainfit.evaluation import response_name
from grainfit.formatting import in_a_row, unit_for_people, with_unit
from grainfit.options.places import Findings, Place
from grainfit.problem import CurveTarget, Problem, Target
from grainfit.solvers.base import Solver
from grainfit.units import how_to_write, is_same_unit


@dataclass(frozen=True)
class Obstacle:
    """Reason why a calibration cannot run.

    Parameters
    ----------
    test : str
        Name of the test; empty when it is none of a single test.
    error : GrainfitError
        The reason.
    """

    test: str
    error: GrainfitError


def require_ready(problem: Problem, solvers: Mapping[str, Solver]) -> None:
    """Raise the first reason why a calibration cannot run, see `obstacles`."""
    for obstacle in obstacles(problem, solvers):
        error = obstacle.error
        if isinstance(error, InputError) and len(solvers) > 1 and obstacle.test:
            faults = [replace(f, key=f"test {obstacle.test}, {f.key}") for f in error.faults]
            raise InputError(faults, error.source) from error
        raise error


def obstacles(problem: Problem, solvers: Mapping[str, Solver]) -> Iterator[Obstacle]:
    """Yield every reason why a calibration cannot run; starts no simulation."""
    if faults := _faults_of_targets(problem, solvers):
        yield Obstacle("", InputError(faults))
    refused = False
    for test, solver in solvers.items():
        for obstacle in _of_solver(test, solver, problem):
            refused = True
            yield obstacle
        faults = _faults_of_measured(test, solver, problem, len(solvers))
        faults += _faults_of_curves(test, solver, problem, len(solvers))
        if faults:
            yield Obstacle(test, InputError(faults))
    # The only test of a calibration has said what it does not depend on.
    if (len(solvers) > 1 or not refused) and (faults := _faults_of_parameters(problem, solvers)):
        yield Obstacle("", InputError(faults))


def _of_solver(test: str, solver: Solver, problem: Problem) -> Iterator[Obstacle]:
    if faults := solver.interval_faults(problem.intervals):
        yield Obstacle(test, InputError(faults))
    try:
        solver.check()
        # Every run reads its parameters like this; a solver refuses here what it cannot use.
        solver.run_parameters(problem.middle)
    except GrainfitError as error:
        yield Obstacle(test, error)


def _faults_of_targets(problem: Problem, solvers: Mapping[str, Solver]) -> list[Fault]:
    known: set[str] = set()
    for test, solver in solvers.items():
        if solver.response_names is None:
            return []
        known |= {response_name(test, name, len(solvers)) for name in solver.response_names}
    return [
        messages.TARGET_NOBODY_YIELDS.fault(name, responses=", ".join(sorted(known)))
        for name in problem.responses
        if name not in known
    ]


def _faults_of_measured(test: str, solver: Solver, problem: Problem, tests: int) -> list[Fault]:
    if solver.bulk_test is None:
        return []
    known = (*solver.bulk_test.responses, *solver.bulk_test.curves)
    names = {response_name(test, name, tests): name for name in known}
    measured: Sequence[Target | CurveTarget] = (*problem.targets, *problem.curves)
    return [*measured_faults(solver, {names[m.name]: m for m in measured if m.name in names})]


def measured_faults(
    solver: Solver, measured: Mapping[str, Target | CurveTarget]
) -> Iterator[Fault]:
    """Yield a fault for every unit, and for every number, that a bulk test cannot yield.

    Parameters
    ----------
    solver : Solver
        Of the test; what models of the user yield has no known unit.
    measured : mapping of str to Target or CurveTarget
        By name of the response in the test.
    """
    test = solver.bulk_test
    for name, target in measured.items():
        if isinstance(target, CurveTarget):
            curve = test.curves.get(name) if test is not None else None
            if curve is not None:
                yield from _faults_of_unit(name, target.unit, curve.unit)
                key = f"{name}.coordinate_unit"
                yield from _faults_of_unit(key, target.coordinate_unit, curve.coordinate_unit)
        elif test is not None and name in test.responses:
            yield from _faults_of_unit(name, target.unit, test.responses[name].unit)
            findings = Findings()
            test.responses[name].possible.read(target.value, Place(findings, (name,)))
            yield from findings.faults


def _faults_of_unit(key: str, unit: str, known: str) -> Iterator[Fault]:
    if unit and not is_same_unit(unit, known):
        yield messages.OTHER_UNIT.fault(key, unit=unit, remedy=how_to_write(known))


def _faults_of_curves(test: str, solver: Solver, problem: Problem, tests: int) -> list[Fault]:
    if solver.bulk_test is None:
        return []
    names = {response_name(test, name, tests): name for name in solver.bulk_test.curves}
    return [
        fault
        for curve in problem.curves
        if curve.name in names
        for fault in (
            *_faults_of_values(names[curve.name], curve, solver.bulk_test.curves),
            *_faults_of_curve(
                names[curve.name], curve, curve_range(solver.bulk_test, names[curve.name])
            ),
        )
    ]


def _faults_of_values(
    name: str, curve: CurveTarget, known: Mapping[str, CurveInfo]
) -> Iterator[Fault]:
    """Yield the first value that is physically impossible; of a file, its line was named before."""
    found = known[name].impossible_point(curve.values)
    if found is not None:
        position, fault = found
        yield replace(fault, key=f"{name}, point {position + 1}")


def _faults_of_curve(name: str, curve: CurveTarget, known: CurveRange) -> Iterator[Fault]:
    first, last = curve.coordinates[0], curve.coordinates[-1]
    unit = unit_for_people(curve.coordinate_unit)
    # Roundings of the last digits are no points beyond: runs are read with the same slack.
    slack = 1e-9 * (last - first)
    beyond: list[str] = []
    needed: dict[str, float] = {}
    if first < known.low - slack:
        beyond.append(with_unit(f"below {known.low:.12g}", unit))
        # What reaches as far to both sides has one option for them.
        if first > 0 or known.low_option == known.high_option:
            needed[known.low_option] = abs(first)
    if last > known.high + slack:
        beyond.append(with_unit(f"above {known.high:.12g}", unit))
        needed[known.high_option] = max(abs(last), needed.get(known.high_option, 0.0))
    if not beyond:
        return
    change = [
        f'{option} = "{with_unit(f"{value:.12g}", curve.coordinate_unit)}"'
        for option, value in needed.items()
        if option
    ]
    yield messages.CURVE_BEYOND_RUNS.fault(
        name,
        first=first,
        last=with_unit(f"{last:.6g}", unit),
        beyond=in_a_row(beyond),
        change=f"Set {in_a_row(change)}, leave" if change else "Leave",
    )


def _faults_of_parameters(problem: Problem, solvers: Mapping[str, Solver]) -> list[Fault]:
    names = [parameter.name for parameter in problem.parameters]
    used = {test: solver.depends_on(names) for test, solver in solvers.items()}
    idle = [test for test, found in used.items() if not found]
    unused = set(names).difference(*used.values())
    if not unused and idle:
        return [messages.IDLE_TEST.fault(test) for test in idle]
    return [messages.IDLE_PARAMETER.fault(name) for name in names if name in unused]
