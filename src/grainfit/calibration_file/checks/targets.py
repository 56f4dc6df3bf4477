"""Targets of each test, and too few of them."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.formatting import counted


@check("too-few-targets")
def too_few_targets(context: FileContext) -> Iterator[Found]:
    """More free parameters than targets, so that many parameter sets fit equally well."""
    problem = context.problem
    free, measured = problem.dimension - len(problem.measured), len(problem.responses)
    if free <= measured:
        return
    targets = counted(measured, "target")
    if problem.curves:
        yield "", messages.FEW_TARGETS_WITH_CURVES(free=free, targets=targets)
    else:
        yield "", messages.FEW_TARGETS(free=free, targets=targets)
