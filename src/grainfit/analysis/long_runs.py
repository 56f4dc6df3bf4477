"""Runs of many particles, which larger ones or a smaller apparatus would shorten."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.analysis import messages
from grainfit.analysis.recorded_size import changes_in_words
from grainfit.bulk_tests.abilities import is_of_user
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import coarse_grained, factor_words
from grainfit.bulk_tests.size import TWIN, twin_of
from grainfit.checks import Found, check
from grainfit.errors import InputError
from grainfit.formatting import duration
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.problem import Problem
from grainfit.solvers.base import Solver
from grainfit.solvers.check_context import CheckContext

#: Runs are long above this time, and short enough below that, s.
_LONG, _SHORT = 900.0, 300.0
_FACTORS = (1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0)


@check("long-runs")
def long_runs(context: CheckContext) -> Iterator[Found]:
    """Runs that take long; larger particles or a smaller apparatus, with time and price."""
    for name in [one for one in context.solvers if one not in context.twins]:
        if note := _note(name, context):
            yield context.key(name), note


def _note(name: str, context: CheckContext) -> str:
    solver, middle = context.solvers[name], context.problem.middle
    test = solver.bulk_test
    if test is None or is_of_user(test):
        # A scene of the user's own has a geometry that only its code knows.
        return ""
    try:
        cost = solver.estimate_cost(middle)
    except InputError:
        # The check says why.
        return ""
    if cost is None or cost.wall_seconds <= _LONG:
        return ""
    offers = [*_coarser(name, test, context), *_twin(name, test, context)]
    words = [messages.LONG_RUN(test=name, time=duration(cost.wall_seconds))]
    if why := solver.starts_anew(middle):
        words.append(messages.STARTS_ANEW(why=why))
    return " ".join([*words, *offers])


def _coarser(name: str, test: BulkTest, context: CheckContext) -> Iterator[str]:
    """Offer larger particles in the same apparatus, with their time and price."""
    larger, solver = _shorter(name, context.solvers, context.problem), context.solvers[name]
    if larger is None:
        return
    faster = solver.estimate_cost_of(larger[name], solver.run_parameters(context.problem.middle))
    moved = changes_in_words(test, context.targets_of(name), faster.particles)
    yield messages.FASTER_WITH_LARGER(
        factor=factor_words(larger),
        time=duration(faster.wall_seconds),
        particles=faster.particles,
        moved=moved,
    )


def _twin(name: str, test: BulkTest, context: CheckContext) -> Iterator[str]:
    """Offer a smaller apparatus with the same particles, with its time and price."""
    twin, solver = twin_of(test), context.solvers[name]
    if twin is None:
        return
    cost = solver.estimate_cost_of(twin, solver.run_parameters(context.problem.middle))
    moved = changes_in_words(test, context.targets_of(name), cost.particles)
    yield messages.FASTER_IN_SMALLER(
        particles=cost.particles, time=duration(cost.wall_seconds), moved=moved, twin=TWIN
    )


def _shorter(
    name: str, solvers: Mapping[str, Solver], problem: Problem
) -> Mapping[str, BulkTest] | None:
    """Return all tests with the smallest factor that makes runs short, or the largest possible."""
    larger = None
    solver = solvers[name]
    material = solver.run_parameters(problem.middle)
    for factor in _FACTORS:
        try:
            candidates = _enlarged(solvers, problem, factor)
        except InputError:
            break
        larger = candidates
        if solver.estimate_cost_of(candidates[name], material).wall_seconds <= _SHORT:
            break
    return larger


def _enlarged(
    solvers: Mapping[str, Solver], problem: Problem, factor: float
) -> dict[str, BulkTest]:
    """Return all tests with larger particles, which are those of the whole file.

    Raises
    ------
    InputError
        One of them is impossible with the most slender ones.
    """
    slender = {p.name: p.maximum for p in problem.parameters if p.name == ASPECT_RATIO}
    values = problem.middle | slender
    return {
        name: coarse_grained(solver.bulk_test, factor, solver.run_parameters(values))
        for name, solver in solvers.items()
        if solver.bulk_test is not None and not is_of_user(solver.bulk_test)
    }
