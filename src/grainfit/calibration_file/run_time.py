"""Number of runs and time that a calibration will take."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

from grainfit.calibration_file.content import CalibrationFile
from grainfit.errors import InputError
from grainfit.formatting import duration
from grainfit.problem import Problem
from grainfit.solvers.base import Solver
from grainfit.strategies.budget import start_search
from grainfit.verdict.options import VERDICT

#: From this time on, a calibration is worth shortening, s.
_LONG = 86_400.0
#: Largest number of runs after the design, over the usual one.
_MOST = 4
_DAY = 86_400.0
#: Time from which on minutes are left out, s.
_HOURS = 36_000.0


@dataclass(frozen=True)
class ExpectedRuns:
    """Expected number of runs of a calibration.

    Parameters
    ----------
    design, after : int
        Runs of the design, and the usual number after it, verification included.
    verification : int
        Fewest runs with fresh seeds, part of those after the design.
    strategy : str
        Name of the strategy.
    limit : int, optional
        Budget.
    """

    design: int
    after: int
    verification: int
    strategy: str
    limit: int | None

    @property
    def most_after(self) -> int:
        """Largest usual number of runs after the design."""
        return _MOST * self.after

    @property
    def total(self) -> tuple[int, int]:
        """Smallest and largest usual number of runs in all, within the budget."""
        most = self.limit or math.inf
        return (
            int(min(self.design + self.after, most)),
            int(min(self.design + self.most_after, most)),
        )


def expected_runs(file: CalibrationFile, problem: Problem) -> ExpectedRuns:
    """Return the expected number of runs.

    Raises
    ------
    InputError
        The options of the strategy do not fit the problem.
    """
    strategy = file.strategy
    verification = strategy.verification_runs or VERDICT.fresh_seeds
    runs_of_a_set = sum(file.repeats.values())
    search = start_search(
        strategy.strategy,
        problem,
        runs_of_a_set,
        seed=1,
        max_runs=strategy.max_runs,
        verification_runs=verification,
    )
    # Runs of an evaluation of one test, on average.
    each = runs_of_a_set / len(file.repeats)
    left = math.ceil((search.expected_left - search.runs_of_design) * each)
    return ExpectedRuns(
        math.ceil(search.runs_of_design * each),
        max(left, verification * runs_of_a_set),
        verification * runs_of_a_set,
        search.name,
        strategy.max_runs,
    )


@dataclass(frozen=True)
class RunTime:
    """Expected time of a calibration.

    Parameters
    ----------
    runs : ExpectedRuns
        Expected number of runs.
    costs : mapping of str to float
        Estimated wall time of a run by name of the test, s.
    repeats : mapping of str to int
        Runs of an evaluation by name of the test.
    workers : int
        Runs at a time.
    """

    runs: ExpectedRuns
    costs: Mapping[str, float]
    repeats: Mapping[str, int]
    workers: int

    @property
    def seconds(self) -> tuple[float, float]:
        """Smallest and largest usual wall time in all, s."""
        weights = self.repeats
        mean = sum(weights[test] * s for test, s in self.costs.items()) / sum(weights.values())
        low, high = (math.ceil(runs / self.workers) * mean for runs in self.runs.total)
        return low, high

    @property
    def is_long(self) -> bool:
        """Whether it may take a day or more."""
        return self.seconds[1] >= _LONG

    def __str__(self) -> str:
        low, high = map(_in_words, self.seconds)
        return f"about {low}" if low == high else f"about {low} to {high}"


def run_time(
    runs: ExpectedRuns, costs: Mapping[str, float], repeats: Mapping[str, int], workers: int
) -> RunTime | None:
    """Return the expected time of a calibration; None if the cost of a test is not known.

    Parameters
    ----------
    runs, costs, repeats, workers
        As of a `RunTime`.
    """
    return RunTime(runs, costs, repeats, workers) if costs.keys() == repeats.keys() else None


def costs_of_runs(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, float]:
    """Return the estimated wall time of a run by name of the test, s, where it is known.

    Parameters
    ----------
    problem : Problem
        Costs are those in the middle of its intervals.
    solvers : mapping of str to Solver
        By name of the test.
    """
    costs: dict[str, float] = {}
    for test, solver in solvers.items():
        # The plan says why a cost is not known.
        with suppress(InputError):
            if (cost := solver.estimate_cost(problem.middle)) is not None:
                costs[test] = cost.wall_seconds
    return costs


def _in_words(seconds: float) -> str:
    if seconds >= 2 * _DAY:
        return f"{seconds / _DAY:.0f} days"
    if seconds >= _HOURS:
        # Minutes of such an estimate would say nothing.
        return f"{seconds / 3600:.0f} h"
    return duration(seconds)
