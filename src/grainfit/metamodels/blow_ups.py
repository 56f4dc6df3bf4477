"""Responses that are no physical answer: those of runs that have blown up.

A simulation that became unstable may still yield a number, such as an angle of 1e6 degrees. A
metamodel that has to follow it is wrong everywhere, so its run counts as failed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from grainfit.evaluation import ALL_RUNS, Evaluation
from grainfit.formatting import counted, number
from grainfit.metamodels import messages
from grainfit.metamodels.checked_arrays import MAGNITUDES
from grainfit.problem import Problem, Target

#: Response, over the measured value and the usual ones, above which a run has blown up.
_BLOWN_UP = 1e3
#: Share of the runs that have usual responses at least.
_USUAL = 0.25


def without_blow_ups(problem: Problem, evaluations: Sequence[Evaluation]) -> list[Evaluation]:
    """Return evaluations in which runs that have blown up are failures.

    A run has blown up when one of its responses is more than 1000 times as large as the measured
    value, as its tolerance, and as the responses of a quarter of all runs.

    Parameters
    ----------
    problem : Problem
        Targets, and the tests to which they belong.
    evaluations : sequence of Evaluation
        All runs.
    """
    limits = {target.name: _limit(target, evaluations) for target in problem.targets}
    return [_judged(problem, limits, evaluation) for evaluation in evaluations]


def about_blow_ups(problem: Problem, evaluations: Sequence[Evaluation]) -> Iterator[str]:
    """Say how many runs of each target have blown up."""
    for target in problem.targets:
        limit = _limit(target, evaluations)
        found = [abs(response) for response in _values(target, evaluations)]
        blown = [value for value in found if value > limit]
        if blown:
            yield messages.BLOWN_UP_RUNS(
                name=target.name,
                runs=counted(len(blown), "run"),
                count=len(found),
                largest=number(max(blown), 2),
            )


def _values(target: Target, evaluations: Sequence[Evaluation]) -> list[float]:
    return [e.responses[target.name].value for e in evaluations if target.name in e.responses]


def _limit(target: Target, evaluations: Sequence[Evaluation]) -> float:
    values = np.abs(_values(target, evaluations))
    # The largest numbers have no mean.
    usual = float(np.quantile(values, _USUAL, method="lower")) if len(values) else 0.0
    return min(_BLOWN_UP * max(abs(target.value), target.tolerance, usual), MAGNITUDES[1])


def _judged(problem: Problem, limits: dict[str, float], evaluation: Evaluation) -> Evaluation:
    blown = [
        name
        for name, limit in limits.items()
        if name in evaluation.responses and abs(evaluation.responses[name].value) > limit
    ]
    if not blown:
        return evaluation
    scopes = [problem.scope_of(name) for name in blown]
    gone = {target for scope in scopes for target in scope.targets}
    why = messages.BLOWN_UP()
    return replace(
        evaluation,
        responses={name: r for name, r in evaluation.responses.items() if name not in gone},
        curves={name: curve for name, curve in evaluation.curves.items() if name not in gone},
        failures={**evaluation.failures, **{scope.name or ALL_RUNS: why for scope in scopes}},
    )
