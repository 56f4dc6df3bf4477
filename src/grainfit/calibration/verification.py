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

from scipy.stats import t as student_t

from grainfit.evaluation import Evaluation
from grainfit.formatting import number, rounded, unit_for_people, with_unit
from grainfit.problem import Problem, Target
from grainfit.strategies.answer import Answer

#: Default number of fresh seeds at, or very near, the answer. Two could agree by chance.
VERIFICATION_RUNS = 3
#: Most fresh seeds in all that a close call is worth.
MOST_FRESH = 20
#: Largest difference in any parameter, as a share of its interval, and in any expected response,
#: in tolerances, of a parameter set that counts as very near.
_NEAR_PARAMETERS, _NEAR_RESPONSES = 0.1, 0.5
#: Scatter of a response, in tolerances, up to which two runs agree by chance with the same error
#: once in 10,000 times; and the number of fresh seeds that it needs.
_QUIET, _FEWEST_QUIET = 0.25, 2
#: Standard errors between fresh seeds and all runs that contradict each other. By chance it
#: happens in 3 of 1,000 checks.
_CONTRADICTION = 3.0
#: Deviation in tolerances that contradicts nothing: without scatter, any is significant.
_NEGLIGIBLE = 0.01


@dataclass(frozen=True)
class Verified:
    """Mean of a response over the verification runs.

    Parameters
    ----------
    mean, standard_error : float
        Over the runs.
    half_width : float
        Half of the 95 % confidence interval of the mean (Student's t).
    runs : int
        Number of runs.
    """

    mean: float
    standard_error: float
    half_width: float
    runs: int


@dataclass(frozen=True)
class Contradiction:
    """A target for which the fresh seeds do not agree with what all runs together say.

    Parameters
    ----------
    target : Target
        The target.
    verified : Verified
        Mean of the verification runs.
    expected : float
        Response at the answer expected from all runs, including those of the verification.
    """

    target: Target
    verified: Verified
    expected: float

    def __str__(self) -> str:
        found = rounded(self.verified.mean, self.verified.half_width)
        expected = with_unit(number(self.expected, 4), unit_for_people(self.target.unit))
        return (
            f"{self.target.name} is in doubt: the {self.verified.runs} fresh seeds at the answer "
            f"give {found} on average, where all runs together lead to expect {expected}. The "
            "metamodel misses something there: more runs would tell."
        )


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
    """

    values: Mapping[str, Mapping[int, float]]
    evaluations: Sequence[Evaluation]
    search: Sequence[Evaluation] = ()

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
    """
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
        for name, response in evaluation.responses.items():
            if name in values:
                values[name][evaluation.proposal.seed] = response.value + shift[name]
    return FreshRuns(values, near, search)


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
    if max(map(abs, apart)) > _NEAR_PARAMETERS:
        return None
    there = describe(parameters)
    shift = {name: value - there.predicted[name] for name, value in answer.predicted.items()}
    far = any(abs(shift[t.name]) > _NEAR_RESPONSES * t.tolerance for t in problem.targets)
    return None if far else shift


def lacking_runs(problem: Problem, answer: Answer, fresh: FreshRuns, fewest: int) -> dict[str, int]:
    """Return how many runs with fresh seeds an answer lacks, by name of the test.

    Parameters
    ----------
    problem : Problem
        Parameters, targets, and tests.
    answer : Answer
        The answer.
    fresh : FreshRuns
        Runs at or very near the answer.
    fewest : int
        Number of fresh seeds without which no answer is calibrated. One of several tests needs two
        where its responses scatter little.
    """
    lacking = {}
    for scope in problem.scopes:
        targets = [target for target in problem.targets if target.name in scope.targets]
        quiet = bool(problem.tests) and all(_is_quiet(target, answer) for target in targets)
        made = min((len(fresh.values[target.name]) for target in targets), default=0)
        lacking[scope.name] = max(0, (min(fewest, _FEWEST_QUIET) if quiet else fewest) - made)
    return lacking


def _is_quiet(target: Target, answer: Answer) -> bool:
    quality = answer.quality.get(target.name)
    return quality is not None and quality.noise <= _QUIET * target.tolerance


def mean_with_interval(values: Sequence[float]) -> Verified:
    """Return mean, standard error and 95 % confidence interval of at least two values."""
    error = stdev(values) / sqrt(len(values))
    quantile = float(student_t.ppf(0.975, len(values) - 1))
    return Verified(fmean(values), error, quantile * error, len(values))


def contradictions(
    problem: Problem, verified: Mapping[str, Verified], answer: Answer
) -> list[Contradiction]:
    """Return the targets for which the fresh seeds contradict all runs together.

    The fresh seeds are a part of all runs, so the variance of the difference is that of their mean
    less that of the expectation.
    """
    found = []
    for target in problem.targets:
        check = verified.get(target.name)
        quality = answer.quality.get(target.name)
        if check is None or quality is None:
            continue
        of_mean = quality.noise**2 / check.runs
        # An expectation that rests on little else than the fresh seeds cannot contradict them.
        difference = max(of_mean - answer.standard_errors[target.name] ** 2, 0.1 * of_mean)
        expected = answer.predicted[target.name]
        negligible = _NEGLIGIBLE * target.tolerance
        if abs(check.mean - expected) > max(_CONTRADICTION * sqrt(difference), negligible):
            found.append(Contradiction(target, check, expected))
    return found
