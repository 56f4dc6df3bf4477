"""Default time-outs of runs, so that a solver that hangs does not block a calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from grainfit.errors import Fault
from grainfit.options.places import Findings, Place
from grainfit.problem import Problem
from grainfit.solvers.base import Solver
from grainfit.solvers.file_entry import TIMEOUT_KEY
from grainfit.validation import plain


def default_timeouts(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, float]:
    """Return the default time-outs by name of the test, s, of solvers that have one.

    They are generous, and estimated for a run at the centre of the intervals.
    """
    middle = problem.middle
    timeouts = {test: solver.default_timeout(middle) for test, solver in solvers.items()}
    return {test: seconds for test, seconds in timeouts.items() if seconds is not None}


def read_timeout(key: str, given: object) -> tuple[float, list[Fault]]:
    """Read a time-out of an argument: a number, infinity or a quantity.

    Returns
    -------
    tuple of (float, list of Fault)
        In s, infinite where there are faults; and why it cannot be used.
    """
    value = plain(given)
    if isinstance(value, float) and value == math.inf:
        return value, []
    findings = Findings()
    seconds = TIMEOUT_KEY.kind.read(value, Place(findings))
    return seconds or math.inf, [replace(fault, key=key) for fault in findings.faults]
