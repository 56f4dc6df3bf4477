"""Targets of each test, and too few of them."""

from __future__ import annotations

from collections.abc import Iterator

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
        yield (
            "",
            f"{free} free parameters and {targets}, curves included. A curve can determine "
            "several parameters if its shape depends on them: the intervals of the result will "
            "show how many.",
        )
        return
    yield (
        "",
        f"{free} free parameters and {targets}: many parameter sets will fit equally well. Fix a "
        "parameter or measure another response.",
    )
