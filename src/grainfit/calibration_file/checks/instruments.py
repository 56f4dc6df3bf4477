"""Tolerances that are finer than any instrument."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests.accuracy import finest_accuracy
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.evaluation import response_name


@check("finer-than-instruments", "warning")
def finer_than_instruments(context: FileContext) -> Iterator[Found]:
    """Tolerances finer than instruments of the kind reach."""
    targets = {target.name: target for target in context.problem.targets}
    for name, test in context.bulk_tests.items():
        for response, info in test.responses.items():
            target = targets.get(response_name(name, response, len(context.solvers)))
            if target is None or not target.value:
                continue
            finest = finest_accuracy(response, info.unit).of(target.value)
            if target.tolerance < finest:
                text = messages.FINER_THAN_INSTRUMENTS(
                    name=target.name,
                    tolerance=f"{target.tolerance:.3g} {info.unit}".rstrip(),
                    finest=f"{finest:.2g} {info.unit}".rstrip(),
                )
                yield context.key(name, f"targets.{response}"), text
