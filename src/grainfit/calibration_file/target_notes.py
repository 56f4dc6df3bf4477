"""Notes on measurements that the geometry of a test keeps out of reach."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.base import BulkTest
from grainfit.evaluation import response_name
from grainfit.problem import Problem


def target_notes(problem: Problem, tests: Mapping[str, BulkTest], count: int) -> Iterator[str]:
    """Yield what each test has to say about its targets, see `BulkTest.target_notes`.

    Parameters
    ----------
    problem : Problem
        Targets.
    tests : mapping of str to BulkTest
        Simulated tests by name.
    count : int
        Number of all tests.
    """
    measured = {target.name: target.value for target in problem.targets}
    for name, test in tests.items():
        names = {one: response_name(name, one, count) for one in test.response_names or ()}
        own = {one: measured.get(full) for one, full in names.items() if full in problem.responses}
        for note in test.target_notes(own):
            yield f"Test {name}: {note}"
