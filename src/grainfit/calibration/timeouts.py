"""Time-outs of runs: no solver that hangs may stop a calibration for ever."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.problem import Problem
from grainfit.solvers.base import Solver


def default_timeouts(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, float]:
    """Return the longest wall time of a run by name of the test, s, where it can be known.

    It is that of a run in the middle of the intervals, with much patience.
    """
    middle = problem.from_unit([0.5] * problem.dimension)
    timeouts = {test: solver.default_timeout(middle) for test, solver in solvers.items()}
    return {test: seconds for test, seconds in timeouts.items() if seconds is not None}
