"""Targets of each test, and too few of them."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests.base import BulkTest
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.evaluation import response_name
from grainfit.formatting import counted


def targets_of_test(context: FileContext, name: str, test: BulkTest) -> dict[str, float | None]:
    """Return the measured values of a test by response, None for a curve."""
    values = {target.name: target.value for target in context.problem.targets}
    count, responses = len(context.solvers), context.problem.responses
    names = {one: response_name(name, one, count) for one in test.response_names or ()}
    return {one: values.get(full) for one, full in names.items() if full in responses}


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
