"""Verify an answer by runs with fresh seeds at exactly its parameters.

The answer is frozen before its first fresh seed. They go into the metamodels like all others, but
what they are compared with is what the metamodels expect without them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt
from statistics import fmean, stdev, variance

from scipy.special import stdtrit

from grainfit.calibration.repetitions import Repetitions
from grainfit.errors import RunFailedError
from grainfit.evaluation import Evaluation
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Problem
from grainfit.verdict.evidence import Expected, Scatter, Verified
from grainfit.verdict.reasons import NoRecordThere


@dataclass(frozen=True)
class FreshRuns:
    """Responses of fresh seeds at the answer.

    Parameters
    ----------
    values : mapping of str to mapping of int to float
        By name of the target and seed of the run.
    evaluations : sequence of Evaluation
        The runs themselves, failed ones included.
    search : sequence of Evaluation
        The runs that verify nothing: where there are none at the answer, they tell how many fail.
    expected : mapping of str to Expected
        What the runs without these lead to expect, outlying ones left out; empty where they are
        too few.
    scatter : mapping of str to Scatter
        Scatter of runs with equal parameters, by name of the target.
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
    expected: Mapping[str, Expected] = field(default_factory=dict)
    scatter: Mapping[str, Scatter] = field(default_factory=dict)
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

    def verified(
        self, outlying: Mapping[str, Collection[int]] | None = None
    ) -> dict[str, Verified]:
        """Return the means of the responses that at least two fresh seeds gave.

        Parameters
        ----------
        outlying : mapping of str to collection of int, optional
            Seeds of outlying runs by name of the target. They are left out of a mean, unless half
            of its runs or more would be.
        """
        found = {}
        for name, values in self.values.items():
            out = (outlying or {}).get(name, ())
            typical = [value for seed, value in values.items() if seed not in out]
            kept = typical if 2 * len(typical) > len(values) else list(values.values())
            if len(kept) >= 2:
                found[name] = mean_with_interval(kept)
        return found


def fresh_runs(
    problem: Problem,
    parameters: Mapping[str, float],
    evaluations: Iterable[Evaluation],
    repetitions: Repetitions | None = None,
    spent: Collection[int] = (),
) -> FreshRuns:
    """Return the runs with fresh seeds at a parameter set.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    parameters : mapping of str to float
        The answer.
    evaluations : iterable of Evaluation
        All runs.
    repetitions : Repetitions, optional
        Runs that are no evidence of their own.
    spent : collection of int
        Seeds of runs at the answer that have contradicted the others: they are known now, and
        fresh no more.
    """
    repetitions = repetitions or Repetitions()
    stale = repetitions.stale
    values: dict[str, dict[int, float]] = {target.name: {} for target in problem.targets}
    there: list[Evaluation] = []
    others: list[Evaluation] = []
    for evaluation in evaluations:
        seed = evaluation.proposal.seed
        is_fresh = evaluation.proposal.stage == "verification" and seed not in spent
        if not is_fresh or evaluation.proposal.parameters != parameters:
            if not repetitions.is_known(evaluation):
                others.append(evaluation)
            continue
        there.append(evaluation)
        ignored = stale.get(seed, ())
        for name, response in evaluation.responses.items():
            if name in values and name not in ignored:
                values[name][seed] = response.value
    return FreshRuns(
        values,
        there,
        [one for one in others if one.proposal.stage != "verification"],
        _expected(problem, parameters, others) if there else {},
        _scatter(problem, [*others, *there]),
        repeats_records=not repetitions.deterministic
        and any(one.proposal.seed in stale for one in there),
        deterministic=repetitions.deterministic,
    )


def _expected(
    problem: Problem, parameters: Mapping[str, float], others: Sequence[Evaluation]
) -> dict[str, Expected]:
    try:
        metamodels = Metamodels.fit(problem, others)
    except RunFailedError:
        return {}
    means, variances = metamodels.predict_without_outliers([problem.to_unit(parameters)])
    names = [target.name for target in problem.targets]
    found = zip(names, means[0].tolist(), variances[0].tolist(), strict=True)
    return {name: Expected(mean, sqrt(variance)) for name, mean, variance in found}


def _scatter(problem: Problem, evaluations: Sequence[Evaluation]) -> dict[str, Scatter]:
    """Return the pooled scatter of runs with equal parameters."""
    found = {}
    for target in problem.targets:
        places: dict[tuple[float, ...], list[float]] = {}
        for one in evaluations:
            if target.name in one.responses:
                place = tuple(one.proposal.parameters.values())
                places.setdefault(place, []).append(one.responses[target.name].value)
        repeated = [values for values in places.values() if len(values) > 1]
        freedom = sum(len(values) - 1 for values in repeated)
        if freedom > 1:
            squares = sum((len(values) - 1) * variance(values) for values in repeated)
            found[target.name] = Scatter(sqrt(squares / freedom), freedom)
    return found


def mean_with_interval(values: Sequence[float]) -> Verified:
    """Return mean, standard error and 95 % confidence interval of at least two values."""
    error = stdev(values) / sqrt(len(values))
    quantile = float(stdtrit(len(values) - 1, 0.975))
    return Verified(fmean(values), error, quantile * error, len(values))
