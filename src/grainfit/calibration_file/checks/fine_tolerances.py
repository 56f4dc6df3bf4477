"""Forecast by the recorded scatter: runs that tolerances take, and how calibrations end."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from grainfit.calibration.runs_to_come import RecordedScatter, in_words, recorded_scatters
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.calibration_file.run_time import largest_number
from grainfit.checks import Found, check
from grainfit.errors import InputError
from grainfit.formatting import number
from grainfit.strategies.budget import runs_with_scatter, scatter_with_runs

#: Share of calibrations that end undecided, by the runs that the scatter takes over the largest
#: number (`benchmarks/scatter_forecast.py`).
_RUNS_OVER_LIMIT = (0.55, 0.8, 0.92, 1.15, 1.48)
_UNDECIDED = (0.0, 0.1, 0.2, 0.8, 0.9)
#: Share from which a tolerance is noted.
_NOTED = 0.15
#: Tolerances that are this many times finer than the scatter may be a percentage without its sign.
_TIMES_FINER = 5.0
#: Runs, more than the design takes, of the tolerance that is offered instead.
_OFFERED = 20


@check("fine-tolerance")
def fine_tolerance(context: FileContext) -> Iterator[Found]:
    """Tolerances far below the scatter from run to run, which few runs cannot confirm."""
    yield from scatter_forecasts(context)


def scatter_forecasts(context: FileContext, max_runs: int | None = None) -> Iterator[Found]:
    """Yield key and forecast of each target whose calibration may well end undecided.

    Parameters
    ----------
    context : FileContext
        The calibration file.
    max_runs : int, optional
        Budget of the command line, which replaces that of the file.
    """
    problem = context.problem
    try:
        budget = largest_number(context.file, problem, max_runs)
    except InputError:
        # Said as a fault of the strategy.
        return
    for found in recorded_scatters(problem, context.solvers, context.file.repeats):
        others = sum(context.file.repeats.values()) - found.repeats
        if note := _forecast(found, problem.dimension, others, budget):
            yield context.key(found.test, f"targets.{found.response}"), note


def _forecast(found: RecordedScatter, dimension: int, others: int, budget: int | None) -> str:
    """Return runs and prospects of a target; "" where they are good.

    Other tests have a number of runs for each evaluation, and take as few as they can.
    """
    target, repeats, tolerated = found.target, found.repeats, found.tolerated
    runs = runs_with_scatter(found.in_tolerances, dimension) * repeats
    runs_of_others = runs_with_scatter(0.0, dimension) * others
    share = (runs + runs_of_others) / budget if budget else 0.0
    undecided = float(np.interp(share, _RUNS_OVER_LIMIT, _UNDECIDED))
    if undecided < _NOTED:
        return ""
    offered = dimension + 4 + _OFFERED
    wide = found.relative / scatter_with_runs(offered, dimension)
    one = "recorded runs scatter" if repeats == 1 else f"means of {repeats} recorded runs scatter"
    note = messages.FINE_TOLERANCE(
        target=target.name,
        recorded=one,
        scatter=number(100 * found.relative, 2),
        tolerance=f"{target.tolerance:.4g} {target.unit}".rstrip(),
        share=number(100 * tolerated, 2),
        runs=in_words(runs),
        undecided=math.ceil(10 * undecided),
        budget=budget,
        wide=number(100 * wide, 2),
        offered=offered * repeats,
    )
    may_be_percent = tolerated * _TIMES_FINER < found.relative
    return f"{note} {messages.MEANT_AS_PERCENTAGE()}" if may_be_percent else note
