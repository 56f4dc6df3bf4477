"""Notes that bulk tests make on themselves, before any run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.base import BulkTest
from grainfit.problem import Problem


def bulk_test_notes(
    problem: Problem, bulk_tests: Mapping[str, BulkTest], fixed: Mapping[str, float]
) -> Iterator[str]:
    """Yield the notes of each test, at the upper ends of the intervals: most slender particles.

    Parameters
    ----------
    problem : Problem
        Free parameters.
    bulk_tests : mapping of str to BulkTest
        Simulated tests by name.
    fixed : mapping of str to float
        Material parameters that are not free.
    """
    highest = {**fixed, **{p.name: p.maximum for p in problem.parameters}}
    for name, test in bulk_tests.items():
        for note in test.notes(highest):
            yield f"Test {name}: {note}"
