"""Cheaper relatives of the tests of a calibration file: softer, larger or fewer particles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from grainfit.bulk_tests.abilities import is_of_user
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import coarse_grained
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.bulk_tests.size import resized
from grainfit.calibration_file import messages
from grainfit.calibration_file.content import CalibrationFile, SearchOptions
from grainfit.errors import InputError
from grainfit.formatting import in_a_row, number
from grainfit.problem import Problem, Relative
from grainfit.solvers.base import Solver
from grainfit.solvers.registry import types_of_test

#: Largest cost of a relative, in runs of its test: dearer ones are no help.
_DEAREST = 0.9


def relative_keys(strategy: SearchOptions) -> list[str]:
    """Return the keys of ``[strategy]`` that ask for relatives."""
    return [name for name in ("softer", "coarser", "smaller") if getattr(strategy, name)]


def relative_solvers(
    file: CalibrationFile, build: Callable[[CalibrationFile], dict[str, Solver]], problem: Problem
) -> dict[str, Solver]:
    """Return the solvers of the relatives of all simulated tests; none unless the file asks.

    Parameters
    ----------
    file : CalibrationFile
        The calibration file.
    build : callable
        Builds the solvers of a file.
    problem : Problem
        Its free parameters.

    Raises
    ------
    InputError
        Young's modulus is free or not higher than the softer one, no test is simulated, or one is
        impossible with softer, larger or fewer particles.
    """
    keys = relative_keys(file.strategy)
    if not keys:
        return {}
    chosen = [test for test in file.tests if types_of_test()[test.type].bulk_test is not None]
    if not chosen:
        raise InputError(messages.NO_TEST_HAS_RELATIVES.fault(f"strategy.{keys[0]}"))
    fixed = _softened(file)
    softer = {
        test.name: _softer(replace(file, fixed=fixed, tests=(test,)), build) for test in chosen
    }
    return {name: _changed(file.strategy, name, one, problem) for name, one in softer.items()}


def relatives_of(
    solvers: Mapping[str, Solver], relatives: Mapping[str, Solver], problem: Problem
) -> list[Relative]:
    """Return the relatives with their cost, by the estimated computing time of a run.

    Parameters
    ----------
    solvers, relatives : mapping of str to Solver
        Of the tests, and of their relatives.
    problem : Problem
        Its free parameters.
    """
    return [
        Relative(name, min(_DEAREST, _seconds(solver, problem) / _seconds(solvers[name], problem)))
        for name, solver in relatives.items()
    ]


def what_differs(strategy: SearchOptions) -> str:
    """Return what is different in the relatives, as a part of a sentence."""
    found = []
    if strategy.softer:
        found.append("softer particles")
    if strategy.coarser:
        found.append(f"particles {number(strategy.coarser, 3)} times as large")
    if strategy.smaller:
        found.append(
            f"{number(100 * strategy.smaller, 3)} % of the particles in a smaller apparatus"
        )
    return in_a_row(found)


def _softened(file: CalibrationFile) -> dict[str, float]:
    """Return the fixed parameters with the softer modulus."""
    softer, stiff = file.strategy.softer, file.fixed.get(MODULUS)
    if softer is None:
        return dict(file.fixed)
    names = [*file.fixed, *(parameter.name for parameter in file.parameters)]
    if given := [name for name in names if name.endswith(".normal_stiffness")]:
        raise InputError(messages.GIVEN_STIFFNESS.fault("strategy.softer", name=given[0]))
    if stiff is None:
        raise InputError(messages.FREE_MODULUS.fault("strategy.softer"))
    if softer >= stiff:
        modulus = number(stiff / 1e6, 3)
        raise InputError(messages.NOT_SOFTER.fault("strategy.softer", modulus=modulus))
    return {**file.fixed, MODULUS: softer}


def _softer(file: CalibrationFile, build: Callable[[CalibrationFile], dict[str, Solver]]) -> Solver:
    """Return the solver of a file of one test, which is possible with the modulus of the file."""
    [test] = file.tests
    try:
        return build(file)[test.name]
    except InputError as error:
        # Their keys and lines are those of the modulus of the file.
        why = "; ".join(fault.message for fault in error.faults)
        raise _impossible("softer", test.name, why) from None


def _impossible(key: str, test: str, why: str) -> InputError:
    return InputError(messages.NO_SUCH_RELATIVE.fault(f"strategy.{key}", test=test, why=why))


def _changed(strategy: SearchOptions, name: str, solver: Solver, problem: Problem) -> Solver:
    test = solver.bulk_test
    assert test is not None, "only bulk tests have relatives"
    if strategy.coarser is None and strategy.smaller is None:
        return solver
    key = "smaller" if strategy.smaller else "coarser"
    if is_of_user(test):
        raise InputError(messages.OWN_SCENE_HAS_NO_SIZE.fault(f"strategy.{key}", test=name))
    try:
        return solver.of_test(_resized(strategy, test, solver.run_parameters(problem.middle)))
    except InputError as error:
        raise _impossible(key, name, error.reasons) from None


def _resized(strategy: SearchOptions, test: BulkTest, material: Mapping[str, float]) -> BulkTest:
    found = test if strategy.smaller is None else resized(test, strategy.smaller)
    return found if strategy.coarser is None else coarse_grained(found, strategy.coarser, material)


def _seconds(solver: Solver, problem: Problem) -> float:
    cost = solver.estimate_cost(problem.middle)
    assert cost is not None, "bulk tests have a known cost"
    return cost.wall_seconds
