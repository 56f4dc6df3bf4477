"""Notes on soft particles, whose overlap adds to bulk densities."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt

from grainfit.bulk_tests.base import BulkTest, ResponseInfo
from grainfit.bulk_tests.sensitivities import DENSITY, MODULUS
from grainfit.bulk_tests.shared.stiffness import (
    excess_density,
    number_with_excess,
    stiffness_number,
)
from grainfit.evaluation import response_name
from grainfit.formatting import in_a_row, number
from grainfit.problem import Problem

#: Excess below which nothing is said, and those of the moduli that are offered.
_WORTH_A_NOTE = 0.01
_OFFERED = (0.02, 0.01)
#: Responses nearly proportional to the density of the particles are those that overlaps change.
_PROPORTIONAL = 0.5


def stiffness_notes(
    problem: Problem,
    tests: Mapping[str, BulkTest],
    fixed: Mapping[str, float],
    answer: Mapping[str, float] | None = None,
) -> tuple[str, ...]:
    """Say by how much soft particles raise the responses of a calibration.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    tests : mapping of str to BulkTest
        All tests that are simulated, by name; of models of the user nothing is known.
    fixed : mapping of str to float
        Material parameters that are not free.
    answer : mapping of str to float, optional
        Values of the free parameters; by default the middle of their intervals.

    Returns
    -------
    tuple of str
        A sentence or two for each stiffness number; empty where overlaps add less than 1 %.
    """
    middle = {p.name: p.from_unit(0.5) for p in problem.parameters}
    material = {**fixed, **(answer or middle)}
    intervals = {p.name: (p.minimum, p.maximum) for p in problem.parameters}
    lowest = [min([material.get(n, 0.0), *intervals.get(n, ())]) for n in (DENSITY, MODULUS)]
    if min(lowest) <= 0:
        # Not known, or impossible: its run will say so.
        return ()
    raised: dict[float, list[str]] = {}
    for name, test in _raised_targets(problem, tests).items():
        raised.setdefault(stiffness_number(material, test.conditions), []).append(name)
    spread = _spread({} if answer else intervals, material)
    return tuple(
        _note(value, names, material[MODULUS], spread, density_is_free=DENSITY in intervals)
        for value, names in raised.items()
        if excess_density(value * spread[0]) >= _WORTH_A_NOTE
    )


def _raised_targets(problem: Problem, tests: Mapping[str, BulkTest]) -> dict[str, BulkTest]:
    targets = {target.name for target in problem.targets}
    found = {
        response_name(test_name, name, count): test
        for test_name, test in tests.items()
        for name, info in test.responses.items()
        if _is_raised(info)
        for count in (1, 2)
    }
    return {name: test for name, test in found.items() if name in targets}


def _is_raised(info: ResponseInfo) -> bool:
    known = info.sensitivities
    return known is not None and known.slopes.get(DENSITY, 0.0) >= _PROPORTIONAL


def _spread(
    intervals: Mapping[str, tuple[float, float]], material: Mapping[str, float]
) -> tuple[float, float]:
    """Smallest and largest stiffness number within intervals, over that of the material."""
    low = high = 1.0
    if DENSITY in intervals:
        least, most = intervals[DENSITY]
        low, high = low * material[DENSITY] / most, high * material[DENSITY] / least
    if MODULUS in intervals:
        least, most = intervals[MODULUS]
        low, high = low * least / material[MODULUS], high * most / material[MODULUS]
    return low, high


def _note(
    value: float,
    names: list[str],
    modulus: float,
    spread: tuple[float, float],
    *,
    density_is_free: bool,
) -> str:
    verb = "are" if len(names) > 1 else "is"
    within = ""
    if spread != (1.0, 1.0):
        least, most = (_percent(excess_density(value * factor)) for factor in reversed(spread))
        within = f" ({least} to {most} % within the intervals)"
    takes = "the fitted particle density is too low" if density_is_free else "friction is fitted"
    return (
        f"The particles are soft, E/(\u03c1 g d) = {number(value, 3)}: {in_a_row(names)} {verb} "
        f"about {_percent(excess_density(value))} % above that of stiff particles{within}, because "
        f"they overlap, and {takes} for it. {_remedy(value, modulus)}"
    )


def _percent(share: float) -> str:
    return number(100 * share, 2)


def _remedy(value: float, modulus: float) -> str:
    offers = []
    for excess in _OFFERED:
        factor = number_with_excess(excess) / value
        if factor > 1:
            offers.append(
                f"{_percent(excess)} % with {number(modulus * factor / 1e6, 2)} MPa "
                f"({number(sqrt(factor), 2)} times as many time steps)"
            )
    words = f"It is {in_a_row(offers, 'or')}. " if offers else ""
    return f"{words}'grainfit stiffness' measures it."
