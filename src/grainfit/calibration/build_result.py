"""Build the `Result` of a calibration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.calibration import messages
from grainfit.calibration.failed_runs import about_failed_runs
from grainfit.calibration.judged_answer import JudgedAnswer
from grainfit.calibration.verification import FreshRuns
from grainfit.evaluation import Evaluation
from grainfit.formatting import number, unit_for_people, with_unit
from grainfit.metamodels.blow_ups import about_blow_ups
from grainfit.metamodels.curve_reduction import ComponentTarget, CurveBasis, about_short_curves
from grainfit.metamodels.hyperparameters import RUNS_OF_KNOWN_SCATTER
from grainfit.problem import Problem, Target
from grainfit.result import CurveResult, ResponseResult, Result, RunCounts, RunSummary
from grainfit.strategies.answer import Answer
from grainfit.strategies.base import Search
from grainfit.student import LEVEL
from grainfit.verdict.reasons import Reason
from grainfit.verdict.rule import Status


@dataclass(frozen=True)
class Ending:
    """End of a calibration: its name and identity, duration, use of the workers, and status."""

    name: str
    identity: str
    wall_seconds: float
    utilisation: float
    status: Status


def make_result(
    ending: Ending,
    search: Search,
    outcome: JudgedAnswer | None,
    evaluations: Sequence[Evaluation],
    known: int = 0,
) -> Result:
    """Build the result of a calibration.

    Parameters
    ----------
    ending : Ending
        Name, identity, duration and status.
    search : Search
        The search that has ended.
    outcome : JudgedAnswer or None
        The answer and the verdict; None if the calibration was interrupted before there was one.
    evaluations : sequence of Evaluation
        All parameter sets that were simulated.
    known : int
        Number of earlier runs used for the warm start.
    """
    problem = search.current_problem
    if outcome:
        problem, _ = outcome.answer.reduced(problem, ())
    rayleigh = problem.rayleigh
    middle = search.problem.middle
    answer = outcome.answer if outcome else None
    parameters = dict(answer.parameters) if answer else {}
    notices = [*search.notices]
    short = [about_short_curves(curve, evaluations) for curve in search.problem.curves]
    notices += filter(None, short)
    notices += about_blow_ups(search.problem, evaluations)
    notices += about_failed_runs(search.problem, evaluations)
    notices += _scatter_notices(search.problem)
    if outcome:
        notices += _failure_notices(outcome.fresh.evaluations)
    return Result(
        status=ending.status,
        parameters=parameters,
        responses=_responses(problem, outcome) if outcome else {},
        curves=_curves(outcome) if outcome else {},
        runs=_counts(evaluations, known),
        rayleigh_time_step=problem.rayleigh_time_step(parameters) if answer else None,
        rayleigh_time_step_before=problem.rayleigh_time_step(middle),
        rayleigh_time_step_limits=rayleigh.limits(problem.intervals) if rayleigh else None,
        wall_seconds=ending.wall_seconds,
        utilisation=ending.utilisation,
        probability_all_met=answer.probability_all_met if answer else None,
        name=ending.name,
        identity=ending.identity,
        strategy=search.name,
        seed=search.seed,
        version=version("grainfit"),
        units={parameter.name: parameter.unit for parameter in problem.parameters},
        out_of_reach=answer.out_of_reach if answer else (),
        metamodels=answer.quality if answer else {},
        reasons=_reasons(outcome, ending.status) if outcome else (),
        other_notices=tuple(notices),
        history=tuple(_summary(evaluation) for evaluation in evaluations),
    )


def _reasons(outcome: JudgedAnswer, status: Status) -> tuple[Reason, ...]:
    """Return the reasons; what would decide an undecided answer is none of an interrupted one."""
    if status != "interrupted":
        return outcome.reasons
    interrupted = replace(outcome.judgement, status=status)
    return replace(outcome, judgement=interrupted).reasons


def _responses(problem: Problem, outcome: JudgedAnswer) -> dict[str, ResponseResult]:
    return {
        target.name: _response(target, outcome)
        for target in problem.targets
        if not isinstance(target, ComponentTarget)
    }


def _curves(outcome: JudgedAnswer) -> dict[str, CurveResult]:
    bases = outcome.answer.reduction.bases if outcome.answer.reduction else ()
    return {basis.target.name: _curve(basis, outcome) for basis in bases}


def _curve(basis: CurveBasis, outcome: JudgedAnswer) -> CurveResult:
    answer, measured = outcome.answer, basis.target
    scores = np.array([answer.predicted[name] for name in basis.names])
    errors = np.array([answer.standard_errors[name] for name in basis.names])
    expected, standard_errors = basis.expected(scores, errors**2)
    uncertainties = measured.standard_uncertainties
    off = (expected - np.asarray(measured.values)) / uncertainties
    probability = min(answer.probabilities[name] for name in basis.names)
    fresh = _fresh_curves(basis, outcome.fresh)
    return CurveResult(
        coordinate=measured.coordinate,
        coordinate_unit=measured.coordinate_unit,
        unit=measured.unit,
        coordinates=tuple(measured.coordinates),
        measured=tuple(measured.values),
        uncertainties=tuple(uncertainties.tolist()),
        expected=tuple(expected.tolist()),
        standard_errors=tuple(standard_errors.tolist()),
        components=len(basis.names),
        deviation=float(np.sqrt((off**2).mean())),
        probability=probability,
        shape_probability=basis.shape_probability,
        verdict=outcome.judgement.curves[measured.name],
        verified_runs=len(fresh),
        **_mean_of_curves(fresh),
    )


def _fresh_curves(basis: CurveBasis, fresh: FreshRuns) -> NDArray[np.float64]:
    """Return the curves of fresh seeds, shape (runs, n)."""
    first = basis.names[0]
    found = []
    for run in fresh.evaluations:
        values = basis.values_of(run)
        if values is not None and run.proposal.seed in fresh.values[first]:
            found.append(values)
    return np.array(found).reshape(len(found), len(basis.target.values))


def _mean_of_curves(curves: NDArray[np.float64]) -> dict[str, Any]:
    if len(curves) < 2:
        return {}
    errors = curves.std(axis=0, ddof=1) / np.sqrt(len(curves))
    mean = curves.mean(axis=0)
    return {
        "verified_mean": tuple(mean.tolist()),
        "verified_standard_errors": tuple(errors.tolist()),
    }


def _response(target: Target, outcome: JudgedAnswer) -> ResponseResult:
    answer, name = outcome.answer, target.name
    probability = answer.probabilities[name]
    share = target.relative_deviation(answer.predicted[name])
    verified = outcome.fresh.verified().get(name)
    return ResponseResult(
        target=target.value,
        tolerance=target.tolerance,
        unit=target.unit,
        predicted=answer.predicted[name],
        standard_error=answer.standard_errors[name],
        probability=probability,
        verified_mean=verified.mean if verified else None,
        verified_standard_error=verified.standard_error if verified else None,
        verified_interval=verified.half_width if verified else None,
        verified_values=tuple(outcome.fresh.values[name].values()),
        verified_seeds=tuple(outcome.fresh.values[name]),
        jams_not_excluded=_jams_not_excluded(answer, name),
        deviation_percent=None if share is None else 100 * share,
        verdict=outcome.judgement.responses[name],
    )


def _jams_not_excluded(answer: Answer, name: str) -> float | None:
    """Return the largest share of jams at the answer that its runs do not exclude."""
    runs = answer.runs.get(name, 0)
    if not runs or name in answer.outliers:
        return None
    return float(1 - (1 - LEVEL) ** (1 / runs))


def _counts(evaluations: Sequence[Evaluation], known: int) -> RunCounts:
    def runs(stage: str) -> int:
        return sum(len(e.runs) for e in evaluations if e.proposal.stage == stage)

    return RunCounts(
        design=runs("design"),
        optimisation=runs("optimisation"),
        verification=runs("verification"),
        failed=sum(len(e.failed_runs) for e in evaluations),
        reused=sum(e.reused for e in evaluations),
        total=sum(len(e.runs) for e in evaluations),
        warm_start_runs=known,
    )


def _scatter_notices(problem: Problem) -> Iterator[str]:
    """Name the scatters that are known before the runs."""
    known = [
        f"{target.name} {with_unit(number(problem.scatters[target.name], 2), unit)}"
        for target in problem.targets
        if target.name in problem.scatters
        for unit in [unit_for_people(target.unit)]
    ]
    if known:
        yield messages.KNOWN_SCATTER(runs=RUNS_OF_KNOWN_SCATTER, scatters=", ".join(known))


def _failure_notices(verification: Sequence[Evaluation]) -> Iterator[str]:
    """Report failed verification runs."""
    reasons = [reason for e in verification for reason in e.failed_runs.values()]
    if reasons:
        ended = sum(len(e.runs) for e in verification)
        yield messages.VERIFICATION_FAILED(failed=len(reasons), ended=ended, why=reasons[-1])


def _summary(evaluation: Evaluation) -> RunSummary:
    return RunSummary(
        evaluation.proposal.stage,
        dict(evaluation.proposal.parameters),
        evaluation.proposal.seed,
        {name: response.value for name, response in evaluation.responses.items()},
        dict(evaluation.failures),
        dict(evaluation.runs),
    )
