"""Targets that an apparatus of another size would miss, where the file gives no size."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.sensitivities import LARGER
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.evaluation import response_name
from grainfit.formatting import millimetres, number


@check("assumed-size", "warning")
def assumed_size(context: FileContext) -> Iterator[Found]:
    """Responses that follow the size of an apparatus of which the file does not say how large."""
    given = {test.name: test.options for test in context.file.tests}
    for name, test in context.bulk_tests.items():
        if test.vessel and test.vessel not in given[name]:
            moved = "; ".join(_moved(context, name, test))
            if moved:
                size = millimetres(test.resolved_options()[test.vessel])
                yield (
                    context.key(name, test.vessel),
                    messages.ASSUMED_SIZE(
                        test=name,
                        vessel=test.vessel,
                        size=size,
                        times=" and ".join(map(str, LARGER)),
                        moved=moved,
                    ),
                )


def _moved(context: FileContext, name: str, test: BulkTest) -> Iterator[str]:
    """Yield the responses that move by more than their tolerance."""
    targets = {target.name: target for target in context.problem.targets}
    for response, info in test.responses.items():
        target = targets.get(response_name(name, response, len(context.solvers)))
        if target is None or not target.value or info.sensitivities is None:
            continue
        changes, tolerance = info.sensitivities.larger, target.tolerance / abs(target.value)
        if max(map(abs, changes)) > tolerance:
            shown = " and ".join(f"{100 * change:+.3g} %" for change in changes)
            yield f"{response} by {shown} (its tolerance is {number(100 * tolerance, 2)} %)"
