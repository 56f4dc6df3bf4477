"""Notes on measurements that are out of reach, or too narrow to be confirmed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from grainfit.analysis.scatter_statistics import runs_within
from grainfit.bulk_tests.base import BulkTest
from grainfit.evaluation import response_name
from grainfit.formatting import number
from grainfit.problem import Problem, Target

#: Tolerances that are this many times finer than the scatter from run to run are noted.
_TIMES_FINER = 5.0


def target_notes(problem: Problem, tests: Mapping[str, BulkTest], count: int) -> Iterator[str]:
    """Yield what each test says of its targets, and tolerances far below its scatter.

    See `BulkTest.target_notes`.

    Parameters
    ----------
    problem : Problem
        Targets.
    tests : mapping of str to BulkTest
        Simulated tests by name.
    count : int
        Number of all tests.
    """
    targets = {target.name: target for target in problem.targets}
    for name, test in tests.items():
        names = {one: response_name(name, one, count) for one in test.response_names or ()}
        own = {
            one: targets[full].value if full in targets else None
            for one, full in names.items()
            if full in problem.responses
        }
        for note in test.target_notes(own):
            yield f"Test {name}: {note}"
        for one, full in names.items():
            info = test.responses.get(one)
            if full in targets and info is not None and info.sensitivities is not None:
                yield from _note_on_tolerance(targets[full], info.sensitivities.scatter)


def _note_on_tolerance(target: Target, scatter: float) -> Iterator[str]:
    """Yield a note on a tolerance that the scatter from run to run hardly lets anyone confirm."""
    tolerated = target.tolerance / abs(target.value) if target.value else math.inf
    if tolerated * _TIMES_FINER >= scatter:
        return
    runs = runs_within(scatter, tolerated)
    yield (
        f"{target.name}: its tolerance, {target.tolerance:g} {target.unit}".rstrip()
        + f", is {number(100 * tolerated, 2)} % of the value, and runs scatter by about "
        f"{100 * scatter:.2g} %: the mean of {number(runs, 1)} runs would be as sure. If a "
        'percentage was meant, write it as one: "1 %".'
    )
