"""Tests of a calibration file that simulate the same and differ in their evaluation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from grainfit.calibration_file.content import TestSpecification

#: Keys of a test that leave its simulation as it is.
_EVALUATION = frozenset({"evaluate", "responses", "measure", "timeout"})


def join_evaluations(tests: Sequence[TestSpecification]) -> tuple[TestSpecification, ...]:
    """Join tests that differ in their ``evaluate`` only: each simulation serves all of them.

    Returns
    -------
    tuple of TestSpecification
        Joined ones stand where their first one stood, and have the names of all.
    """
    found: list[TestSpecification] = []
    names = {test.name for test in tests}
    for test in tests:
        place = next((i for i, one in enumerate(found) if _can_be_joined(one, test)), None)
        # A test of the file may have their name: its runs and targets would be theirs.
        if place is None or _joint_name(found[place], test) in names:
            found.append(test)
        else:
            found[place] = _join(found[place], test)
    return tuple(found)


def _can_be_joined(one: TestSpecification, other: TestSpecification) -> bool:
    return (
        is_same_simulation(one, other)
        and "evaluate" in one.options
        and "evaluate" in other.options
        and one.repeats == other.repeats
        and set(one.responses).isdisjoint(other.responses)
    )


def _joint_name(one: TestSpecification, other: TestSpecification) -> str:
    return f"{one.name}_and_{other.name}"


def _join(one: TestSpecification, other: TestSpecification) -> TestSpecification:
    functions = dict.fromkeys([*one.options["evaluate"], *other.options["evaluate"]])
    options = {**one.options, "evaluate": tuple(functions)}
    # A test without a time-out may take as long as it likes.
    limit = max(test.options.get("timeout", math.inf) for test in (one, other))
    options.pop("timeout", None)
    if limit < math.inf:
        options["timeout"] = limit
    return replace(
        one,
        name=_joint_name(one, other),
        options=options,
        targets=one.targets + other.targets,
        planned={**one.planned, **other.planned},
        correlations=one.correlations + other.correlations,
        curves=one.curves + other.curves,
        joined=(*(one.joined or (one.name,)), other.name),
    )


def is_same_simulation(one: TestSpecification, other: TestSpecification) -> bool:
    """Return whether two tests differ at most in their evaluation."""
    return one.type == other.type and _simulation(one) == _simulation(other)


def _simulation(test: TestSpecification) -> Mapping[str, Any]:
    return {key: value for key, value in test.options.items() if key not in _EVALUATION}
