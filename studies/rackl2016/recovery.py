"""Recovery: calibrations against "measurements" of which the parameters are known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import fmean, stdev

import numpy as np
from scipy.stats import t as student_t

from grainfit.problem import Target
from studies.rackl2016.calibrations import calibrate_with_grainfit, expected_responses
from studies.rackl2016.setting import (
    DENSITY,
    MOST_SEARCH_RUNS,
    RESPONSES,
    ROLLING_FRICTION,
    UNITS,
    around,
    paper_problem,
    problem,
)
from studies.rackl2016.tasks import Context, Record

WIDTH = 0.66
SETS, MEASUREMENTS, FRESH_RUNS, VERIFICATION_RUNS = 20, 8, 12, 6
_SEED = 2016


def true_parameters(number: int) -> dict[str, float]:
    """A random parameter set within the intervals: number 0, 1, 2, ..."""
    random = np.random.default_rng([_SEED, number])
    return paper_problem(WIDTH).from_unit(random.uniform(size=2))


def measure(context: Context, number: int) -> Record:
    """Simulate the "measurements"."""
    name = f"measurements of set {number}"
    return expected_responses(context, true_parameters(number), MEASUREMENTS, name)


def measured_targets(values: dict[str, Sequence[float]]) -> list[Target]:
    """Mean of the measurements with its standard error, accepted within its 95 % interval."""
    found = []
    for name in RESPONSES:
        error = stdev(values[name]) / math.sqrt(len(values[name]))
        quantile = float(student_t.ppf(0.975, len(values[name]) - 1))
        found.append(
            Target(name, fmean(values[name]), error, tolerance=quantile * error, unit=UNITS[name])
        )
    return found


def recover(context: Context, number: int) -> Record:
    """Calibrate against the measurements without knowing the parameters."""
    measured = context.records[f"measured-{number:02d}"]["values"]
    wanted = problem(
        around(DENSITY, WIDTH),
        around(ROLLING_FRICTION, WIDTH),
        measured=measured_targets(measured),
    )
    return calibrate_with_grainfit(
        context,
        wanted,
        strategy="sequential",
        seed=_SEED + number,
        most_search_runs=MOST_SEARCH_RUNS,
        verification_runs=VERIFICATION_RUNS,
    )
