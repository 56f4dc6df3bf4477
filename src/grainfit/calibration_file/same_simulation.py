"""Tests of a calibration file that simulate the same and differ in their evaluation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

from grainfit.calibration_file.content import TestSpecification
from grainfit.formatting import in_a_row

#: Keys of a test that leave its simulation as it is.
_EVALUATION = frozenset({"evaluate", "responses", "measure", "timeout"})


def join_evaluations(tests: Sequence[TestSpecification]) -> tuple[TestSpecification, ...]:
    """Join tests that differ in their ``evaluate`` only: each simulation serves all of them.

    Parameters
    ----------
    tests : sequence of TestSpecification
        The tests of the file.

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
        _is_same_simulation(one, other)
        and "evaluate" in one.options
        and "evaluate" in other.options
        and one.repeats == other.repeats
        and not _names(one) & _names(other)
    )


def _names(test: TestSpecification) -> set[str]:
    return {*test.responses, *test.planned}


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


def same_simulation_notes(tests: Sequence[TestSpecification]) -> Iterator[str]:
    """Yield a note on tests that share their simulations, and on those that could.

    Parameters
    ----------
    tests : sequence of TestSpecification
        The tests of the file, joined where they can be.
    """
    for test in tests:
        if test.joined:
            yield (
                f"Tests {in_a_row(test.joined, 'and')} differ in their evaluation only: each "
                f"simulation serves all of them. They are called {test.name}."
            )
    for one, other in combinations(tests, 2):
        if _is_same_simulation(one, other):
            yield (
                f"Tests {one.name} and {other.name} differ at most in their evaluation, but each "
                "simulation is made for one of them only. Make them one [[test]] with the "
                f"targets of both{_remedy(one)}."
            )


def _is_same_simulation(one: TestSpecification, other: TestSpecification) -> bool:
    return one.type == other.type and _simulation(one) == _simulation(other)


def _simulation(test: TestSpecification) -> Mapping[str, Any]:
    return {key: value for key, value in test.options.items() if key not in _EVALUATION}


def _remedy(test: TestSpecification) -> str:
    for key in ("evaluate", "measure"):
        if key in test.options:
            return f": let the function in {key} return all their responses"
    return ""
