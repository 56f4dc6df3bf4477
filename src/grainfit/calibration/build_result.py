"""Build the `Result` of a calibration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version

from grainfit.calibration.verification import Contradiction, Verified, verified_responses
from grainfit.evaluation import Evaluation
from grainfit.problem import Problem, Target
from grainfit.result import ResponseResult, Result, RunCounts, RunSummary, Status
from grainfit.strategies.answer import Answer, bound_at
from grainfit.strategies.base import Search


@dataclass(frozen=True)
class About:
    """Name, identity, duration, utilisation of the workers, and status of a calibration."""

    name: str
    identity: str
    wall_seconds: float
    utilisation: float
    status: Status


@dataclass(frozen=True)
class Verification:
    """The evaluations that verify an answer, and the contradictions to them by all runs."""

    runs: Sequence[Evaluation] = ()
    contradictions: Sequence[Contradiction] = ()


def make_result(
    about: About,
    strategy: Search,
    answer: Answer | None,
    evaluations: Sequence[Evaluation],
    verification: Verification,
    known: int = 0,
) -> Result:
    """Build the result of a calibration.

    Parameters
    ----------
    about : About
        Name, identity, duration and status.
    strategy : Search
        The search that has ended.
    answer : Answer or None
        The answer; None if the calibration was interrupted before there was one.
    evaluations : sequence of Evaluation
        All parameter sets that were simulated.
    verification : Verification
        Evaluations that verify the answer, and contradictions to them.
    known : int
        Number of earlier runs used for the warm start.
    """
    problem = strategy.current_problem
    rayleigh = problem.rayleigh
    middle = strategy.problem.from_unit([0.5] * problem.dimension)
    parameters = dict(answer.parameters) if answer else {}
    notices = [
        *strategy.notices,
        *map(str, verification.contradictions),
        *_failure_notices(verification.runs),
    ]
    if answer:
        notices += _edge_notices(problem, answer)
    return Result(
        status=about.status,
        parameters=parameters,
        responses=_responses(problem, answer, verification) if answer else {},
        runs=_counts(evaluations, known),
        rayleigh_time_step=problem.rayleigh_time_step(parameters) if answer else None,
        rayleigh_time_step_before=problem.rayleigh_time_step(middle),
        rayleigh_time_step_limits=rayleigh.limits(problem.intervals) if rayleigh else None,
        wall_seconds=about.wall_seconds,
        utilisation=about.utilisation,
        probability_all_met=answer.probability_all_met if answer else None,
        name=about.name,
        identity=about.identity,
        strategy=strategy.name,
        seed=strategy.seed,
        version=version("grainfit"),
        units={parameter.name: parameter.unit for parameter in problem.parameters},
        out_of_reach=answer.out_of_reach if answer else (),
        metamodels=answer.quality if answer else {},
        notices=tuple(notices),
        history=tuple(_summary(evaluation) for evaluation in evaluations),
    )


def _responses(
    problem: Problem, answer: Answer, verification: Verification
) -> dict[str, ResponseResult]:
    verified = verified_responses(problem, verification.runs)
    contradicted = {contradiction.target.name for contradiction in verification.contradictions}
    return {
        target.name: _response(
            target,
            answer,
            verified.get(target.name),
            # A target that the verification runs did not confirm is not met, even if predicted.
            refuted=target.name in contradicted
            or (bool(verification.runs) and target.name not in verified),
        )
        for target in problem.targets
    }


def _response(
    target: Target, answer: Answer, verified: Verified | None, *, refuted: bool
) -> ResponseResult:
    predicted = answer.predicted[target.name]
    best = verified.mean if verified else predicted
    close = abs(best - target.value) <= target.tolerance
    return ResponseResult(
        target=target.value,
        tolerance=target.tolerance,
        unit=target.unit,
        predicted=predicted,
        standard_error=answer.standard_errors[target.name],
        verified_mean=verified.mean if verified else None,
        verified_standard_error=verified.standard_error if verified else None,
        verified_interval=verified.half_width if verified else None,
        deviation_percent=100 * target.relative_deviation(best),
        within_tolerance=close and not refuted,
    )


def _counts(evaluations: Sequence[Evaluation], known: int) -> RunCounts:
    def runs(stage: str) -> int:
        return sum(len(e.runs) for e in evaluations if e.proposal.stage == stage)

    return RunCounts(
        design=runs("design"),
        optimisation=runs("optimisation"),
        verification=runs("verification"),
        failed=sum(len(e.failures) for e in evaluations),
        reused=sum(e.reused for e in evaluations),
        total=sum(len(e.runs) for e in evaluations),
        warm_start_runs=known,
    )


def _failure_notices(verification: Sequence[Evaluation]) -> Iterator[str]:
    """Report failed verification runs."""
    reasons = [reason for e in verification for reason in e.failures.values()]
    if reasons:
        yield (
            f"{len(reasons)} of {sum(len(e.runs) for e in verification)} verification runs "
            f"failed: {reasons[-1]}"
        )


def _edge_notices(problem: Problem, answer: Answer) -> Iterator[str]:
    """Report parameters whose answer, or region of agreement, reaches a bound."""
    for parameter in problem.parameters:
        on = bound_at(parameter.to_unit(answer.parameters[parameter.name]))
        bound = on or answer.cut_off.get(parameter.name)
        if bound is not None:
            value = parameter.minimum if bound == "min" else parameter.maximum
            where = "lies on" if on else "agrees up to"
            yield (
                f"{parameter.name} {where} its bound {bound} = {value:g}: a wider interval may "
                "fit better."
            )


def _summary(evaluation: Evaluation) -> RunSummary:
    return RunSummary(
        evaluation.proposal.stage,
        dict(evaluation.proposal.parameters),
        evaluation.proposal.seed,
        {name: response.value for name, response in evaluation.responses.items()},
        dict(evaluation.failures),
        dict(evaluation.runs),
    )
