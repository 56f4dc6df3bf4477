"""Bounds that are in the way are moved, all else stays."""

from dataclasses import replace

import pytest

from grainfit.problem import Parameter, Problem, Target
from grainfit.strategies.out_of_reach import widened, widenings
from grainfit.verdict.out_of_reach import OutOfReach

PROBLEM = Problem(
    [
        Parameter("density", 1000.0, 2000.0, unit="kg/m^3"),
        Parameter("modulus", 1e5, 1e7, "log"),
        Parameter("shift", -1.0, 1.0),
    ],
    [Target("angle", 30.0)],
)


def miss(parameter: str | None, bound: str | None, suggestion: float | None) -> OutOfReach:
    return OutOfReach("angle", 30.0, 25.0, 0.1, False, parameter, bound, 0.0, suggestion)


@pytest.mark.parametrize(
    ("parameter", "bound", "suggestion", "interval"),
    [
        ("density", "max", 2400.0, (1000.0, 2400.0)),
        ("density", "min", 800.0, (800.0, 2000.0)),
        ("modulus", "max", 3e7, (1e5, 3e7)),
        ("shift", "min", -2.0, (-2.0, 1.0)),
    ],
)
def test_the_bound_in_the_way_is_moved_and_no_other(
    parameter: str, bound: str, suggestion: float, interval: tuple[float, float]
) -> None:
    found = widened(PROBLEM, [miss(parameter, bound, suggestion)])
    assert found.intervals == PROBLEM.intervals | {parameter: interval}
    assert found.targets == PROBLEM.targets
    assert [(p.scale, p.unit) for p in found.parameters] == [
        (p.scale, p.unit) for p in PROBLEM.parameters
    ]
    key, was = (
        ("max", PROBLEM.intervals[parameter][1])
        if bound == "max"
        else (
            "min",
            PROBLEM.intervals[parameter][0],
        )
    )
    unit = {"density": " kg/m³"}.get(parameter, "")
    assert widenings(PROBLEM, found) == [
        f"{parameter}.{key} = {was:g}{unit} was in the way and has been moved to "
        f"{suggestion:g}{unit}."
    ]


def test_several_bounds_are_moved_at_once() -> None:
    misses = [miss("density", "max", 2400.0), miss("density", "max", 2200.0)]
    misses.append(miss("modulus", "min", 5e4))
    found = widened(PROBLEM, misses)
    assert found.intervals["density"] == (1000.0, 2400.0)
    assert found.intervals["modulus"] == (5e4, 1e7)
    assert len(widenings(PROBLEM, found)) == 2


@pytest.mark.parametrize(
    "useless",
    [miss(None, None, None), miss("density", "max", None), miss("density", "max", 1500.0)],
)
def test_a_miss_that_suggests_nothing_wider_changes_nothing(useless: OutOfReach) -> None:
    assert widened(PROBLEM, [useless]) == PROBLEM
    assert widenings(PROBLEM, widened(PROBLEM, [useless])) == []


@pytest.mark.parametrize("suggestion", [0.0, -500.0])
def test_what_was_positive_stays_positive(suggestion: float) -> None:
    assert widened(PROBLEM, [miss("density", "min", suggestion)]) == PROBLEM


def test_the_given_problem_stays_as_it_is() -> None:
    before = replace(PROBLEM)
    widened(PROBLEM, [miss("density", "max", 2400.0)])
    assert before == PROBLEM
