"""A check of time steps that are too large for the contact law and the bed."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests.time_steps import least_safe_fraction
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.errors import InputError


@check("large-time-step", "warning")
def large_time_step(context: FileContext) -> Iterator[Found]:
    """Time steps that are too large for the contact law, the restitution, or the soft bed."""
    for name, test in context.bulk_tests.items():
        fraction = test.setup.time_step_fraction
        try:
            safe = least_safe_fraction(test, context.intervals, context.contact_models)
        except InputError:
            # Another message says that there is no contact law.
            return
        if fraction > safe:
            yield (
                context.key(name, "time_step_fraction"),
                messages.LARGE_TIME_STEP(test=name, fraction=fraction, safe=safe),
            )
