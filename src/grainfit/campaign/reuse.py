"""Find stored runs that can be reused for a problem.

The definition of a run holds everything that determines its outcome. A run therefore belongs to a
problem if it has the model of one of its solvers and the problem's values of all parameters that
are not free. The calibration that asked for it may have had other targets, intervals or strategy.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

from grainfit.bulk_tests.natural_units import NaturalRun, in_si, natural_run, without_rounding_error
from grainfit.bulk_tests.parameter_names import DENSITY
from grainfit.campaign.absent_responses import with_needed
from grainfit.campaign.campaign import evaluation_of
from grainfit.campaign.repeats import seeds_of
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.contact_models.registry import material_parameter
from grainfit.errors import GrainfitError, InputError
from grainfit.evaluation import (
    Curve,
    Evaluation,
    Measured,
    Proposal,
    Response,
    curves,
    response_name,
    run_name,
    scalars,
    tests_asked,
)
from grainfit.metamodels.known_runs import LARGEST_DISTANCE, distance_outside
from grainfit.problem import Problem
from grainfit.run_definition import RunDefinition, identity_of
from grainfit.solvers.base import Solver
from grainfit.units import powers


class RunMatcher:
    """Recognise stored runs of a solver, and return their free parameters and seed.

    A run matches when it has the model of the solver and the problem's values of all parameters
    that are not free.

    Parameters
    ----------
    solver : Solver
        The solver of the runs.
    problem : Problem
        The problem, with the free parameters.

    Raises
    ------
    GrainfitError
        The solver has no model, for example because its program is missing.
    """

    def __init__(self, solver: Solver, problem: Problem) -> None:
        sample = _sample(solver, problem)
        self._defaults = dict(solver.defaults)
        self._free, self._fixed = _free_and_fixed(solver, problem, sample)
        self.model_hash = sample.model_hash

    def match(self, record: RunRecord) -> tuple[dict[str, float], int] | None:
        """Return the values and the seed of a run; None if it does not match.

        The values are those of the parameters that the solver takes.
        """
        definition = record.definition
        if definition.model_hash != self.model_hash:
            return None
        values = self._defaults | dict(definition.parameters)
        free = {name: values.pop(name) for name in self._free if name in values}
        if values != self._fixed or len(free) < len(self._free):
            return None
        return free, definition.seed

    def mismatch(self, record: RunRecord) -> tuple[str, float | None] | None:
        """Return the first parameter in which a run of the model is none of the problem.

        With the problem's value of a fixed one; None where the run matches.
        """
        values = self._defaults | dict(record.definition.parameters)
        for name in dict.fromkeys([*self._free, *self._fixed, *values]):
            if name not in values:
                return name, self._fixed.get(name)
            if name not in self._free and values[name] != self._fixed.get(name):
                return name, self._fixed.get(name)
        return None


def _sample(solver: Solver, problem: Problem) -> RunDefinition:
    """Return a run in the middle of the intervals."""
    return solver.definition(problem.middle, 1)


def _free_and_fixed(
    solver: Solver, problem: Problem, sample: RunDefinition
) -> tuple[list[str], dict[str, float]]:
    """Return the free parameters that a solver takes, and the values of the others."""
    values = dict(solver.defaults) | dict(sample.parameters)
    free = [p.name for p in problem.parameters if p.name in values]
    return free, {name: v for name, v in values.items() if name not in free}


@dataclass(frozen=True)
class RunAtScale:
    """A stored run, and what a problem would simulate at its free parameters, at its own scale.

    Parameters
    ----------
    run : NaturalRun
        The stored run.
    here : NaturalRun
        The run of the problem.
    definition : RunDefinition
        Of the run of the problem.
    values : mapping of str to float
        Its free parameters.
    """

    run: NaturalRun
    here: NaturalRun
    definition: RunDefinition
    values: Mapping[str, float]

    def responses_of(self, record: RunRecord) -> dict[str, Measured]:
        """Return the responses of the stored run at the scale of the problem."""

        def factor(unit: str) -> float:
            return self.here.scale.of(unit) / self.run.scale.of(unit)

        test = self.run.test
        responses: dict[str, Measured] = {
            name: _scaled(response, factor(test.responses[name].unit))
            for name, response in scalars(record.responses).items()
        }
        for name, curve in curves(record.responses).items():
            info = test.curves[name]
            scales = factor(info.coordinate_unit), factor(info.unit)
            responses[name] = _scaled_curve(curve, *scales)
        return responses


class ScaledRunMatcher:
    """Recognise runs of a bulk test at another particle size or density, and scale them.

    Runs of a model of the user never match. Parameters and errors are those of `RunMatcher`.
    """

    def __init__(self, solver: Solver, problem: Problem) -> None:
        self._solver = solver
        sample = _sample(solver, problem)
        self._free, self._fixed = _free_and_fixed(solver, problem, sample)
        self.natural = natural_run(sample)
        intervals = {p.name: (p.minimum, p.maximum) for p in problem.parameters}
        self._densities = intervals.get(DENSITY, (0.0, math.inf))

    @property
    def natural_hash(self) -> str:
        """Hash of the model of its runs in natural units; empty for a model of the user."""
        return "" if self.natural is None else self.natural.model_hash

    def match(self, record: RunRecord) -> RunRecord | None:
        """Return the run at the scale of the problem.

        None if it has that scale already, or is no run of the problem.
        """
        run = natural_run(record.definition)
        if run is None or run.model_hash != self.natural_hash:
            return None
        found = self.at_scale(run, record.definition.seed)
        if found is None or run.scale.is_same(found.here.scale) or not found.here.is_same(run):
            return None
        definition = found.definition
        return replace(
            record,
            identity=definition.identity,
            definition=definition,
            responses=found.responses_of(record),
        )

    def at_scale(self, run: NaturalRun, seed: int) -> RunAtScale | None:
        """Return a run of the test, of any fixed numbers, beside that of the problem there.

        None where it lacks a free parameter, or the problem can have no such run.
        """
        if self.natural is None:
            return None
        scale = replace(self.natural.scale, density=self._density(run))
        known = in_si(run, scale)
        values = {name: known[name] for name in self._free if name in known}
        if len(values) < len(self._free):
            return None
        try:
            definition = self._solver.definition(values, seed)
        except InputError:
            return None
        here = natural_run(definition)
        return None if here is None else RunAtScale(run, here, definition, values)

    def _density(self, run: NaturalRun) -> float:
        """Density of the particles at which the run has the problem's fixed values, kg/m^3."""
        if DENSITY in self._fixed:
            return self._fixed[DENSITY]
        assert self.natural is not None
        per_density = replace(self.natural.scale, density=1.0)
        known = in_si(run, per_density)
        for name, value in self._fixed.items():
            # A stiffness that is fixed says how dense the particles are; no cohesion says nothing.
            parameter = material_parameter(name)
            if parameter is not None and value and known.get(name) and powers(parameter.unit)[0]:
                return without_rounding_error(value / known[name])
        low, high = self._densities
        return min(max(run.scale.density, low), high)


def _scaled(response: Response, factor: float) -> Response:
    return Response(response.value * factor, response.standard_error * factor)


def _scaled_curve(curve: Curve, of_coordinates: float, of_values: float) -> Curve:
    coordinates = [of_coordinates * value for value in curve.coordinates]
    return Curve(coordinates, [of_values * value for value in curve.values], curve.stays)


def needed_responses(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, set[str]]:
    """Return the responses that have a target, by name of the test.

    A test whose responses are known only after a run is left out.
    """
    targets = set(problem.responses)
    return {
        test: {n for n in solver.response_names if response_name(test, n, len(solvers)) in targets}
        for test, solver in solvers.items()
        if solver.response_names is not None
    }


def models_of(solvers: Mapping[str, Solver]) -> set[str]:
    """Return the hashes of the solvers' models; an empty set if a solver cannot be used."""
    try:
        return {identity_of(solver.model()) for solver in solvers.values()}
    except GrainfitError:
        return set()


def runs_of(
    problem: Problem,
    solvers: Mapping[str, Solver],
    records: Iterable[RunRecord],
    repeats: Mapping[str, int] | None = None,
) -> list[Evaluation]:
    """Return the stored runs of a problem, those of several tests joined to one evaluation.

    Parameters
    ----------
    problem : Problem
        Only points within its intervals count, or not far beyond them.
    solvers : mapping of str to Solver
        By name of the test.
    records : iterable of RunRecord
        Stored runs. Unfinished runs, and failures by the machine or by timeout, are skipped.
    repeats : mapping of str to int, optional
        Runs with different seeds whose mean is one evaluation, by name of the test. Where only some
        of them are known, their mean counts.

    Returns
    -------
    list of Evaluation
        In an order that depends on the runs alone.
    """
    try:
        matchers = {test: RunMatcher(solver, problem) for test, solver in solvers.items()}
    except GrainfitError:
        return []
    found: dict[str, list[_Point]] = defaultdict(list)
    needed = needed_responses(problem, solvers)
    for stored in records:
        if stored.status == "running" or stored.may_succeed_next_time:
            continue
        for test, matcher in matchers.items():
            record = with_needed(stored, needed.get(test, ()))
            if record.status == "finished" and not needed.get(test, set()) <= set(record.responses):
                continue
            run = matcher.match(record)
            if run is not None and distance_outside(problem, run[0]) <= LARGEST_DISTANCE:
                found[test].append(_Point(*run, {test: record}))
    for test, count in (repeats or {}).items():
        found[test] = _with_further_seeds(found[test], test, count)
    points = reduce(_joined_points, (found[test] for test in solvers))
    if problem.tests:
        points += _points_of_one_test(problem, found, points)
    names = [parameter.name for parameter in problem.parameters]
    return [
        _evaluation(point, names, len(solvers)).scaled(problem.ratios)
        for point in sorted(points, key=lambda point: point.order(names))
    ]


def _evaluation(point: _Point, names: Sequence[str], tests: int) -> Evaluation:
    values = {name: point.values[name] for name in names}
    proposal = Proposal(values, point.seed, "design", tests_asked(point.runs, tests))
    return evaluation_of(proposal, point.runs, tests, reused=len(point.runs))


def _points_of_one_test(
    problem: Problem, found: Mapping[str, Sequence[_Point]], joined: Iterable[_Point]
) -> list[_Point]:
    """Return the runs of a test that have none of the other tests at their point.

    Parameters that the test does not depend on have the middle of their interval.
    """
    taken = {record.identity for point in joined for record in point.runs.values()}
    middle = problem.middle
    return [
        replace(point, values=middle | dict(point.values))
        for points in found.values()
        for point in points
        if not taken.issuperset(record.identity for record in point.runs.values())
    ]


@dataclass(frozen=True)
class _Point:
    """Values of some parameters and a seed, with the runs there by test."""

    values: Mapping[str, float]
    seed: int
    runs: Mapping[str, RunRecord]

    def order(self, names: Sequence[str]) -> tuple[float, ...]:
        return (*(self.values[name] for name in names), self.seed, -len(self.runs))


def _with_further_seeds(points: list[_Point], test: str, repeats: int) -> list[_Point]:
    """Join the points of one test whose seeds belong to one evaluation."""
    if repeats == 1:
        return points

    def key(point: _Point, seed: int) -> tuple[Any, ...]:
        return (*sorted(point.values.items()), seed)

    known = {key(point, point.seed): point for point in points}
    joined, taken = [], set()
    for point in points:
        names = {
            key(point, seed): run_name(test, number)
            for number, seed in enumerate(seeds_of(point.seed, repeats), 1)
        }
        runs = {name: known[one].runs[test] for one, name in names.items() if one in known}
        joined.append(replace(point, runs=runs))
        taken |= names.keys() - {key(point, point.seed)}
    return [point for point in joined if key(point, point.seed) not in taken]


def _joined_points(points: list[_Point], others: list[_Point]) -> list[_Point]:
    """Join points with those of another test that have the same seed and agree in all values."""
    if not points or not others:
        return []
    shared = points[0].values.keys() & others[0].values.keys()

    def key(point: _Point) -> tuple[Any, ...]:
        return (*(point.values[name] for name in sorted(shared)), point.seed)

    of_key = defaultdict(list)
    for other in others:
        of_key[key(other)].append(other)
    return [
        _Point({**point.values, **other.values}, point.seed, {**point.runs, **other.runs})
        for point in points
        for other in of_key[key(point)]
    ]


def is_run_of(problem: Problem, solvers: Mapping[str, Solver]) -> Callable[[RunRecord], bool]:
    """Return a predicate that is True for runs of any test of a problem."""
    try:
        matchers = [RunMatcher(solver, problem) for solver in solvers.values()]
    except GrainfitError:
        return lambda _record: False
    return lambda record: any(r.match(record) is not None for r in matchers)


def take_runs(
    other: RunStore, problem: Problem, solvers: Mapping[str, Solver], store: RunStore
) -> int:
    """Copy the runs of a problem from another store; return the number of new runs."""
    there = store.states()
    new = {
        record.identity: replace(record, origin=record.origin or other.place)
        for record in finished_runs_of(other, problem, solvers)
        if there.get(record.identity) != "finished"
    }
    store.save_many(new.values())
    return len(new)


def finished_runs_of(
    other: RunStore, problem: Problem, solvers: Mapping[str, Solver]
) -> list[RunRecord]:
    """Return the finished runs of a problem in a store, at the scale of the problem."""
    found = [*filter(is_run_of(problem, solvers), other.runs_of(models_of(solvers), "finished"))]
    return found + _at_other_scales(other, problem, solvers, {one.identity for one in found})


def _at_other_scales(
    other: RunStore, problem: Problem, solvers: Mapping[str, Solver], taken: Collection[str]
) -> list[RunRecord]:
    """Return the runs of other sizes and densities that are runs of this problem, too.

    Those that are taken as they are would count twice.
    """
    try:
        matchers = [ScaledRunMatcher(solver, problem) for solver in solvers.values()]
    except GrainfitError:
        return []
    hashes = {matcher.natural_hash for matcher in matchers} - {""}
    if not hashes:
        return []
    records = other.runs_at_any_scale(hashes)
    records = [record for record in records if record.identity not in taken]
    scaled = (matcher.match(record) for record in records for matcher in matchers)
    return [record for record in scaled if record is not None]
