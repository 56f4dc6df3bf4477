"""Number of runs to come: `check`, the first lines of `run` and the progress say the same."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from grainfit.evaluation import response_name
from grainfit.formatting import number
from grainfit.problem import Problem, Target
from grainfit.solvers.base import Solver
from grainfit.strategies.base import Search

#: Factor to both sides of the estimated number (`benchmarks/verdicts.py`).
_UNCERTAINTY = 1.6
_DIGITS = 2


@dataclass(frozen=True)
class RunsToCome:
    """Estimated number of runs to come, verification included.

    Parameters
    ----------
    needed : float
        Runs that are needed, were there no budget.
    fewest : int
        Runs that come in any case: those of the design and of the verification.
    most : int, optional
        Runs left in the budget.
    """

    needed: float
    fewest: int = 0
    most: int | None = None

    @property
    def about(self) -> int:
        """The estimate, within the budget."""
        return self._within(math.ceil(self.needed))

    @property
    def range(self) -> tuple[int, int]:
        """Range of the number, within the budget."""
        low, high = math.floor(self.needed / _UNCERTAINTY), math.ceil(self.needed * _UNCERTAINTY)
        return self._within(low), self._within(high)

    def _within(self, runs: int) -> int:
        wanted = max(self.fewest, runs)
        return wanted if self.most is None else min(wanted, max(self.most, 0))

    def __str__(self) -> str:
        low, high = self.range
        if low == high:
            return f"{low}"
        return f"{in_words(self.about)} ({number(low, _DIGITS)} to {number(high, _DIGITS)})"


def in_words(runs: float) -> str:
    """Return an estimated number of runs, which deserves two digits."""
    return f"about {number(runs, _DIGITS)}"


@dataclass(frozen=True)
class RunsSoFar:
    """Runs of a calibration that have ended.

    Parameters
    ----------
    done, cost, failed, verified : int
        All of them, the number of runs of the tests that cost as much, those that failed, and those
        of the verification.
    to_verify : int
        Verification runs that are asked for, where they are more than the fewest.
    is_design : bool
        Whether the design has not ended.
    """

    done: int = 0
    cost: int = 0
    failed: int = 0
    verified: int = 0
    to_verify: int = 0
    is_design: bool = True


def runs_to_come(
    search: Search,
    runs_of_a_set: int,
    max_runs: int | None,
    verification_runs: int,
    so_far: RunsSoFar | None = None,
) -> RunsToCome:
    """Return the number of runs to come.

    Parameters
    ----------
    search : Search
        The search, whose limit counts where no budget is given.
    runs_of_a_set : int
        DEM runs of one parameter set in all tests.
    max_runs : int or None
        Budget.
    verification_runs : int
        Fewest parameter sets of a verification.
    so_far : RunsSoFar, optional
        Runs that have ended; by default none.
    """
    ended = so_far or RunsSoFar()
    # Runs of an evaluation of one test, on average.
    each = runs_of_a_set / len(search.problem.scopes)
    to_verify = max(ended.to_verify, verification_runs * runs_of_a_set) - ended.verified
    design = math.ceil(search.runs_of_design * each) - ended.done if ended.is_design else 0
    successful = max(search.expected_left * each, to_verify, 0)
    # The design has its number of runs, however many fail.
    if ended.is_design or ended.failed == ended.done:
        needed = successful
    else:
        needed = successful * ended.done / (ended.done - ended.failed)
    fewest = max(design, 0) + max(to_verify, 0)
    most = runs_of_budget(search, runs_of_a_set, max_runs, verification_runs)
    if most is None:
        return RunsToCome(needed, fewest)
    left = most - ended.cost
    if ended.is_design:
        # Of the cheaper runs of relatives, more are within the budget.
        spared = search.spared_by_design * each - (ended.done - ended.cost)
        left += max(math.floor(spared), 0)
    if max_runs is None:
        # The verification is not limited.
        left = max(left, to_verify)
    return RunsToCome(needed, fewest, left)


def runs_of_budget(
    search: Search, runs_of_a_set: int, max_runs: int | None, verification_runs: int
) -> int | None:
    """Return the largest number of runs in all; None if there is none.

    Parameters
    ----------
    search, runs_of_a_set, max_runs, verification_runs
        As of `runs_to_come`.
    """
    if max_runs is not None or search.limit is None:
        return max_runs
    return (search.limit + verification_runs) * runs_of_a_set


@dataclass(frozen=True)
class RecordedScatter:
    """Scatter of a target that was recorded with the bulk test, before any run.

    Parameters
    ----------
    test, response : str
        Test, and its response.
    target : Target
        The target.
    repeats : int
        Runs whose mean is one evaluation.
    relative : float
        Relative standard deviation of such a mean.
    """

    test: str
    response: str
    target: Target
    repeats: int
    relative: float

    @property
    def tolerated(self) -> float:
        """Relative tolerance."""
        return self.target.tolerance / abs(self.target.value)

    @property
    def in_tolerances(self) -> float:
        """Standard deviation over the tolerance."""
        return self.relative / self.tolerated


def recorded_scatters(
    problem: Problem, solvers: Mapping[str, Solver], repeats: Mapping[str, int]
) -> Iterator[RecordedScatter]:
    """Yield the recorded scatter of each target that has one.

    Parameters
    ----------
    problem : Problem
        The targets.
    solvers : mapping of str to Solver
        By name of the test.
    repeats : mapping of str to int
        Runs of an evaluation by name of the test.
    """
    targets = {target.name: target for target in problem.targets}
    for test, solver in solvers.items():
        count = repeats.get(test, 1)
        responses = solver.bulk_test.responses if solver.bulk_test else {}
        for response, info in responses.items():
            target = targets.get(response_name(test, response, len(solvers)))
            if target is not None and info.trials is not None and target.value:
                relative = info.trials.scatter / math.sqrt(count)
                yield RecordedScatter(test, response, target, count, relative)


def with_recorded_scatters(
    problem: Problem, solvers: Mapping[str, Solver], repeats: Mapping[str, int]
) -> Problem:
    """Return the problem with the recorded scatters of its targets, where none are given.

    Parameters
    ----------
    problem, solvers, repeats
        As of `recorded_scatters`.
    """
    recorded = {
        one.target.name: one.relative * abs(one.target.value)
        for one in recorded_scatters(problem, solvers, repeats)
    }
    return replace(problem, scatters=recorded | dict(problem.scatters))


def largest_scatter(
    problem: Problem, solvers: Mapping[str, Solver], repeats: Mapping[str, int]
) -> float | None:
    """Return the largest recorded scatter in tolerances, None if none is known.

    Parameters
    ----------
    problem, solvers, repeats
        As of `recorded_scatters`.
    """
    found = recorded_scatters(problem, solvers, repeats)
    return max((one.in_tolerances for one in found), default=None)
