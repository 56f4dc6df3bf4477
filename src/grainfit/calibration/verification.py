"""Verify an answer by runs with fresh seeds, which had no part in its choice.

The fresh runs go into the metamodels like all others, and the answer is chosen again with them. So
it moves a little, and runs very near it count as runs at it: their responses are carried over by
the metamodels' difference between the two points.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from statistics import fmean, stdev

from scipy.special import stdtrit

from grainfit.calibration.repetitions import Repetitions
from grainfit.evaluation import Evaluation
from grainfit.problem import Problem
from grainfit.strategies.answer import Answer
from grainfit.verdict.evidence import Verified
from grainfit.verdict.options import VERDICT
from grainfit.verdict.reasons import NoRecordThere


@dataclass(frozen=True)
class FreshRuns:
    """Responses of fresh seeds, carried over to the answer.

    Parameters
    ----------
    values : mapping of str to mapping of int to float
        By name of the target and seed of the run.
    evaluations : sequence of Evaluation
        The runs themselves, failed ones included.
    search : sequence of Evaluation
        The runs that verify nothing: where there are none at the answer, they tell how many fail.
    no_record : sequence of NoRecordThere
        Tests whose runs are read from a table that has none at the answer.
    repeats_records : bool
        Whether some of the runs have read rows that were read before, which verify nothing.
    deterministic : tuple of str
        Tests whose model gives the same for every seed, see `Repetitions`.
    """

    values: Mapping[str, Mapping[int, float]]
    evaluations: Sequence[Evaluation]
    search: Sequence[Evaluation] = ()
    no_record: Sequence[NoRecordThere] = ()
    repeats_records: bool = False
    deterministic: tuple[str, ...] = ()

    @property
    def failures(self) -> tuple[int, int]:
        """Number of failed runs, and of all: those at the answer, or of the search without any."""
        known = self.evaluations or self.search
        failed = sum(len(evaluation.failed_runs) for evaluation in known)
        return failed, sum(len(evaluation.runs) for evaluation in known)

    @property
    def count(self) -> int:
        """Number of fresh seeds that gave every response."""
        return min((len(values) for values in self.values.values()), default=0)

    def verified(self) -> dict[str, Verified]:
        """Return the means of the responses that at least two fresh seeds gave."""
        return {
            name: mean_with_interval(list(values.values()))
            for name, values in self.values.items()
            if len(values) >= 2
        }


def runs_near(
    problem: Problem,
    answer: Answer,
    evaluations: Iterable[Evaluation],
    describe: Callable[[Mapping[str, float]], Answer],
    repetitions: Repetitions | None = None,
) -> FreshRuns:
    """Return the verification runs at or very near an answer.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    answer : Answer
        The answer.
    evaluations : iterable of Evaluation
        All runs.
    describe : callable
        Returns the predictions for a parameter set; only called for the few that are verified.
    repetitions : Repetitions, optional
        Runs that are no evidence of their own.
    """
    repetitions = repetitions or Repetitions()
    stale = repetitions.stale
    values: dict[str, dict[int, float]] = {target.name: {} for target in problem.targets}
    near: list[Evaluation] = []
    search: list[Evaluation] = []
    shifts: dict[tuple[float, ...], dict[str, float] | None] = {}
    for evaluation in evaluations:
        if evaluation.proposal.stage != "verification":
            search.append(evaluation)
            continue
        place = tuple(evaluation.proposal.parameters.values())
        if place not in shifts:
            shifts[place] = _shift(problem, answer, evaluation.proposal.parameters, describe)
        shift = shifts[place]
        if shift is None:
            continue
        near.append(evaluation)
        ignored = stale.get(evaluation.proposal.seed, ())
        for name, response in evaluation.responses.items():
            if name in values and name not in ignored:
                values[name][evaluation.proposal.seed] = response.value + shift[name]
    return FreshRuns(
        values,
        near,
        search,
        repeats_records=not repetitions.deterministic
        and any(one.proposal.seed in stale for one in near),
        deterministic=repetitions.deterministic,
    )


def _shift(
    problem: Problem,
    answer: Answer,
    parameters: Mapping[str, float],
    describe: Callable[[Mapping[str, float]], Answer],
) -> dict[str, float] | None:
    """Return the differences of expected responses to the answer; None if it is not near."""
    if parameters == answer.parameters:
        return dict.fromkeys(answer.predicted, 0.0)
    apart = problem.to_unit(parameters) - problem.to_unit(answer.parameters)
    if max(map(abs, apart)) > VERDICT.near_parameters:
        return None
    there = describe(parameters)
    shift = {name: value - there.predicted[name] for name, value in answer.predicted.items()}
    far = any(abs(shift[t.name]) > VERDICT.near_responses * t.tolerance for t in problem.targets)
    return None if far else shift


def mean_with_interval(values: Sequence[float]) -> Verified:
    """Return mean, standard error and 95 % confidence interval of at least two values."""
    error = stdev(values) / sqrt(len(values))
    quantile = float(stdtrit(len(values) - 1, 0.975))
    return Verified(fmean(values), error, quantile * error, len(values))
