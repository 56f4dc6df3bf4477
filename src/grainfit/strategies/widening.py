"""Wider intervals, where the given ones do not hold a target."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from grainfit.problem import Parameter, Problem
from grainfit.strategies.answer import OutOfReach


def widened(problem: Problem, misses: Iterable[OutOfReach]) -> Problem:
    """The same problem with every bound that is in the way moved to where it should do.

    Parameters
    ----------
    problem : Problem
        With the intervals that are too narrow.
    misses : iterable of OutOfReach
        Those without a suggestion change nothing.
    """
    bounds = {p.name: (p.minimum, p.maximum) for p in problem.parameters}
    for miss in misses:
        if miss.parameter is None or miss.suggestion is None:
            continue
        low, high = bounds[miss.parameter]
        bounds[miss.parameter] = (min(low, miss.suggestion), max(high, miss.suggestion))
    parameters = [_with_bounds(p, *bounds[p.name]) for p in problem.parameters]
    return replace(problem, parameters=parameters)


def _with_bounds(parameter: Parameter, low: float, high: float) -> Parameter:
    # A parameter that was positive everywhere stays so: a friction below zero is no material.
    if low <= 0 < parameter.minimum:
        low = parameter.minimum
    return replace(parameter, minimum=low, maximum=high)


def widenings(before: Problem, after: Problem) -> list[str]:
    """Say in words which bounds were moved."""
    return [
        f"{old.name}.{key} = {was:g} was in the way and has been moved to {now:g}."
        for old, new in zip(before.parameters, after.parameters, strict=True)
        for key, was, now in (
            ("min", old.minimum, new.minimum),
            ("max", old.maximum, new.maximum),
        )
        if was != now
    ]
