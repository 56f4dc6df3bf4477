"""Result of a calibration that is not at its end: the one that an interrupt would leave now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from grainfit.calibration.build_result import Ending, make_result
from grainfit.calibration.judged_answer import Demands, judge_by_runs
from grainfit.calibration.repetitions import Repetitions
from grainfit.errors import RunFailedError
from grainfit.evaluation import Evaluation
from grainfit.metamodels.blow_ups import without_blow_ups
from grainfit.problem import Problem
from grainfit.result import Result
from grainfit.strategies.registry import make_strategy
from grainfit.verdict.options import VERDICT

#: Options of the strategies that influence which of the known parameter sets is the answer.
_OF_THE_ANSWER = ("prefer", "confidence")


def result_so_far(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    warm_start: Sequence[Evaluation] = (),
    *,
    options: Mapping[str, Any] | None = None,
    seed: int = 1,
    repetitions: Repetitions | None = None,
) -> Result | None:
    """Return the best answer by the runs so far, and what they lead to expect at it.

    The answer is chosen as the sequential strategy does, from the runs alone: no search is
    continued. The intervals of the parameters, which take much longer, are left out.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    evaluations : sequence of Evaluation
        The runs of the calibration.
    warm_start : sequence of Evaluation
        Runs of its warm start.
    options : mapping, optional
        Options of the strategy: what it prefers, and the demanded probability.
    seed : int
        Decides the searches of the metamodels.
    repetitions : Repetitions, optional
        Runs with fresh seeds that are no evidence of their own.

    Returns
    -------
    Result or None
        With status ``interrupted``; None while there are too few runs.
    """
    given = {name: value for name, value in (options or {}).items() if name in _OF_THE_ANSWER}
    search = make_strategy("sequential", given).start(problem, seed)
    repetitions = repetitions or Repetitions()
    for evaluation in (*evaluations, *warm_start):
        if not repetitions.is_known(evaluation):
            search.note(evaluation)
    verified = [one for one in evaluations[-1:] if one.proposal.stage == "verification"]
    try:
        # An answer is frozen while it is verified.
        answer = search.answer(verified[0].proposal.parameters if verified else None)
    except RunFailedError:
        return None
    every = without_blow_ups(problem, (*evaluations, *warm_start))
    reduced, usable = answer.reduced(problem, every)
    repeats = {scope.name: scope.repeats for scope in problem.scopes}
    demands = Demands(search.confidence, VERDICT.fresh_seeds, repeats)
    outcome = judge_by_runs(reduced, answer, usable, demands, repetitions)
    return make_result(Ending("", "", 0.0, 0.0, "interrupted"), search, outcome, evaluations)
