"""Verification: what the answer really gives, by fresh seeds that nothing was fitted to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from statistics import fmean, stdev

from scipy.stats import t as student_t

from grainfit.campaign.evaluation import Evaluation
from grainfit.problem import Problem, Target

#: Fresh seeds in a round of verification, at least.
VERIFICATION_RUNS = 5
#: Most rounds of verification runs at one answer.
ROUNDS = 4


def usual_verification_runs(workers: int) -> int:
    """Fresh seeds in a round where the user does not say: five, and no few workers left idle.

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

    def within(self, target: Target) -> bool:
        """Whether the mean meets the target within tolerance."""
        return abs(self.mean - target.value) <= target.accepted_deviation

    def undecided(self, target: Target) -> bool:
        """Whether the mean is outside, but could be inside as far as the runs can tell."""
        deviation = abs(self.mean - target.value)
        return target.accepted_deviation < deviation <= target.accepted_deviation + self.half_width


def verified_responses(problem: Problem, runs: Iterable[Evaluation]) -> dict[str, Verified]:
    """Means of the responses that at least two verification runs yielded."""
    known = list(runs)
    found = {}
    for target in problem.targets:
        values = [e.responses[target.name].value for e in known if target.name in e.responses]
        if len(values) >= 2:
            found[target.name] = mean_with_interval(values)
    return found


def mean_with_interval(values: Sequence[float]) -> Verified:
    """Mean, standard error and 95 % confidence interval of at least two values."""
    error = stdev(values) / sqrt(len(values))
    quantile = float(student_t.ppf(0.975, len(values) - 1))
    return Verified(fmean(values), error, quantile * error)


def meets_targets(problem: Problem, verified: Mapping[str, Verified]) -> bool:
    """Whether every target is verified and met within tolerance."""
    return all(
        target.name in verified and verified[target.name].within(target)
        for target in problem.targets
    )


def needs_more_runs(problem: Problem, verified: Mapping[str, Verified]) -> bool:
    """Whether further seeds could still turn the verdict.

    That is so when some target is missed by less than the runs can tell, and none clearly.
    """
    missed = [
        target
        for target in problem.targets
        if target.name not in verified or not verified[target.name].within(target)
    ]
    return bool(missed) and all(
        target.name in verified and verified[target.name].undecided(target) for target in missed
    )
