"""Largest deviation that a search expects at its present answer, for displays of progress."""

from __future__ import annotations

import time

from grainfit.errors import RunFailedError
from grainfit.problem import Problem
from grainfit.strategies.base import Search

#: Shortest time between two estimates, s, and over the time that the last one took: a strategy may
#: fit its metamodels for each.
_INTERVAL, _SPARING = 2.0, 10.0


class ExpectedDeviation:
    """Largest relative deviation of an expected response, computed again as runs end.

    Parameters
    ----------
    problem : Problem
        Targets; with curves, or where deviations are not relative, there is no such deviation.
    search : Search
        Gives the answer.
    """

    def __init__(self, problem: Problem, search: Search) -> None:
        self._search = search
        relative = not problem.curves and all(target.is_relative for target in problem.targets)
        self._targets = problem.targets if relative else ()
        self._runs = -1
        self._due = float("-inf")
        self._latest: float | None = None

    def after(self, runs: int) -> float | None:
        """Return it after a number of evaluations; None before the search has an answer."""
        started = time.monotonic()
        if self._targets and runs != self._runs and started > self._due:
            self._latest = self._compute()
            self._runs, ended = runs, time.monotonic()
            self._due = ended + max(_INTERVAL, _SPARING * (ended - started))
        return self._latest

    def _compute(self) -> float | None:
        try:
            expected = self._search.answer().predicted
        except RunFailedError:
            return None
        return max(abs(target.misfit(expected[target.name])) for target in self._targets)
