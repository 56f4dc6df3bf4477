"""What the atlas tells of candidate tests: responses with their slopes, and no run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial

from grainfit.atlas.expectation import Expectation
from grainfit.atlas.reading import NotInAtlasError, Reading
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.formatting import in_a_row
from grainfit.materials.walls import plain_name
from grainfit.messages import Message
from grainfit.solvers.base import Solver
from grainfit.which_test import messages
from grainfit.which_test.candidate import AccuracyOf, Candidate, CandidateResponse, seconds_of
from grainfit.which_test.determining_tests import BETTER_FIXED
from grainfit.which_test.slopes import Cloud, expected_response

#: Returns the accuracy of a response of a test, by its name; None if it is not measured.
AccuracyOfResponse = Callable[[str, ResponseInfo], Accuracy | None]


def told_responses(
    test: str, solver: Solver, cloud: Cloud, accuracy_of: AccuracyOfResponse
) -> tuple[CandidateResponse, ...]:
    """Return the responses of a test that the atlas tells of; none where it has no rows.

    Parameters
    ----------
    test : str
        Name of the test.
    solver : Solver
        Of the test.
    cloud : Cloud
        Parameter sets over which the slopes are taken.
    accuracy_of : callable
        Accuracies of the measurements.
    """
    infos = solver.bulk_test.responses if solver.bulk_test else {}
    measured = {
        name: accuracy
        for name, info in infos.items()
        if (accuracy := accuracy_of(name, info)) is not None
    }
    if not measured:
        return ()
    try:
        found = Expectation(solver, cloud.middle).responses(cloud.values, measured)
    except NotInAtlasError:
        return ()
    return tuple(
        expected_response(f"{test}.{name}", measured[name], cloud, expected, infos[name].unit)
        for name, expected in found.items()
    )


def told_tests(
    solvers: Mapping[str, Solver], cloud: Cloud, accuracy_of: AccuracyOf
) -> tuple[list[Candidate], dict[str, str]]:
    """Return tests with the slopes of the atlas, and why others have none.

    Parameters
    ----------
    solvers : mapping of str to Solver
        The tests, by name.
    cloud : Cloud
        Parameter sets over which the slopes are taken.
    accuracy_of : callable
        Accuracies of the responses.
    """
    found, missing = [], {}
    for test, solver in solvers.items():
        responses = told_responses(test, solver, cloud, partial(accuracy_of, test))
        if responses:
            found.append(Candidate(test, seconds_of(solver, cloud.middle), responses))
        else:
            missing[test] = messages.NOT_IN_ATLAS()
    return found, missing


def untold_effects(solvers: Mapping[str, Solver], cloud: Cloud) -> dict[str, list[str]]:
    """Return the tests of which the atlas does not tell what a parameter does, by parameter."""
    found: dict[str, list[str]] = {}
    for test, solver in solvers.items():
        try:
            tells_of = Expectation(solver, cloud.middle).tells_of
        except NotInAtlasError:
            continue
        for name in cloud.names:
            if plain_name(name) not in BETTER_FIXED and not tells_of(name):
                found.setdefault(name, []).append(test)
    return found


def as_dry_spheres(solvers: Mapping[str, Solver], middle: Mapping[str, float]) -> list[str]:
    """Return the types of test in which dry spheres stand for particles the atlas does not have.

    Parameters
    ----------
    solvers : mapping of str to Solver
        The tests, by name.
    middle : mapping of str to float
        Free parameters somewhere in their intervals.
    """
    found: dict[str, None] = {}
    for solver in solvers.values():
        with suppress(NotInAtlasError):
            reading = Reading(solver, middle, is_nearest=True)
            if not reading.has_own_particles:
                found[reading.test.type] = None
    return list(found)


def of_dry_spheres(
    message: Message, solvers: Mapping[str, Solver], middle: Mapping[str, float]
) -> list[str]:
    """Return a sentence on the tests of `as_dry_spheres`; none without any."""
    tests = as_dry_spheres(solvers, middle)
    return [message(tests=in_a_row(tests))] if tests else []
