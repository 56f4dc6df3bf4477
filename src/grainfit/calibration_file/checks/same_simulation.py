"""Tests that simulate the same: those that share runs, and those that could."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from grainfit.calibration_file.checks.context import FileContext
from grainfit.calibration_file.content import TestSpecification
from grainfit.calibration_file.same_simulation import is_same_simulation
from grainfit.checks import Found, check
from grainfit.formatting import in_a_row


@check("shared-simulation")
def shared_simulation(context: FileContext) -> Iterator[Found]:
    """Tests that differ in their evaluation only, and share their runs."""
    for test in context.file.tests:
        if test.joined:
            yield (
                context.key(test.name),
                f"Tests {in_a_row(test.joined, 'and')} differ in their evaluation only: each "
                f"simulation serves all of them. They are called {test.name}.",
            )


@check("repeated-simulation")
def repeated_simulation(context: FileContext) -> Iterator[Found]:
    """Tests that simulate the same, each with runs of its own."""
    for one, other in combinations(context.file.tests, 2):
        if is_same_simulation(one, other):
            yield (
                context.key(other.name),
                f"Tests {one.name} and {other.name} differ at most in their evaluation, but each "
                "simulation is made for one of them only. Make them one [[test]] with the "
                f"targets of both{_remedy(one)}.",
            )


def _remedy(test: TestSpecification) -> str:
    for key in ("evaluate", "measure"):
        if key in test.options:
            return f": let the function in {key} return all their responses"
    return ""
