"""Number of runs and time that a calibration will take."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

from grainfit.atlas.guide import guided
from grainfit.calibration.runs_to_come import (
    RunsToCome,
    largest_scatter,
    runs_of_budget,
    runs_to_come,
)
from grainfit.calibration.scopes import with_scopes
from grainfit.calibration_file.content import CalibrationFile
from grainfit.errors import InputError
from grainfit.formatting import duration
from grainfit.problem import Problem
from grainfit.problem.test_scope import named_test
from grainfit.solvers.base import Solver
from grainfit.strategies.base import Search
from grainfit.strategies.budget import start_search
from grainfit.verdict.options import VERDICT

#: From this time on, a calibration is worth shortening, s.
_LONG = 86_400.0
_DAY = 86_400.0
#: Time from which on minutes are left out, s.
_HOURS = 36_000.0


@dataclass(frozen=True)
class SizeSeries:
    """Runs of several sizes at an answer, between searches in smaller apparatus.

    Parameters
    ----------
    runs : int
        Number of them.
    seconds : float
        Their estimated wall time, one run at a time, s.
    most : int
        Largest number of such series in a calibration; it has at least one.
    """

    runs: int
    seconds: float
    most: int


@dataclass(frozen=True)
class ExpectedRuns:
    """Expected number of runs of a calibration.

    Parameters
    ----------
    to_come : RunsToCome
        All of them; with smaller apparatus, those of the first search.
    design : int
        Runs of the design.
    verification : int
        Fewest runs with fresh seeds.
    strategy : str
        Name of the strategy.
    series : SizeSeries, optional
        Sizes at an answer; None without smaller apparatus.
    spared : float
        Runs whose time is spared, as those of cheaper relatives take a part of it.
    guided : sequence of str
        Tests whose search the atlas guides; their design is smaller.
    """

    to_come: RunsToCome
    design: int
    verification: int
    strategy: str
    series: SizeSeries | None = None
    spared: float = 0.0
    guided: Sequence[str] = ()

    @property
    def of_searches(self) -> tuple[int, int]:
        """Smallest and largest usual number of runs of all searches.

        One after a series of sizes has fresh seeds of its own where the answer moves.
        """
        low, high = self.to_come.range
        return low, high + (self.series.most * self.verification if self.series else 0)

    @property
    def total(self) -> tuple[int, int]:
        """Smallest and largest usual number of runs in all, those of other sizes included."""
        low, high = self.of_searches
        if self.series is None:
            return low, high
        return low + self.series.runs, high + self.series.most * self.series.runs


def expected_runs(
    file: CalibrationFile, problem: Problem, solvers: Mapping[str, Solver]
) -> ExpectedRuns:
    """Return the expected number of runs.

    Parameters
    ----------
    file : CalibrationFile
        The calibration file.
    problem : Problem
        Its problem, with the relatives of its tests.
    solvers : mapping of str to Solver
        By name of the test.

    Raises
    ------
    InputError
        The options of the strategy do not fit the problem.
    """
    budget, runs_of_a_set = file.strategy.max_runs, sum(file.repeats.values())
    problem = with_scopes(problem, solvers, file.repeats)
    search = _search(file, problem, budget, largest_scatter(problem, solvers, file.repeats))
    tests: list[str] = []
    if file.strategy.atlas is not False and file.strategy.strategy.uses_relatives:
        tests = [one.name for one in guided(problem, solvers)]
        search.learn_from_near((), tests)
    return ExpectedRuns(
        runs_to_come(search, runs_of_a_set, budget, _verification(file)),
        math.ceil(search.runs_of_design * runs_of_a_set / len(file.repeats)),
        _verification(file) * runs_of_a_set,
        search.name,
        spared=search.spared_by_design,
        guided=[named_test(name, solvers) for name in tests],
    )


def largest_number(file: CalibrationFile, problem: Problem, max_runs: int | None) -> int | None:
    """Return the largest number of runs, without a budget that of the strategy, if it has one.

    Parameters
    ----------
    file, problem
        As of `expected_runs`.
    max_runs : int or None
        Budget of the command line, which replaces that of the file.

    Raises
    ------
    InputError
        The options of the strategy do not fit the problem.
    """
    if budget := max_runs or file.strategy.max_runs:
        return budget
    search = _search(file, problem, None)
    return runs_of_budget(search, sum(file.repeats.values()), None, _verification(file))


def _verification(file: CalibrationFile) -> int:
    return file.strategy.verification_runs or VERDICT.fresh_seeds


def _search(
    file: CalibrationFile, problem: Problem, budget: int | None, scatter: float | None = None
) -> Search:
    return start_search(
        file.strategy.strategy,
        problem,
        sum(file.repeats.values()),
        seed=1,
        max_runs=budget,
        verification_runs=_verification(file),
        scatter=scatter,
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
        low, high = (
            math.ceil((runs - self.runs.spared) / self.workers) * mean
            for runs in self.runs.of_searches
        )
        series = self.runs.series
        if series is None:
            return low, high
        once = series.seconds / self.workers
        return low + once, high + series.most * once

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
    if _HOURS <= seconds < 2 * _DAY:
        # Minutes of such an estimate would say nothing.
        return f"{seconds / 3600:.0f} h"
    return duration(seconds)
