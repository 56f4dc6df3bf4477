"""Default time-outs of runs, so that a solver that hangs does not block a calibration."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.problem import Problem
from grainfit.solvers.base import Solver


def default_timeouts(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, float]:
    """Return the default time-outs by name of the test, s, of solvers that have one.

    They are generous, and estimated for a run at the centre of the intervals.
    """
    middle = problem.middle
    timeouts = {test: solver.default_timeout(middle) for test, solver in solvers.items()}
    return {test: seconds for test, seconds in timeouts.items() if seconds is not None}
