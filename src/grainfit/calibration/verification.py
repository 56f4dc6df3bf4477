"""Verify an answer by runs with fresh seeds, to which nothing was fitted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from statistics import fmean, stdev

from scipy.stats import t as student_t

from grainfit.evaluation import Evaluation
from grainfit.formatting import number, rounded, unit_for_people, with_unit
from grainfit.metamodels.kriging import NORMAL_QUANTILE
from grainfit.problem import Problem, Target
from grainfit.strategies.answer import Answer

#: Smallest default number of fresh seeds in a round of verification.
VERIFICATION_RUNS = 5
#: Largest number of rounds of verification at one answer.
ROUNDS = 4


def usual_verification_runs(workers: int) -> int:
    """Return the default number of fresh seeds in a round: 5, or 6 or 8 to leave no worker idle.

    Examples
    --------
    >>> [usual_verification_runs(workers) for workers in (1, 2, 3, 8)]
    [5, 6, 6, 5]
    """
    if workers > VERIFICATION_RUNS:
        return VERIFICATION_RUNS
    return ceil(VERIFICATION_RUNS / workers) * workers


@dataclass(frozen=True)
class Verified:
    """Mean of a response over the verification runs.

    Parameters
    ----------
    mean, standard_error : float
        Over the runs.
    half_width : float
        Half of the 95 % confidence interval of the mean (Student's t).
    """

    mean: float
    standard_error: float
    half_width: float

    def is_met(self, target: Target) -> bool:
        """Whether the mean meets the target within tolerance."""
        return abs(self.mean - target.value) <= target.tolerance

    def is_marginally_met(self, target: Target) -> bool:
        """Whether the mean is inside the tolerance, but its 95 % interval is not."""
        deviation = abs(self.mean - target.value)
        return deviation <= target.tolerance < deviation + self.half_width

    def is_marginally_missed(self, target: Target) -> bool:
        """Whether the mean is outside the tolerance, but its 95 % interval reaches inside."""
        deviation = abs(self.mean - target.value)
        return target.tolerance < deviation <= target.tolerance + self.half_width


@dataclass(frozen=True)
class Contradiction:
    """A target that the verification runs meet marginally, and that all runs together miss.

    Parameters
    ----------
    target : Target
        The target.
    verified : Verified
        Mean of the verification runs; its interval reaches beyond the tolerance.
    expected, standard_error : float
        Response at the answer by the metamodel of all runs, including those of the verification.
    """

    target: Target
    verified: Verified
    expected: float
    standard_error: float

    def __str__(self) -> str:
        target, half_width = self.target, NORMAL_QUANTILE * self.standard_error
        alone = _interval(self.verified.mean, self.verified.half_width)
        together = _interval(self.expected, half_width)
        accepted = f"{number(target.value, 6)} ± {number(target.tolerance, 3)}"
        return (
            f"{target.name} is in doubt: the verification runs alone give {alone}, where "
            f"{with_unit(accepted, unit_for_people(target.unit))} is accepted, but by all runs "
            f"together {together} is expected."
        )


def _interval(middle: float, half_width: float) -> str:
    return f"{rounded(middle, half_width)} ± {number(half_width, 2)}"


def verified_responses(problem: Problem, runs: Iterable[Evaluation]) -> dict[str, Verified]:
    """Return the means of the responses that at least two verification runs gave."""
    known = list(runs)
    found = {}
    for target in problem.targets:
        values = [e.responses[target.name].value for e in known if target.name in e.responses]
        if len(values) >= 2:
            found[target.name] = mean_with_interval(values)
    return found


def mean_with_interval(values: Sequence[float]) -> Verified:
    """Return mean, standard error and 95 % confidence interval of at least two values."""
    error = stdev(values) / sqrt(len(values))
    quantile = float(student_t.ppf(0.975, len(values) - 1))
    return Verified(fmean(values), error, quantile * error)


def meets_targets(
    problem: Problem,
    verified: Mapping[str, Verified],
    contradicted: Sequence[Contradiction] = (),
) -> bool:
    """Return True if every target is verified and met within tolerance, and none in doubt."""
    return not contradicted and all(
        target.name in verified and verified[target.name].is_met(target)
        for target in problem.targets
    )


def marginally_met(problem: Problem, verified: Mapping[str, Verified]) -> list[Target]:
    """Return targets that the verification runs meet, but not with their whole 95 % interval."""
    return [
        target
        for target in problem.targets
        if target.name in verified and verified[target.name].is_marginally_met(target)
    ]


def contradictions(
    problem: Problem, verified: Mapping[str, Verified], known: Answer
) -> list[Contradiction]:
    """Return the targets that the verification runs meet marginally, and all runs together miss.

    An answer that is verified repeatedly until it passes finally passes by chance, and some pass
    by chance the first time. The runs of the search are evidence, too.

    Parameters
    ----------
    problem : Problem
        The calibration problem.
    verified : mapping of str to Verified
        Means of the verification runs.
    known : Answer
        Answer of all runs together at the same parameter set.
    """
    return [
        Contradiction(
            target,
            verified[target.name],
            known.predicted[target.name],
            known.standard_errors[target.name],
        )
        for target in marginally_met(problem, verified)
        if abs(known.predicted[target.name] - target.value) > target.tolerance
    ]


def needs_more_runs(
    problem: Problem,
    verified: Mapping[str, Verified],
    contradicted: Sequence[Contradiction] = (),
) -> bool:
    """Return True if further seeds could change the outcome.

    That is so if a target is missed marginally, or is met marginally while all runs together miss
    it, and no target is missed clearly.
    """
    missed = [
        target
        for target in problem.targets
        if target.name not in verified or not verified[target.name].is_met(target)
    ]
    return bool(missed or contradicted) and all(
        target.name in verified and verified[target.name].is_marginally_missed(target)
        for target in missed
    )
