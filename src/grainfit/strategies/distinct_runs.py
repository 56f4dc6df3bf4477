"""Evaluations without repetitions of the same run."""

from __future__ import annotations

from collections.abc import Iterable

from grainfit.evaluation import Evaluation


def distinct_runs(evaluations: Iterable[Evaluation]) -> list[Evaluation]:
    """Return evaluations without repetitions of the same run.

    A run that is both known from a warm start and proposed is one run. Counted twice, it would make
    the scatter of runs look small.
    """
    # Tests that were evaluated with some parameters and a seed; None stands for every test.
    seen: dict[tuple[float, ...], set[str | None]] = {}
    kept = []
    for evaluation in evaluations:
        proposal = evaluation.proposal
        tests = set[str | None](proposal.tests or (None,))
        earlier = seen.setdefault((*proposal.parameters.values(), proposal.seed), set())
        if None in earlier or tests <= earlier:
            continue
        repeated = [test for test in earlier if test is not None]
        kept.append(evaluation.without(repeated) if repeated else evaluation)
        earlier |= tests
    return kept
