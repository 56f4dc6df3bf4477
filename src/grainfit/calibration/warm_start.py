"""Start a search from runs of other calibrations."""

from __future__ import annotations

from collections.abc import Sequence

from grainfit.evaluation import Evaluation
from grainfit.metamodels.known_runs import distance_outside
from grainfit.problem import Problem
from grainfit.strategies.base import Search


def warm_start(search: Search, problem: Problem, known: Sequence[Evaluation]) -> None:
    """Tell a search the runs of other calibrations, also those beyond the intervals.

    Only runs within the intervals replace runs of the design: those beyond do not show the
    response between the bounds. They are told only to a search whose answer is never outside
    the intervals.

    Parameters
    ----------
    search : Search
        A search that has not proposed anything yet.
    problem : Problem
        Its problem.
    known : sequence of Evaluation
        Runs within the intervals and near them.
    """
    distances = [distance_outside(problem, e.proposal.parameters) for e in known]
    search.warm_start([e for e, far in zip(known, distances, strict=True) if far == 0.0])
    if search.learns_beyond_intervals:
        for evaluation, far in zip(known, distances, strict=True):
            if far > 0.0:
                search.note(evaluation)
