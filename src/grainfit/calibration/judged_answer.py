"""Take the numbers of a verdict from the metamodels and the runs, and judge an answer by them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grainfit.calibration.repetitions import Repetitions
from grainfit.calibration.verification import FreshRuns, fresh_runs
from grainfit.evaluation import Evaluation
from grainfit.metamodels.curve_reduction import CurveBasis
from grainfit.metamodels.outliers import Outliers
from grainfit.problem import Problem, Target
from grainfit.strategies.answer import Answer
from grainfit.strategies.out_of_reach import miss_of
from grainfit.verdict.evidence import CurveEvidence, Evidence, TargetEvidence, Verified
from grainfit.verdict.out_of_reach import CurveMiss
from grainfit.verdict.reasons import NoisyCurve, NoRecordThere, OutlyingRuns, Reason
from grainfit.verdict.rule import Judgement, Status, judge, reasons_for


@dataclass(frozen=True)
class JudgedAnswer:
    """An answer, the fresh seeds at it, and the verdict on it.

    Parameters
    ----------
    answer : Answer
        The answer, with what all runs predict at it.
    fresh : FreshRuns
        Runs that verify it.
    evidence : Evidence
        The numbers on which the verdict rests.
    judgement : Judgement
        The verdict.
    """

    answer: Answer
    fresh: FreshRuns
    evidence: Evidence
    judgement: Judgement

    @property
    def status(self) -> Status:
        """The verdict on the whole answer."""
        return self.judgement.status

    @property
    def runs_to_confirm(self) -> float:
        """Runs at the answer that would confirm it, as far as is known; infinite if none would."""
        contradicted, confidence = self.judgement.contradicted, self.evidence.confidence
        doubted = [
            one
            for one in self.evidence.targets
            if one.name in contradicted or one.probability < confidence
        ]
        if any(one.is_deterministic and one.fresh is not None for one in doubted):
            # Another seed gives the same.
            return math.inf
        again = self.evidence.fewest_fresh if contradicted else 0
        return max(self.answer.runs_needed, again, *self.judgement.lacking.values())

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """The reasons for the verdict."""
        return tuple(reasons_for(self.evidence, self.judgement))


@dataclass(frozen=True)
class Demands:
    """What is demanded of an answer that is called calibrated.

    Parameters
    ----------
    confidence : float
        Probability that every target is met.
    fewest_fresh : int
        Number of fresh seeds.
    repeats : mapping of str to int
        Runs with different seeds whose mean is one evaluation, by name of the test.
    """

    confidence: float
    fewest_fresh: int
    repeats: Mapping[str, int]


def judge_by_runs(
    problem: Problem,
    answer: Answer,
    evaluations: Sequence[Evaluation],
    demands: Demands,
    repetitions: Repetitions | None = None,
    no_record: Sequence[NoRecordThere] = (),
) -> JudgedAnswer:
    """Judge an answer by all runs.

    Fresh seeds that contradict the others become known: those after them are compared with what
    all runs before lead to expect.

    Parameters
    ----------
    problem : Problem
        Parameters and targets, components for curves.
    answer : Answer
        The answer, described by all runs.
    evaluations : sequence of Evaluation
        All runs, a warm start included, those with fresh seeds in the order of their requests.
    demands : Demands
        What is demanded.
    repetitions : Repetitions, optional
        Runs that are no evidence of their own.
    no_record : sequence of NoRecordThere
        Tests whose runs are read from a table that has none at the answer.
    """
    spent: set[int] = set()
    while True:
        fresh = fresh_runs(problem, answer.parameters, evaluations, repetitions, spent)
        judged = judge_answer(problem, answer, replace(fresh, no_record=no_record), demands)
        contradicting = _first_contradicting(problem, judged, demands.fewest_fresh)
        if not contradicting:
            return judged
        spent |= contradicting


def _first_contradicting(problem: Problem, judged: JudgedAnswer, fewest: int) -> set[int]:
    """Return the seeds of the first fresh runs of contradicted tests, if others follow them."""
    found: set[int] = set()
    tests = {problem.scope_of(name).name for name in judged.judgement.contradicted}
    for test in tests - set(judged.fresh.deterministic):
        runs = [one for one in judged.fresh.evaluations if one.proposal.asks_for(test)]
        if len(runs) > fewest:
            found |= {one.proposal.seed for one in runs[:fewest]}
    return found


def judge_answer(
    problem: Problem,
    answer: Answer,
    fresh: FreshRuns,
    demands: Demands,
) -> JudgedAnswer:
    """Judge an answer, see `grainfit.verdict.rule`.

    Parameters
    ----------
    problem : Problem
        Parameters and targets, components for curves.
    answer : Answer
        The answer, described by all runs.
    fresh : FreshRuns
        Runs with fresh seeds at the answer.
    demands : Demands
        What is demanded.
    """
    # Compared with what the runs that belong together expect.
    verified = fresh.verified({name: found.seeds for name, found in answer.outliers.items()})
    bases = answer.reduction.bases if answer.reduction else ()
    failed, ended = fresh.failures
    pairs = problem.correlations
    evidence = Evidence(
        targets=[
            _of_target(problem, answer, fresh, verified, target, demands.repeats)
            for target in problem.targets
        ],
        curves=[_of_curve(basis, answer, verified) for basis in bases],
        out_of_reach=answer.out_of_reach,
        probability_all_met=answer.probability_all_met,
        probability_without_outliers=answer.probability_without_outliers,
        confidence=demands.confidence,
        fewest_fresh=demands.fewest_fresh,
        runs_needed=answer.runs_needed,
        failed=failed,
        ended=ended,
        is_verified=bool(fresh.evaluations),
        correlated=tuple(dict.fromkeys(name for pair in pairs for name in pair[:2])),
        tests={scope.name: scope.targets for scope in problem.scopes},
        has_several_tests=bool(problem.tests),
        no_record=fresh.no_record,
        repeats_records=fresh.repeats_records,
        deterministic=tuple(s.name for s in problem.scopes if s.name in fresh.deterministic),
    )
    return JudgedAnswer(answer, fresh, evidence, judge(evidence))


def _of_target(
    problem: Problem,
    answer: Answer,
    fresh: FreshRuns,
    verified: Mapping[str, Verified],
    target: Target,
    repeats: Mapping[str, int],
) -> TargetEvidence:
    name = target.name
    values = list(fresh.values[name].values())
    is_deterministic = problem.scope_of(name).name in fresh.deterministic
    only = Verified(values[0], 0.0, 0.0, 1) if is_deterministic and values else None
    quality, outliers = answer.quality.get(name), answer.outliers.get(name)
    curves = answer.reduction.bases if answer.reduction else ()
    return TargetEvidence(
        name,
        target.unit,
        target.value,
        target.tolerance,
        target.is_relative,
        answer.predicted[name],
        answer.standard_errors[name],
        answer.probabilities[name],
        noise=None if quality is None else quality.noise,
        fresh=verified.get(name, only),
        others=fresh.expected.get(name),
        repeated=fresh.scatter.get(name),
        fresh_seeds=len(values),
        repeats=_repeats(problem, target, repeats),
        noise_range=None if quality is None else quality.noise_range,
        has_two_states=quality is not None and quality.has_two_states,
        # Another seed changes nothing there: what does not belong to the others is a regime.
        outlying=_outlying(target, outliers) if outliers and not is_deterministic else None,
        curve=next((basis.target.name for basis in curves if name in basis.names), ""),
        is_deterministic=is_deterministic,
        has_trend=name not in answer.without_trend,
    )


def _repeats(problem: Problem, target: Target, repeats: Mapping[str, int]) -> int:
    """Return the runs of one evaluation of the test of a target."""
    if not repeats:
        return 1
    # Without scopes, all tests are evaluated together.
    return repeats.get(problem.scope_of(target.name).name, max(repeats.values()))


def _outlying(target: Target, found: Outliers) -> OutlyingRuns:
    largest = max(found.residuals, key=abs)
    return OutlyingRuns(
        target.name,
        target.unit,
        found.runs,
        tuple(found.seeds),
        largest,
        found.repeated,
        found.came_again,
    )


def _of_curve(basis: CurveBasis, answer: Answer, verified: Mapping[str, Verified]) -> CurveEvidence:
    return CurveEvidence(
        basis.target.name,
        basis.has_other_shape,
        basis.shape_probability,
        _noise_of_curve(basis, answer),
        _fresh_miss(basis, answer, verified),
    )


def _noise_of_curve(basis: CurveBasis, answer: Answer) -> NoisyCurve | None:
    if not answer.quality.keys() >= set(basis.names):
        return None
    noises = np.array([answer.quality[name].noise for name in basis.names])
    target = basis.target
    _, spread = basis.expected(np.zeros(len(noises)), noises**2)
    ratios = spread / target.standard_uncertainties
    return NoisyCurve(
        target.name,
        float(np.sqrt((ratios**2).mean())),
        float(target.coordinates[int(ratios.argmax())]),
        target.coordinate,
        target.coordinate_unit,
    )


def _fresh_miss(
    basis: CurveBasis, answer: Answer, verified: Mapping[str, Verified]
) -> CurveMiss | None:
    """Return how far the mean of the fresh seeds is from the expected curve."""
    if not verified.keys() >= set(basis.names):
        return None
    scores: tuple[Sequence[float], ...] = (
        [answer.predicted[name] for name in basis.names],
        [verified[name].mean for name in basis.names],
    )
    nothing = np.zeros(len(basis.names))
    wanted, found = (basis.expected(np.array(along), nothing)[0] for along in scores)
    return miss_of(basis.target, wanted, found)
