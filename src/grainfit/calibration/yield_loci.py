"""Yield loci of a calibration: lines through its shear tests at several normal stresses."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from grainfit.bulk_tests.abilities import locus_point
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import recreate_test
from grainfit.campaign.store.records import RunRecord
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Response, name_of_test, response_name
from grainfit.measurement.yield_locus import fit_yield_locus
from grainfit.problem import Problem
from grainfit.result import ResponseResult, YieldLocus, YieldLocusResult
from grainfit.run_definition import RunDefinition

#: Largest normal stress over the smallest from which on there is a line: nearer ones tell nothing
#: of its slope.
_LEAST_RATIO = 1.01


@dataclass(frozen=True, order=True)
class _Point:
    """A shear test of a calibration, with the place of its angle among the targets."""

    normal_stress: float
    test: str
    place: int


def tests_of_runs(
    evaluations: Iterable[Evaluation], find: Callable[[Collection[str]], Mapping[str, RunRecord]]
) -> dict[str, RunDefinition]:
    """Return a run of each test that has one, by its name.

    Parameters
    ----------
    evaluations : iterable of Evaluation
        Those of a calibration.
    find : callable
        Returns the records of runs by their identities.
    """
    runs = {name_of_test(name): run for e in evaluations for name, run in e.runs.items()}
    records = find(runs.values())
    return {test: records[run].definition for test, run in runs.items() if run in records}


def yield_loci(
    problem: Problem,
    tests: Mapping[str, RunDefinition],
    responses: Mapping[str, ResponseResult],
) -> tuple[YieldLocusResult, ...]:
    """Return the yield loci by the targets, and by the responses expected at the answer.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    tests : mapping of str to RunDefinition
        A run of each test of the calibration, by its name: see `tests_of_runs`.
    responses : mapping of str to ResponseResult
        Responses at the answer; empty without one.

    Returns
    -------
    tuple of YieldLocusResult
        One for each material with two or more normal stresses.
    """
    materials: dict[Hashable, list[_Point]] = defaultdict(list)
    places = {target.name: place for place, target in enumerate(problem.targets)}
    for name, definition in tests.items():
        test = _test(definition)
        point = locus_point(test) if test else None
        place = places.get(response_name(name, point.angle, len(tests))) if point else None
        if test and point and place is not None:
            found = _Point(point.normal_stress, name, place)
            materials[_material(problem, test, definition)].append(found)
    return tuple(
        _locus(problem, sorted(points), responses)
        for points in materials.values()
        if max(points).normal_stress > _LEAST_RATIO * min(points).normal_stress
    )


def _test(definition: RunDefinition) -> BulkTest | None:
    # A run of another version may not be understood.
    with suppress(InputError):
        return recreate_test(definition)
    return None


def _material(problem: Problem, test: BulkTest, definition: RunDefinition) -> Hashable:
    """Return the particles and all parameters that are not free."""
    free = {parameter.name for parameter in problem.parameters}
    fixed = {name: value for name, value in definition.parameters.items() if name not in free}
    return test.sizes, frozenset(fixed.items())


def _locus(
    problem: Problem, points: Sequence[_Point], responses: Mapping[str, ResponseResult]
) -> YieldLocusResult:
    stresses = [point.normal_stress for point in points]
    places = [point.place for point in points]
    targets = [problem.targets[place] for place in places]
    measured = [Response(target.value, target.standard_uncertainty) for target in targets]
    correlations = problem.correlation_matrix[np.ix_(places, places)]
    expected = [
        Response(found.predicted, found.standard_error)
        for target in targets
        if (found := responses.get(target.name))
    ]
    return YieldLocusResult(
        tuple(point.test for point in points),
        fit_yield_locus(stresses, measured, correlations),
        _expected(stresses, expected),
    )


def _expected(stresses: Sequence[float], angles: Sequence[Response]) -> YieldLocus | None:
    # Metamodels that follow a few runs exactly state no errors.
    if len(angles) < len(stresses) or any(angle.standard_error <= 0 for angle in angles):
        return None
    return fit_yield_locus(stresses, angles)
