"""Targets that an apparatus of another size would miss, where the file gives no size."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests.apparatus import apparatus_of
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.recorded_trials import LARGER
from grainfit.calibration.runs_to_come import recorded_scatters
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.formatting import number


@check("assumed-size", "warning")
def assumed_size(context: FileContext) -> Iterator[Found]:
    """Responses that follow the size of an apparatus of which the file does not say how large."""
    given = {test.name: test.options for test in context.file.tests}
    for name, test in context.bulk_tests.items():
        if test.vessel and test.vessel not in given[name]:
            moved = "; ".join(_moved(context, name, test))
            if moved:
                size = next(v.value for v in apparatus_of(test) if v.name == test.vessel)
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
    for one in recorded_scatters(context.problem, context.solvers, {}):
        known = test.responses[one.response].trials if one.test == name else None
        if known is not None and max(map(abs, known.larger)) > one.tolerated:
            shown = " and ".join(f"{100 * change:+.3g} %" for change in known.larger)
            tolerated = number(100 * one.tolerated, 2)
            yield f"{one.response} by {shown} (its tolerance is {tolerated} %)"
