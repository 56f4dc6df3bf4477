"""Find out which free parameters each of several tests depends on, and pass it only these."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from grainfit.bulk_tests.abilities import is_of_user
from grainfit.calibration import messages
from grainfit.errors import GrainfitError, InputError
from grainfit.evaluation import response_name
from grainfit.problem import Problem, TestScope
from grainfit.solvers.base import Solver
from grainfit.solvers.parameters_for import AllBut, ParametersFor


def with_scopes(
    problem: Problem, solvers: Mapping[str, Solver], repeats: Mapping[str, int] | None = None
) -> Problem:
    """Return the problem with the scope of each test; unchanged for a single test.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets; the scopes of a problem that has some are kept.
    solvers : mapping of str to Solver
        By name of the test.
    repeats : mapping of str to int, optional
        Runs with different seeds whose mean is one evaluation, by name of the test; by default
        those of the problem's scopes.

    Raises
    ------
    InputError
        The scopes of the problem are not those of the tests.
    """
    repeats = repeats or {}
    if problem.tests:
        _require_scopes(problem, solvers)
        scopes = [replace(s, repeats=repeats.get(s.name, s.repeats)) for s in problem.tests]
        return replace(problem, tests=scopes)
    if len(solvers) < 2 and not problem.relatives:
        return problem
    used = used_parameters(problem, solvers)
    if not all(used.values()):
        # The check before the first run refuses a test that depends on no free parameter.
        return problem
    targets: dict[str, list[str]] = {test: [] for test in solvers}
    for name in problem.responses:
        if test := _test_of(name, solvers):
            targets[test].append(name)
    return replace(
        problem,
        tests=[
            TestScope(
                test, targets[test], used[test], _seconds(problem, solver), repeats.get(test, 1)
            )
            for test, solver in solvers.items()
            if targets[test]
        ],
    )


def repeats_of(
    problem: Problem, solvers: Mapping[str, Solver], repeats: Mapping[str, int]
) -> dict[str, int]:
    """Return the runs per evaluation of every test: as given, or else those of its scope."""
    stated = {scope.name: scope.repeats for scope in problem.tests}
    return {test: repeats.get(test, stated.get(test, 1)) for test in solvers}


def relatives_of(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, Solver]:
    """Return the solvers of the relatives of tests by the names of their runs.

    Parameters
    ----------
    problem : Problem
        Problem with the scopes of its tests.
    solvers : mapping of str to Solver
        Solvers of the relatives by name of the test.

    Raises
    ------
    InputError
        A solver is missing, or there is one that the problem does not declare.
    """
    declared = {one.of: one for one in problem.relatives}
    known = ", ".join(solvers) or "none"
    faults = [
        messages.RELATIVE_WITHOUT_SOLVER.fault(test, tests=known)
        for test in declared
        if test not in solvers
    ]
    faults += [messages.NO_RELATIVE.fault(test) for test in solvers if test not in declared]
    InputError.raise_for(faults)
    return {
        one.name: _ready(problem, solvers[test], problem.scope_of_test(test).parameters)
        for test, one in declared.items()
    }


def _require_scopes(problem: Problem, solvers: Mapping[str, Solver]) -> None:
    unknown = [scope.name for scope in problem.tests if scope.name not in solvers]
    if unknown:
        known = ", ".join(solvers)
        raise InputError(
            [messages.TEST_WITHOUT_SOLVER.fault(name, tests=known) for name in unknown]
        )
    targets = {target for scope in problem.tests for target in scope.targets}
    missing = [name for name in problem.responses if name not in targets]
    if missing:
        raise InputError([messages.TARGET_WITHOUT_TEST.fault(name) for name in missing])


def used_parameters(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, Sequence[str]]:
    """Return the free parameters that each test depends on, by its name."""
    names = [parameter.name for parameter in problem.parameters]
    stated = {scope.name: scope.parameters for scope in problem.tests}
    return {
        test: solver.depends_on([name for name in names if name in stated.get(test, names)])
        for test, solver in solvers.items()
    }


def restricted(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, Solver]:
    """Return solvers for a problem, passed none of the parameters that only other tests depend on.

    So the runs of a test are the same, and have the same identity, at all values of these.
    """
    if len(solvers) < 2:
        return {test: _ready(problem, one, problem.intervals) for test, one in solvers.items()}
    used = used_parameters(problem, solvers)
    return {test: _ready(problem, solvers[test], names) for test, names in used.items()}


def restricted_to_used(problem: Problem, solver: Solver) -> tuple[Problem, Solver]:
    """Return the problem of the parameters that a solver depends on, and the solver for them.

    Raises
    ------
    InputError
        It depends on none.
    """
    names = [parameter.name for parameter in problem.parameters]
    used = solver.depends_on(names)
    if not used:
        raise InputError(messages.IDLE_TEST.fault(""))
    kept = [parameter for parameter in problem.parameters if parameter.name in used]
    without = Problem(kept, problem.targets, curves=problem.curves)
    return without, _ready(problem, solver, used)


def _test_of(target: str, tests: Collection[str]) -> str:
    """Return the test of a target, ``test.response``; empty if there is none."""
    found = [test for test in tests if target.startswith(response_name(test, "", len(tests)))]
    return max(found, key=len, default="")


def _ready(problem: Problem, solver: Solver, used: Iterable[str]) -> Solver:
    """Return a solver for the intervals of a problem, passed none of the parameters not used."""
    ready, unused = solver.within(problem.intervals), problem.intervals.keys() - set(used)
    return ParametersFor(ready, takes=AllBut(frozenset(unused))) if unused else ready


def _seconds(problem: Problem, solver: Solver) -> float | None:
    if is_of_user(solver.bulk_test):
        # The cost is that of a scene of the user, and loading a file executes none of his code.
        return None
    try:
        cost = solver.estimate_cost(problem.middle)
    except GrainfitError:
        # The check before the first run says what is wrong.
        return None
    return cost.wall_seconds if cost is not None and cost.wall_seconds > 0 else None
