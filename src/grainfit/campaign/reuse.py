"""Find stored runs that can be reused for a problem.

The definition of a run holds everything that determines its outcome. A run therefore belongs to a
problem if it has the model of one of its solvers and the problem's values of all parameters that
are not free. The calibration that asked for it may have had other targets, intervals or strategy.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from typing import Any

from grainfit.campaign.campaign import evaluation_of
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import STORE_NAME, RunStore, not_a_work_folder
from grainfit.errors import GrainfitError, InputError
from grainfit.evaluation import Evaluation, Proposal
from grainfit.metamodels.known_runs import REACH, beyond
from grainfit.problem import Problem
from grainfit.run_definition import identity_of
from grainfit.solvers.base import Solver


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
        sample = solver.definition(problem.from_unit([0.5] * problem.dimension), 1)
        self._defaults = dict(solver.defaults)
        values = self._defaults | dict(sample.parameters)
        # Not every test takes every parameter.
        self._free = [p.name for p in problem.parameters if p.name in values]
        self._fixed = {name: v for name, v in values.items() if name not in self._free}
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


def models_of(solvers: Mapping[str, Solver]) -> set[str]:
    """Return the hashes of the solvers' models; an empty set if a solver cannot be used."""
    try:
        return {identity_of(solver.model()) for solver in solvers.values()}
    except GrainfitError:
        return set()


def runs_of(
    problem: Problem, solvers: Mapping[str, Solver], records: Iterable[RunRecord]
) -> list[Evaluation]:
    """Return the stored runs of a problem, joined to one evaluation per point.

    Parameters
    ----------
    problem : Problem
        Only points within its intervals count, or not far beyond them.
    solvers : mapping of str to Solver
        By name of the test.
    records : iterable of RunRecord
        Stored runs. Unfinished runs, and failures by the machine or by timeout, are skipped.

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
    for record in records:
        if record.status == "running" or record.may_succeed_next_time:
            continue
        for test, matcher in matchers.items():
            run = matcher.match(record)
            if run is not None and beyond(problem, run[0]) <= REACH:
                found[test].append(_Point(*run, {test: record}))
    points = reduce(_together, (found[test] for test in solvers))
    names = [parameter.name for parameter in problem.parameters]
    return [
        evaluation_of(
            Proposal({name: point.values[name] for name in names}, point.seed, "design"),
            point.runs,
            reused=len(point.runs),
        )
        for point in sorted(points, key=lambda point: point.order(names))
    ]


@dataclass(frozen=True)
class _Point:
    """Values of some parameters and a seed, with the runs there by test."""

    values: Mapping[str, float]
    seed: int
    runs: Mapping[str, RunRecord]

    def order(self, names: Sequence[str]) -> tuple[float, ...]:
        return (*(self.values[name] for name in names), self.seed)


def _together(points: list[_Point], others: list[_Point]) -> list[_Point]:
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
    """Copy the runs of a problem from another store; return the number of new runs.

    Parameters
    ----------
    other : RunStore
        Store to read from.
    problem : Problem
        The calibration problem.
    solvers : mapping of str to Solver
        By name of the test.
    store : RunStore
        Store to copy to.
    """
    there = store.states()
    fitting = is_run_of(problem, solvers)
    new = [
        replace(record, origin=record.origin or other.place)
        for record in other.runs_of(models_of(solvers), "finished")
        if there.get(record.identity) != "finished" and fitting(record)
    ]
    store.save_many(new)
    return len(new)


@contextmanager
def open_source(source: str | Path, key: str = "runs_from") -> Iterator[RunStore]:
    """Open the store of a work folder, or the store at an address, for reading.

    Parameters
    ----------
    source : path or str
        A work folder, or the address of a store.
    key : str
        Key that a fault names.

    Raises
    ------
    InputError
        The folder has no store.
    StoreError
        The store cannot be read.
    """
    if "://" in str(source):
        store = RunStore(str(source), read_only=True)
    else:
        folder = Path(source)
        if not (folder / STORE_NAME).is_file():
            remedy = "Name the folder that 'grainfit run' wrote, or the address of a store."
            raise InputError(replace(not_a_work_folder(source, key), remedy=remedy))
        store = RunStore.read_only(folder)
    try:
        yield store
    finally:
        store.close()
