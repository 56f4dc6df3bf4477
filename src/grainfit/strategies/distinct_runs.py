"""Evaluations without repetitions of the same run."""

from __future__ import annotations

from collections.abc import Iterable

from grainfit.evaluation import Evaluation


def distinct_runs(evaluations: Iterable[Evaluation]) -> list[Evaluation]:
    """Return evaluations without repetitions of the same run.

    A run that is both known from a warm start and proposed is one run. Counted twice, it would make
    the scatter of runs look small.
    """
    seen: dict[tuple[float, ...], Evaluation] = {}
    for evaluation in evaluations:
        proposal = evaluation.proposal
        seen.setdefault((*proposal.parameters.values(), proposal.seed), evaluation)
    return list(seen.values())
