"""Recorded sensitivities of the bulk tests, for candidate tests, and the limits of the trials.

The trials varied the friction of all walls of a test together, but for parts that had one of their
own. They had spheres without cohesion only.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from grainfit.bulk_tests.abilities import friction_options
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.sensitivities import VARIED, WALL_SLIDING
from grainfit.contact_models.registry import COHESION
from grainfit.materials.walls import PLAIN, on_wall, plain_name
from grainfit.options.fields import option_remarks
from grainfit.solvers.base import Solver
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.determining_tests import BETTER_FIXED


def recorded_response(
    name: str,
    info: ResponseInfo,
    material: Mapping[str, float],
    value: float,
    accuracy: Accuracy,
    wall: str = PLAIN,
) -> CandidateResponse | None:
    """Return a response with its recorded sensitivities; None without them.

    None as well for a value of zero: the sensitivities are relative to it.

    Parameters
    ----------
    name : str
        Name of the response, with that of its test.
    info : ResponseInfo
        Has the sensitivities.
    material : mapping of str to float
        Where the slopes are taken.
    value : float
        Expected value.
    accuracy : Accuracy
        Of the measurement.
    wall : str
        The wall to which sensitivities to walls belong, see `wall_most_touched`.
    """
    known = info.sensitivities
    if known is None or value == 0:
        return None
    slopes = {on_wall(n, wall): slope for n, slope in known.at(material).items()}
    return CandidateResponse(name, value, accuracy, slopes, known.scatter, unit=info.unit)


def wall_most_touched(solver: Solver) -> str:
    """Return the wall of the first part of a test, which most particles touch."""
    parts = solver.bulk_test.parts if solver.bulk_test else ()
    return solver.walls.get(next(iter(parts)), PLAIN) if parts else PLAIN


def unrecorded_effects(
    solvers: Mapping[str, Solver], free: Collection[str]
) -> dict[str, list[str]]:
    """Return the tests on which the effect of a free parameter is not recorded, by parameter.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    free : collection of str
        Names of free parameters.
    """
    known = {*VARIED, *BETTER_FIXED}
    apart = {test: _frictions_apart(solver) for test, solver in solvers.items()}
    found = {
        name: [t for t, own in apart.items() if name in own or plain_name(name) not in known]
        for name in free
    }
    return {name: tests for name, tests in found.items() if tests}


def _frictions_apart(solver: Solver) -> set[str]:
    """Return frictions of the walls of a test that no trial varied."""
    test = solver.bulk_test
    if test is None:
        return set()
    apart = option_remarks(type(test), "recorded")
    return {
        on_wall(WALL_SLIDING, solver.walls.get(part, PLAIN))
        for part, own in friction_options(type(test)).items()
        if any(o in apart and "sliding" in o and getattr(test, o) is None for o in own)
    }


def are_dry_spheres(solvers: Mapping[str, Solver], material: Mapping[str, float]) -> bool:
    """Return whether particles are spheres without cohesion, as those of the trials."""
    tests = [solver.bulk_test for solver in solvers.values() if solver.bulk_test]
    are_clumps = any(test.sizes.shape is not None for test in tests)
    is_cohesive = any(value for name, value in material.items() if plain_name(name) in COHESION)
    return not are_clumps and not is_cohesive
