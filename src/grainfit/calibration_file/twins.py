"""Twins of the tests of a calibration file, and their first ratios."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from grainfit.analysis.recorded_size import change_of_size
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.size import CanBeResized, growth, resized, size_power
from grainfit.calibration.twins import SizeRatio, Twins
from grainfit.calibration_file import messages
from grainfit.calibration_file.content import CalibrationFile
from grainfit.calibration_file.relatives import relative_keys
from grainfit.calibration_file.run_time import SizeSeries
from grainfit.errors import Fault, GrainfitError, InputError
from grainfit.problem import Problem, Target
from grainfit.solvers.base import Solver
from grainfit.verdict.reasons import RealTest

_KEY = "strategy.twins"
#: Sizes at an answer, over that of a twin, and runs of each.
_SIZES, SEEDS = (1.0, 1.75, 3.0), 3
#: Most series of sizes.
MOST_SERIES = 3
#: Standard error of a ratio: of a recorded change its share, at least; where none is recorded.
_SHARE_OF_CHANGE, _LEAST, _UNKNOWN = 0.5, 0.02, 0.1


def twin_solvers(
    file: CalibrationFile, solvers: Mapping[str, Solver], problem: Problem
) -> dict[str, Solver]:
    """Return the solvers of the twins, by name of the test; none unless the file asks.

    Raises
    ------
    InputError
        There are relatives as well, a test has no size, or a response cannot be compared.
    """
    particles = file.strategy.twins
    if particles is None:
        return {}
    if keys := relative_keys(file.strategy):
        raise InputError(messages.TWINS_AND_RELATIVES.fault(_KEY, keys=", ".join(keys)))
    found: dict[str, Solver] = {}
    faults: list[Fault] = []
    for name, solver in solvers.items():
        try:
            if (twin := _twin(solver, particles)) is not None:
                faults += _incomparable(name, solver, problem)
                found[name] = solver.of_test(twin)
        except InputError as error:
            faults.append(messages.NO_TWIN.fault(_KEY, test=name, why=error.reasons))
    InputError.raise_for(faults)
    return found


def first_twins(
    solvers: Mapping[str, Solver], twins: Mapping[str, Solver], problem: Problem
) -> Twins:
    """Return the twins with ratios by recorded trials of rough spheres, where there are some.

    Parameters
    ----------
    solvers, twins : mapping of str to Solver
        Of the tests, and of those that have a twin.
    problem : Problem
        Parameters and targets.
    """
    ratios = {
        target.name: _first_ratio(_test_of(solvers[name]), _test_of(twin), short, target)
        for name, twin in twins.items()
        for short, target in problem.targets_of(name).items()
    }
    tests = tuple(
        RealTest(
            name,
            _test_of(solvers[name]).number_of_particles,
            _test_of(twin).number_of_particles,
            _seconds(solvers[name], problem),
        )
        for name, twin in twins.items()
    )
    return Twins(ratios, tests)


def sizes_at_answer(test: BulkTest, twin: BulkTest) -> list[float]:
    """Return the sizes of a series, by number of particles over that of the test.

    The twin's is the smallest; none is as large as the test itself.
    """
    share = twin.number_of_particles / test.number_of_particles
    sizes = [share * size for size in _SIZES if share * size < 1]
    return sizes if len(sizes) > 1 else [share, math.sqrt(share)]


def series_of_sizes(
    solvers: Mapping[str, Solver], twins: Mapping[str, Solver], problem: Problem
) -> SizeSeries:
    """Return the number of runs of the sizes at one answer, and their estimated time.

    Parameters
    ----------
    solvers, twins, problem
        As of `first_twins`.
    """
    seconds = [
        SEEDS * solver.estimate_cost_of(resized(test, size), material).wall_seconds
        for name, twin in twins.items()
        for solver in [solvers[name]]
        for test in [_test_of(solver)]
        for material in [solver.run_parameters(problem.middle)]
        for size in sizes_at_answer(test, _test_of(twin))
    ]
    return SizeSeries(SEEDS * len(seconds), sum(seconds), MOST_SERIES)


def has_twin(test: BulkTest | None, particles: int | None) -> bool:
    """Return whether a test holds more than a number of particles, where one is given."""
    return test is not None and particles is not None and test.number_of_particles > particles


def _twin(solver: Solver, particles: int) -> BulkTest | None:
    test = solver.bulk_test
    if test is None:
        raise InputError(Fault("", messages.UNKNOWN_SIZE()))
    if not has_twin(test, particles):
        return None
    return resized(test, particles / test.number_of_particles)


def _incomparable(name: str, solver: Solver, problem: Problem) -> Iterator[Fault]:
    test = _test_of(solver)
    for short, target in problem.targets_of(name).items():
        if size_power(test, short) is None:
            why = messages.NOT_COMPARED(response=target.name)
            yield messages.NO_TWIN.fault(_KEY, test=name, why=why)
    for curve in problem.curves:
        if not problem.tests or problem.scope_of(curve.name).name == name:
            why = messages.CURVE_OF_TWIN(curve=curve.name)
            yield messages.NO_TWIN.fault(_KEY, test=name, why=why)


def _first_ratio(test: BulkTest, twin: BulkTest, response: str, target: Target) -> SizeRatio:
    count = twin.number_of_particles
    change = change_of_size(test, response, count)
    grown = growth(test, response, count / test.number_of_particles)
    size = max(abs(target.value), target.tolerance)
    if change is None:
        return SizeRatio(1 / grown, _UNKNOWN * size)
    error = max(_SHARE_OF_CHANGE * abs(change), _LEAST)
    return SizeRatio(1 / (grown * (1 + change)), error * size)


def _test_of(solver: Solver) -> BulkTest:
    test = solver.bulk_test
    assert isinstance(test, BulkTest), "only bulk tests have twins"
    assert isinstance(test, CanBeResized), "only tests with a size have twins"
    return test


def _seconds(solver: Solver, problem: Problem) -> float | None:
    try:
        cost = solver.estimate_cost(problem.middle)
    except GrainfitError:
        return None
    return None if cost is None else cost.wall_seconds
