"""What a further measurement would settle: its expected narrowing, by the atlas alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grainfit.atlas.forecast import Forecast
from grainfit.atlas.shelf import Atlas
from grainfit.bulk_tests.abilities import options_for
from grainfit.bulk_tests.accuracy import Accuracy, usual_accuracy
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.errors import InputError
from grainfit.problem import Problem, Target
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.program import DeckSolver

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FurtherMeasurement:
    """A measurement that was not made, in the usual apparatus.

    Parameters
    ----------
    test, response : str
        What would be measured.
    accuracy : Accuracy
        With which a laboratory usually measures it.
    left : mapping of str to float
        Expected width of the interval of every free parameter, over the present one.
    """

    test: str
    response: str
    accuracy: Accuracy
    left: Mapping[str, float]


def further_measurements(
    problem: Problem, solvers: Mapping[str, Solver], points: Array, atlas: Atlas
) -> list[FurtherMeasurement]:
    """Return the measurements of which the atlas tells that were not made.

    A response that correlates with a parameter over the present sample narrows it by as much as a
    linear regression explains beside the errors of measurement and atlas.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test.
    points : ndarray, shape (m, d)
        An even sample of the present knowledge, in the unit cube.
    atlas : Atlas
        The atlas.
    """
    known = [one for one in solvers.values() if isinstance(one, DeckSolver)]
    if not known:
        return []
    made = {
        (solver.bulk_test.type, target.name.removeprefix(f"{name}."))
        for name, solver in solvers.items()
        if solver.bulk_test is not None
        for target in problem.targets
    }
    found: list[FurtherMeasurement] = []
    for test in atlas.tests:
        found += _of_test(test, made, problem, known[0], points, atlas)
    return found


def _of_test(
    test: str,
    made: set[tuple[str, str]],
    problem: Problem,
    solver: DeckSolver,
    points: Array,
    atlas: Atlas,
) -> Iterator[FurtherMeasurement]:
    kind = bulk_tests()[test]
    names = [name for name in kind.responses if (test, name) not in made]
    forecast = _forecast(test, names, problem, solver, atlas)
    if forecast is None or forecast.problem is None:
        return
    means, variances = forecast.predict(points)
    for axis, target in enumerate(forecast.problem.targets):
        accuracy = usual_accuracy(target.name, kind.responses[target.name].unit)
        values = means[:, axis]
        error = accuracy.of(float(values.mean())) ** 2 + float(variances[:, axis].mean())
        total = float(values.var()) + error
        left = {
            parameter.name: math.sqrt(max(1 - _explained(points[:, j], values, total), 0.0))
            for j, parameter in enumerate(problem.parameters)
        }
        yield FurtherMeasurement(test, target.name, accuracy, left)


def _forecast(
    test: str, names: Sequence[str], problem: Problem, solver: DeckSolver, atlas: Atlas
) -> Forecast | None:
    """Return predictions for the usual apparatus; None where there is none for the particles."""
    kind = bulk_tests()[test]
    if not names:
        return None
    try:
        material = {**solver.material, **problem.middle}
        apparatus = kind(solver.test.sizes, **options_for(kind, material))
        candidate = type(solver)(apparatus, solver.material)
        targets = [Target(name, 1.0, uncertainty=1.0) for name in names]
        return Forecast(Problem(problem.parameters, targets), {test: candidate}, atlas)
    except InputError:
        return None


def _explained(parameter: Array, values: Array, total: float) -> float:
    """Return the share of a parameter's variance that a measurement explains."""
    variance = float(parameter.var())
    if variance == 0:
        return 0.0
    together = float(np.mean((parameter - parameter.mean()) * (values - values.mean())))
    return together**2 / (variance * total)
