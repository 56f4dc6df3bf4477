"""Evaluations without repetitions of the same run."""

from __future__ import annotations

from collections.abc import Iterable

from grainfit.evaluation import Evaluation, Response


def distinct_runs(evaluations: Iterable[Evaluation]) -> list[Evaluation]:
    """Return evaluations without repetitions of the same run, where their runs were made.

    A run that is both known from a warm start and proposed is one run, and so are rows of a table
    that were read for other parameters. Counted twice, they would make the scatter of runs look
    small.
    """
    # Tests that were evaluated with some parameters and a seed; None stands for every test.
    seen: dict[tuple[float, ...], set[str | None]] = {}
    kept: list[Evaluation] = []
    given: set[tuple[object, ...]] = set()
    for asked, evaluation in ((one, part) for one in evaluations for part in one.placed()):
        proposal = evaluation.proposal
        place = (*proposal.parameters.values(), *sorted(evaluation.responses.items(), key=_name))
        if asked.made_at and place in given:
            continue
        given.add(place)
        tests = set[str | None](proposal.tests or (None,))
        earlier = seen.setdefault((*proposal.parameters.values(), proposal.seed), set())
        if None in earlier or tests <= earlier:
            continue
        repeated = [test for test in earlier if test is not None]
        kept.append(evaluation.without(repeated) if repeated else evaluation)
        earlier |= tests
    return kept


def _name(response: tuple[str, Response]) -> str:
    return response[0]
