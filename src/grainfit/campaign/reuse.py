"""Which runs of a store belong to a problem, whatever they were made for.

A run's definition says all that decides its outcome. So a run whose definition is what the solvers
of a problem would write for some values of its free parameters and some seed *is* a run of that
problem: of a calibration with other targets, other intervals or another strategy, or of none.
"""

from __future__ import annotations

import json
import math
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
from grainfit.problem import Problem
from grainfit.solvers.base import Solver

_Path = tuple[str | int, ...]
#: Most runs of others that a calibration learns from: the effort of metamodels grows with the cube.
MOST_RUNS = 150


class RunMatcher:
    """Finds values of the free parameters and the seed in definitions of a solver's runs.

    Where they stand follows from comparing two definitions that differ in nothing else.

    Parameters
    ----------
    solver : Solver
        Whose runs are to be recognised.
    problem : Problem
        Names the free parameters and their intervals.
    """

    def __init__(self, solver: Solver, problem: Problem) -> None:
        self._solver = solver
        # Different values for all parameters, even those of equal intervals.
        shares = [0.2 * number / problem.dimension for number in range(problem.dimension)]
        low = problem.from_unit([0.27 + share for share in shares])
        high = problem.from_unit([0.53 + share for share in shares])
        first, second = (_leaves(solver, *sample) for sample in ((low, 12347), (high, 54323)))
        self._fixed = {path: leaf for path, leaf in first.items() if second.get(path) == leaf}
        varied = first.keys() - self._fixed.keys()
        places = {
            name: [p for p in varied if first[p] == low[name] and second.get(p) == high[name]]
            for name in low
        }
        # Not every test takes every parameter.
        self._places = {name: paths for name, paths in places.items() if paths}
        self._seeds = [p for p in varied if first[p] == 12347 and second.get(p) == 54323]
        seen = {path for paths in (*self._places.values(), self._seeds) for path in paths}
        #: Whether the definition holds nothing that is computed from parameters or seed.
        self._is_plain = seen == varied and first.keys() == second.keys()

    def match(self, record: RunRecord) -> tuple[dict[str, float], int] | None:
        """Return values and seed of a run; None when it is not a run of this solver and problem.

        The values are those of the parameters that the solver takes.
        """
        leaves = dict(_flatten(record.definition))
        if any(leaves.get(path) != leaf for path, leaf in self._fixed.items()):
            return None
        try:
            values = {name: float(leaves[paths[0]]) for name, paths in self._places.items()}
            seed = int(leaves[self._seeds[0]]) if self._seeds else 0
        except (KeyError, IndexError, TypeError, ValueError):
            return None
        return (values, seed) if self._agrees(leaves, values, seed) else None

    def _agrees(self, leaves: Mapping[_Path, Any], values: dict[str, float], seed: int) -> bool:
        if not self._is_plain:
            try:
                return _leaves(self._solver, values, seed) == leaves
            except GrainfitError:
                return False
        places = [(path, values[name]) for name, paths in self._places.items() for path in paths]
        places += [(path, seed) for path in self._seeds]
        return len(leaves) == len(self._fixed) + len(places) and all(
            leaves.get(path) == value for path, value in places
        )


def runs_of(
    problem: Problem, solvers: Mapping[str, Solver], records: Iterable[RunRecord]
) -> list[Evaluation]:
    """Return the runs of a problem among others, those of all tests at a point together.

    Parameters
    ----------
    problem : Problem
        Only points within its intervals count.
    solvers : mapping of str to Solver
        By name of the test.
    records : iterable of RunRecord
        Finished and failed ones are taken, except those that failed by the machine or by time.

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
            if run is not None and _is_inside(problem, run[0]):
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
    """Values of some parameters and a seed, with the runs that were made there by test."""

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
    """Return what tells whether a run is one of a problem, of any of its tests."""
    try:
        matchers = [RunMatcher(solver, problem) for solver in solvers.values()]
    except GrainfitError:
        return lambda _record: False
    return lambda record: any(r.match(record) is not None for r in matchers)


def most_telling(
    problem: Problem, evaluations: Sequence[Evaluation], most: int = MOST_RUNS
) -> list[Evaluation]:
    """Return a bearable number of evaluations: those nearest the targets, and some of the others.

    Parameters
    ----------
    problem : Problem
        Has the targets.
    evaluations : sequence of Evaluation
        Those that failed tell where runs fail, and count as farthest from the targets.
    most : int
        How many.
    """
    if len(evaluations) <= most:
        return list(evaluations)
    ranked = sorted(evaluations, key=lambda evaluation: _distance(problem, evaluation))
    nearest, others = ranked[: most // 2], ranked[most // 2 :]
    left = most - len(nearest)
    return nearest + [others[(number * len(others)) // left] for number in range(left)]


def _distance(problem: Problem, evaluation: Evaluation) -> float:
    if any(target.name not in evaluation.responses for target in problem.targets):
        return math.inf
    return sum(
        ((evaluation.responses[target.name].value - target.value) / target.accepted_deviation) ** 2
        for target in problem.targets
    )


def _is_inside(problem: Problem, values: Mapping[str, float]) -> bool:
    return all(
        parameter.contains(values[parameter.name])
        for parameter in problem.parameters
        if parameter.name in values
    )


def _leaves(solver: Solver, values: Mapping[str, float], seed: int) -> dict[_Path, Any]:
    # As a store gives it back: lists for tuples.
    return dict(_flatten(json.loads(json.dumps(solver.definition(values, seed)))))


def _flatten(data: Any, path: _Path = ()) -> Iterator[tuple[_Path, Any]]:
    # Definitions come from JSON, and there may be many: their types are exactly these.
    kind = type(data)
    if kind is dict and data:
        for key, value in data.items():
            yield from _flatten(value, (*path, key))
    elif kind is list and data:
        for index, value in enumerate(data):
            yield from _flatten(value, (*path, index))
    else:
        yield path, data


def take_runs(
    other: RunStore, problem: Problem, solvers: Mapping[str, Solver], store: RunStore
) -> int:
    """Copy those runs of another store that are runs of a problem; return how many were new.

    Parameters
    ----------
    other : RunStore
        Is only read.
    problem : Problem
        What is calibrated.
    solvers : mapping of str to Solver
        By name of the test.
    store : RunStore
        Where the copies go.
    """
    there = store.states()
    fitting = is_run_of(problem, solvers)
    new = [
        replace(record, origin=record.origin or other.place)
        for record in other.runs("finished")
        if there.get(record.identity) != "finished" and fitting(record)
    ]
    store.save_many(new)
    return len(new)


@contextmanager
def open_source(source: str | Path, key: str = "runs_from") -> Iterator[RunStore]:
    """Open the store of a work folder, or one at an address, to read.

    Parameters
    ----------
    source : path or str
        A work folder, or the address of a store.
    key : str
        What a fault is said to be of.

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
