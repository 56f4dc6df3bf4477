"""The line of `check` about a hold-out: its runs, and how long they take."""

from __future__ import annotations

from grainfit.calibration.holdout import Holdout
from grainfit.calibration_file import messages
from grainfit.formatting import counted, duration
from grainfit.problem import Problem
from grainfit.verdict.options import HOLDOUT


def holdout_line(holdout: Holdout, problem: Problem, workers: int) -> str:
    """Return what will be simulated of a hold-out after the verdict.

    Parameters
    ----------
    holdout : Holdout
        The hold-out.
    problem : Problem
        Free parameters.
    workers : int
        Runs at a time.
    """
    sets = HOLDOUT.answer_seeds + HOLDOUT.posterior_draws + HOLDOUT.prior_draws
    runs = sets * holdout.repeats
    cost = holdout.model.estimate_cost(problem.middle)
    time = "" if cost is None else f", about {duration(runs * cost.wall_seconds / workers)}"
    known = messages.HOLDOUT_MEASURED if holdout.targets else messages.HOLDOUT_UNMEASURED
    return messages.HOLDOUT_LINE(
        test=holdout.name,
        runs=counted(runs, "run"),
        at_answer=HOLDOUT.answer_seeds * holdout.repeats,
        time=time,
        measured=known(),
    )
