"""Say why a calibration uses no run of a source that the user gave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from grainfit.campaign import messages
from grainfit.campaign.absent_responses import with_needed
from grainfit.campaign.reuse import RunMatcher, finished_runs_of, needed_responses
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.contact_models.registry import material_parameter
from grainfit.errors import GrainfitError
from grainfit.formatting import in_a_row, plain_ends, value_with_unit, with_unit
from grainfit.metamodels.known_runs import LARGEST_DISTANCE, distance_outside
from grainfit.problem import Problem
from grainfit.run_definition import identity_of, type_of_test
from grainfit.solvers.base import Solver

#: Parts of a model in words, the most telling first; others have their own name.
_PARTS = {
    "solver": "the solver",
    "version": "the version of the solver",
    "ranks": "the number of MPI ranks",
    "contact_models": "the contact models",
    "test": "the apparatus or its particles",
    "function": "the function or its text",
    "command": "the command",
    "table": "the table",
}


def why_unused(source: RunStore, problem: Problem, solvers: Mapping[str, Solver]) -> str:
    """Return why a calibration uses no run of a source, in a part of a sentence.

    Parameters
    ----------
    source : RunStore
        The store of the source.
    problem : Problem
        The calibration problem.
    solvers : mapping of str to Solver
        By name of the test.

    Returns
    -------
    str
        Empty where it uses some.
    """
    if fitting := finished_runs_of(source, problem, solvers):
        return _why_not_needed(fitting, problem, solvers)
    others = source.runs("finished")
    if not others:
        return messages.NO_FINISHED_RUN()
    try:
        matchers = {test: RunMatcher(solver, problem) for test, solver in solvers.items()}
    except GrainfitError:
        # Its program is missing; another place says so.
        return ""
    for matcher in matchers.values():
        same = [one for one in others if one.definition.model_hash == matcher.model_hash]
        if same:
            return _other_parameters(same, matcher)
    return _other_model(others, solvers)


def _why_not_needed(
    fitting: Sequence[RunRecord], problem: Problem, solvers: Mapping[str, Solver]
) -> str:
    """Return why runs of the problem are not used; empty where some are."""
    needed = needed_responses(problem, solvers)
    matchers = {test: RunMatcher(solver, problem) for test, solver in solvers.items()}
    found = {
        (record.identity, test): (record, run[0])
        for test, matcher in matchers.items()
        for record in fitting
        if (run := matcher.match(record)) is not None
    }
    near = {
        key: record
        for key, (record, values) in found.items()
        if distance_outside(problem, values) <= LARGEST_DISTANCE
    }
    if not near:
        return _beyond([values for _, values in found.values()], problem) if found else ""
    missing: set[str] = set()
    for (_, test), record in near.items():
        wanted = set(needed.get(test, ()))
        lacks = wanted - set(with_needed(record, wanted).responses)
        if not lacks:
            return ""
        missing |= lacks
    return messages.WITHOUT_RESPONSES(names=in_a_row(sorted(missing), "or"))


def _beyond(found: Sequence[Mapping[str, float]], problem: Problem) -> str:
    nearest = min(found, key=lambda values: distance_outside(problem, values))
    name = max(nearest, key=lambda name: distance_outside(problem, {name: nearest[name]}))
    low, high = problem.intervals[name]
    there = [values[name] for values in found]
    return messages.BEYOND_INTERVALS(
        name=name, here=_shown(name, [low, high]), there=_shown(name, there)
    )


def _other_parameters(same: Sequence[RunRecord], matcher: RunMatcher) -> str:
    """Return the first parameter in which runs of a model are none of the problem."""
    mismatch = matcher.mismatch(same[0])
    if mismatch is None:
        return ""
    name, here = mismatch
    parameters = (record.definition.parameters for record in same)
    there = [values[name] for values in parameters if name in values]
    if not there:
        return messages.PARAMETER_NOT_THERE(name=name)
    if here is None:
        return messages.PARAMETER_NOT_HERE(name=name)
    return messages.OTHER_FIXED_VALUE(
        name=name, here=_shown(name, [here]), there=_shown(name, there)
    )


def _other_model(others: Sequence[RunRecord], solvers: Mapping[str, Solver]) -> str:
    """Return what differs between the models of runs and those of the calibration."""
    for test, solver in solvers.items():
        here = solver.model()
        for record in others:
            there, kind = record.definition.model, type_of_test(here)
            if type_of_test(there) == kind and (kind or record.test == test):
                part = next(name for name in [*_PARTS, *here, *there] if _differ(here, there, name))
                return messages.OTHER_MODEL(test=record.test, what=_PARTS.get(part, part))
    theirs = dict.fromkeys(record.definition.test_type or record.test for record in others)
    ours = dict.fromkeys(type_of_test(solver.model()) or test for test, solver in solvers.items())
    return messages.OTHER_TESTS(theirs=in_a_row(theirs), ours=in_a_row(ours))


def _differ(here: Mapping[str, Any], there: Mapping[str, Any], part: str) -> bool:
    # As in hashes of models: a list is the same as a tuple, and 1 is not 1.0.
    return identity_of({part: here.get(part)}) != identity_of({part: there.get(part)})


def _shown(name: str, values: Sequence[float]) -> str:
    known = material_parameter(name)
    unit = known.unit if known is not None else ""
    low, high = min(values), max(values)
    if low == high:
        return value_with_unit(low, unit)
    return with_unit(plain_ends(low, high), unit)
