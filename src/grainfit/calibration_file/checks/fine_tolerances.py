"""Forecast by the recorded scatter: runs that tolerances take, and how calibrations end."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.evaluation import response_name
from grainfit.formatting import number
from grainfit.problem import Target
from grainfit.strategies.budget import runs_with_scatter, scatter_with_runs
from grainfit.strategies.sequential.search import RUNS_PER_PARAMETER, usual_design

#: Share of calibrations that end undecided, by the runs that the scatter takes over the largest
#: number (`benchmarks/scatter_forecast.py`).
_RUNS_OVER_LIMIT = (0.6, 0.87, 1.0, 1.25, 1.6)
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
    targets = {target.name: target for target in context.problem.targets}
    budget = max_runs or context.file.strategy.max_runs
    for name, test in context.bulk_tests.items():
        repeats = context.file.repeats.get(name, 1)
        for response, info in test.responses.items():
            target = targets.get(response_name(name, response, len(context.solvers)))
            if target is not None and info.sensitivities is not None and target.value:
                scatter = info.sensitivities.scatter / math.sqrt(repeats)
                note = _forecast(target, scatter, repeats, context.problem.dimension, budget)
                if note:
                    yield context.key(name, f"targets.{response}"), note


def _forecast(
    target: Target, scatter: float, repeats: int, dimension: int, budget: int | None
) -> str:
    """Return runs and prospects of a target; "" where they are good."""
    tolerated = target.tolerance / abs(target.value)
    runs = runs_with_scatter(scatter / tolerated, dimension) * repeats
    limit = budget or (usual_design(dimension) + RUNS_PER_PARAMETER * dimension) * repeats
    undecided = float(np.interp(runs / limit, _RUNS_OVER_LIMIT, _UNDECIDED))
    if undecided < _NOTED:
        return ""
    offered = dimension + 4 + _OFFERED
    wide = scatter / scatter_with_runs(offered, dimension)
    one = "recorded runs scatter" if repeats == 1 else f"means of {repeats} recorded runs scatter"
    percent = 'If a percentage was meant, write it as one: "1 %".'
    return (
        f"{target.name}: {one} by about {number(100 * scatter, 2)} %, and its tolerance, "
        + f"{target.tolerance:.4g} {target.unit}".rstrip()
        + f", is {number(100 * tolerated, 2)} % of the value: about {number(runs, 2)} runs. About "
        f"{math.ceil(10 * undecided)} of 10 such calibrations end undecided, with a budget of "
        f"{limit} runs; a tolerance of {number(100 * wide, 2)} % takes about {offered * repeats}."
        + (f" {percent}" if tolerated * _TIMES_FINER < scatter else "")
    )
