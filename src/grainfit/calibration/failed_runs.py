"""Failed runs: whether others would fail as well, and where and why they have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grainfit.calibration import messages
from grainfit.evaluation import Evaluation
from grainfit.formatting import alike, rounded_off, value_with_unit
from grainfit.problem import Problem, TestScope

#: Failed runs without a success after which others would fail, too: for one reason, for several.
_MOST_EQUAL_FAILURES, _MOST_FAILURES = 3, 8
#: Fewer failures may be chance.
_FEWEST = 3
#: Share of failures above which they are said even where no parameter explains them.
_MANY = 0.25


def would_all_fail(tried: Sequence[Evaluation]) -> bool:
    """Return True if so many runs failed that others would fail as well.

    Parameters
    ----------
    tried : sequence of Evaluation
        Runs of which none has given what is needed.
    """
    return len(tried) >= (_MOST_EQUAL_FAILURES if _causes(tried) == 1 else _MOST_FAILURES)


def fail_by_machine(ended: Sequence[Evaluation]) -> Sequence[Evaluation]:
    """Return the last runs if the machine failed them all for one reason, after all retries.

    Parameters
    ----------
    ended : sequence of Evaluation
        Runs in the order in which they ended.

    Returns
    -------
    sequence of Evaluation
        Empty if there is hope for the next run.
    """
    latest = ended[-_MOST_EQUAL_FAILURES:]
    is_alike = len(latest) == _MOST_EQUAL_FAILURES and _causes(latest) == 1
    return latest if is_alike and all(one.failed_by_machine for one in latest) else ()


def _causes(evaluations: Sequence[Evaluation]) -> int:
    """Return the number of causes of failures: those that differ in numbers only are one."""
    return len(alike("; ".join(evaluation.failures.values()) for evaluation in evaluations))


def about_failed_runs(problem: Problem, evaluations: Sequence[Evaluation]) -> Iterator[str]:
    """Say how many runs of each test have failed, if many or on one side of a parameter.

    Parameters
    ----------
    problem : Problem
        Tests, and the parameters that they read.
    evaluations : sequence of Evaluation
        All runs. Those that failed by the machine do not count.
    """
    telling = [e for e in evaluations if not e.failed_by_machine]
    for scope in problem.scopes:
        own = [e for e in telling if e.proposal.asks_for(scope.name)]
        failed = [e for e in own if e.failed_in(scope.name)]
        fine = [e for e in own if not e.failed_in(scope.name)]
        if len(failed) < _FEWEST or not fine:
            continue
        where = _on_one_side(problem, scope, failed, fine)
        if where is None and len(failed) < _MANY * len(own):
            continue
        why = alike(e.why_failed(scope.name) or "" for e in failed)[0][0]
        yield messages.RUNS_FAILED(
            failed=len(failed),
            runs=len(own),
            test=f" of {scope.name}" if scope.name else "",
            where=f", all with {where}" if where else "",
            why=why,
        )


def _on_one_side(
    problem: Problem, scope: TestScope, failed: Sequence[Evaluation], fine: Sequence[Evaluation]
) -> str | None:
    """Return the parameter that parts the runs that failed from all others, with its limit."""
    for parameter in problem.parameters:
        if parameter.name not in scope.parameters:
            continue
        bad, good = (
            [e.proposal.parameters[parameter.name] for e in some] for some in (failed, fine)
        )
        if min(bad) > max(good):
            limit = value_with_unit(rounded_off(min(bad), 3, up=False), parameter.unit)
            return messages.AT_OR_ABOVE(parameter=parameter.name, limit=limit)
        if max(bad) < min(good):
            limit = value_with_unit(rounded_off(max(bad), 3, up=True), parameter.unit)
            return messages.AT_OR_BELOW(parameter=parameter.name, limit=limit)
    return None
