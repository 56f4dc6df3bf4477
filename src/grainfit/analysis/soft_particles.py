"""Soft particles, whose overlap adds to bulk densities."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.parameter_names import DENSITY, MODULUS, ROLLING, SLIDING
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.stiffness import OverlapLaw, overlap_law, stiffness_number
from grainfit.bulk_tests.time_steps import STEPS_BY_MODULUS
from grainfit.checks import Found, check
from grainfit.contact_models.registry import is_load_dependent
from grainfit.evaluation import response_name
from grainfit.formatting import in_a_row, number
from grainfit.problem import Problem
from grainfit.solvers.check_context import CheckContext

#: Excess below which nothing is said, and those of the moduli that are offered.
_WORTH_A_NOTE = 0.01
_OFFERED = (0.02, 0.01)
#: Smallest factor on the modulus that is worth offering.
_STIFFER = 1.2
#: Parameters that make up for a raised density where that of the particles is not free.
_MAKING_UP = frozenset({MODULUS, SLIDING, ROLLING})


@check("soft-particles")
def soft_particles(context: CheckContext) -> Iterator[Found]:
    """Soft particles, whose overlap adds 1 % or more to a response."""
    found = [solver.contact_models for solver in context.solvers.values()]
    tests = of_hertz(context.bulk_tests, *found)
    for note in stiffness_notes(context.problem, tests, context.fixed):
        yield MODULUS, note


def of_hertz(tests: Mapping[str, BulkTest], *chosen: Iterable[str]) -> dict[str, BulkTest]:
    """Return the tests if their contacts are those of Hertz, of which overlaps were measured.

    Parameters
    ----------
    tests : mapping of str to BulkTest
        By name.
    *chosen : iterable of str
        Contact models of each solver that replace the usual ones.
    """
    return dict(tests) if all(is_load_dependent(models) for models in chosen) else {}


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
        All tests that are simulated, by name; of models of the user, and of contacts other than
        Hertz's (`of_hertz`), nothing is known.
    fixed : mapping of str to float
        Material parameters that are not free.
    answer : mapping of str to float, optional
        Values of the free parameters; by default the middle of their intervals.

    Returns
    -------
    tuple of str
        A sentence or two for each stiffness number; empty where overlaps add less than 1 %.
    """
    material = {**fixed, **(answer or problem.middle)}
    intervals = {p.name: (p.minimum, p.maximum) for p in problem.parameters}
    lowest = [min([material.get(n, 0.0), *intervals.get(n, ())]) for n in (DENSITY, MODULUS)]
    if min(lowest) <= 0:
        # Not known, or impossible: its run will say so.
        return ()
    raised: dict[tuple[str, float], tuple[BulkTest, list[str]]] = {}
    for name, test in _raised_targets(problem, tests).items():
        key = (overlap_law(test).symbol, stiffness_number(test, material))
        raised.setdefault(key, (test, []))[1].append(name)
    within = {} if answer else intervals
    return tuple(
        _note(test, names, material, within, density_is_free=DENSITY in intervals)
        for test, names in raised.values()
        if max(_excesses(test, material, within)) >= _WORTH_A_NOTE
    )


def known_biases(
    problem: Problem,
    tests: Mapping[str, BulkTest],
    fixed: Mapping[str, float],
    answer: Mapping[str, float] | None = None,
) -> dict[str, str]:
    """Return the reasons why free parameters are biased, by name.

    What soft particles add to a response goes into the density of the particles; where that is not
    free, into those that a bulk density depends on beside it.

    Parameters
    ----------
    problem, tests, fixed, answer
        As of `stiffness_notes`.
    """
    material = {**fixed, **(answer or problem.middle)}
    if min(material.get(name, 0.0) for name in (DENSITY, MODULUS)) <= 0:
        return {}
    free = {parameter.name for parameter in problem.parameters}
    reasons: dict[str, list[str]] = {}
    for name, test in _raised_targets(problem, tests).items():
        excess = overlap_law(test).excess(stiffness_number(test, material))
        if excess < _WORTH_A_NOTE:
            continue
        for biased in [DENSITY] if DENSITY in free else sorted(free & _MAKING_UP):
            reasons.setdefault(biased, []).append(f"{name} by about {_percent(excess)} %")
    return {name: f"soft particles raise {in_a_row(found)}" for name, found in reasons.items()}


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
    # Mass flows do not follow overlaps; densities without trials were not compared with any law.
    return info.unit == "kg/m^3" and info.trials is not None


def _excesses(
    test: BulkTest, material: Mapping[str, float], within: Mapping[str, tuple[float, float]]
) -> tuple[float, float]:
    """Smallest and largest excess of the bulk density within intervals."""
    corners = product(*(within.get(name, (material[name],)) for name in (DENSITY, MODULUS)))
    found = [
        overlap_law(test).excess(
            stiffness_number(test, {**material, DENSITY: density, MODULUS: modulus})
        )
        for density, modulus in corners
    ]
    return min(found), max(found)


def _note(
    test: BulkTest,
    names: list[str],
    material: Mapping[str, float],
    intervals: Mapping[str, tuple[float, float]],
    *,
    density_is_free: bool,
) -> str:
    law, value = overlap_law(test), stiffness_number(test, material)
    least, most = _excesses(test, material, intervals)
    within = ""
    if least < most:
        within = f" ({_percent(least)} to {_percent(most)} % within the intervals)"
    verb = "are" if len(names) > 1 else "is"
    takes = "the fitted particle density is too low"
    if not density_is_free:
        takes = "the fitted parameters make up"
    return (
        f"The particles are soft, {law.symbol} = {number(value, 3)}: {in_a_row(names)} {verb} "
        f"about {_percent(law.excess(value))} % above that of stiff particles{within}, because "
        f"they overlap, and {takes} for it. {_remedy(law, value, material[MODULUS])}"
    )


def _percent(share: float) -> str:
    return number(100 * share, 2)


def _remedy(law: OverlapLaw, value: float, modulus: float) -> str:
    offers = []
    for excess in _OFFERED:
        factor = law.number_with(excess) / value
        if factor > _STIFFER:
            offers.append(
                f"{_percent(excess)} % with {number(modulus * factor / 1e6, 2)} MPa "
                f"({number(factor**STEPS_BY_MODULUS, 2)} times as many time steps)"
            )
    words = f"It is {in_a_row(offers, 'or')}. " if offers else ""
    return f"{words}'grainfit stiffness' measures it."
