"""Tolerances that are too narrow to be confirmed."""

from __future__ import annotations

import math
from collections.abc import Iterator

from grainfit.analysis.scatter_statistics import runs_within
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.evaluation import response_name
from grainfit.formatting import number
from grainfit.problem import Target

#: Tolerances that are this many times finer than the scatter from run to run are noted.
_TIMES_FINER = 5.0


@check("fine-tolerance")
def fine_tolerance(context: FileContext) -> Iterator[Found]:
    """Tolerances far below the scatter from run to run, which few runs cannot confirm."""
    targets = {target.name: target for target in context.problem.targets}
    for name, test in context.bulk_tests.items():
        for response, info in test.responses.items():
            target = targets.get(response_name(name, response, len(context.solvers)))
            if target is not None and info.sensitivities is not None:
                key = context.key(name, f"targets.{response}")
                scatter = info.sensitivities.scatter
                yield from ((key, note) for note in _note_on_tolerance(target, scatter))


def _note_on_tolerance(target: Target, scatter: float) -> Iterator[str]:
    """Yield a note on a tolerance that is far below the scatter from run to run."""
    tolerated = target.tolerance / abs(target.value) if target.value else math.inf
    if tolerated * _TIMES_FINER >= scatter:
        return
    runs = runs_within(scatter, tolerated)
    yield (
        f"{target.name}: its tolerance, {target.tolerance:g} {target.unit}".rstrip()
        + f", is {number(100 * tolerated, 2)} % of the value, and runs scatter by about "
        f"{100 * scatter:.2g} %: the mean of {number(runs, 1)} runs would be as sure. If a "
        'percentage was meant, write it as one: "1 %".'
    )
