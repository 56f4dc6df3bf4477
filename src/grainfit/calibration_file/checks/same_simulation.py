"""Tests that simulate the same: those that share runs, and those that could."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.calibration_file.same_simulation import is_same_simulation
from grainfit.checks import Found, check
from grainfit.formatting import in_a_row


@check("shared-simulation")
def shared_simulation(context: FileContext) -> Iterator[Found]:
    """Tests that differ in their evaluation only, and share their runs."""
    for test in context.file.tests:
        if test.joined:
            joined = in_a_row(test.joined, "and")
            found = messages.SHARED_SIMULATION(tests=joined, name=test.name)
            yield context.key(test.name), found


@check("repeated-simulation")
def repeated_simulation(context: FileContext) -> Iterator[Found]:
    """Tests that simulate the same, each with runs of its own."""
    for one, other in combinations(context.file.tests, 2):
        if is_same_simulation(one, other):
            functions = [key for key in ("evaluate", "measure") if key in one.options]
            of_both = messages.ONE_FUNCTION(key=functions[0]) if functions else ""
            found = messages.REPEATED_SIMULATION(one=one.name, other=other.name, of_both=of_both)
            yield context.key(other.name), found
