"""Verdict on an answer, by the probability that it meets every target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grainfit.calibration.verification import Contradiction, FreshRuns, contradictions
from grainfit.problem import Problem
from grainfit.result import Status
from grainfit.strategies.answer import Answer


@dataclass(frozen=True)
class Outcome:
    """An answer, the fresh seeds at it, and the verdict on it.

    Parameters
    ----------
    answer : Answer
        The answer, with what all runs lead to expect.
    status : str
        The verdict, one of `grainfit.result.Status`.
    fresh : FreshRuns
        Runs that verify it.
    contradictions : sequence of Contradiction
        Targets for which they contradict all runs together.
    confidence : float
        Probability from which a target counts as met.
    """

    answer: Answer
    status: Status
    fresh: FreshRuns
    contradictions: Sequence[Contradiction]
    confidence: float


def judge(
    problem: Problem, answer: Answer, fresh: FreshRuns, confidence: float, fewest_fresh: int
) -> Outcome:
    """Judge an answer.

    It is calibrated when every expected response is within its tolerance with the demanded
    probability, by all runs, and enough fresh seeds at it do not contradict them.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    answer : Answer
        The answer, described by all runs.
    fresh : FreshRuns
        Runs with fresh seeds at or very near the answer.
    confidence : float
        Demanded probability.
    fewest_fresh : int
        Number of fresh seeds without which no answer is calibrated.
    """
    contradicted = contradictions(problem, fresh.verified(), answer)
    return Outcome(
        answer,
        _status(answer, confidence, bool(contradicted) or fresh.count < fewest_fresh),
        fresh,
        contradicted,
        confidence,
    )


def _status(answer: Answer, confidence: float, in_doubt: bool) -> Status:
    if answer.out_of_reach:
        return "unreachable"
    both = (answer.probability_all_met, answer.probability_without_outliers)
    if min(both) >= confidence and not in_doubt:
        return "calibrated"
    return "out_of_tolerance" if max(both) <= 1 - confidence else "undecided"
