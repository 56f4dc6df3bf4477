"""Find stored runs of near problems: of the same test, with fixed numbers that differ a little.

They are runs of other models, so they count as those of a relative (`grainfit.problem.Relative`):
they tell a search where its own runs are worth making, and no verdict rests on them. Numbers are
compared in natural units, so that particle size and density do not matter.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from grainfit.bulk_tests.apparatus import apparatus_of
from grainfit.bulk_tests.natural_units import NaturalRun, natural_run
from grainfit.campaign import messages
from grainfit.campaign.absent_responses import with_needed
from grainfit.campaign.reuse import RunAtScale, RunMatcher, ScaledRunMatcher, needed_responses
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.contact_models.registry import material_parameter
from grainfit.errors import GrainfitError
from grainfit.evaluation import Evaluation, Proposal, Response, response_name, scalars
from grainfit.formatting import (
    counted,
    in_usual_unit,
    millimetres,
    number,
    short_names,
    unit_for_people,
    with_unit,
)
from grainfit.metamodels.known_runs import LARGEST_DISTANCE, distance_outside, nearest_runs
from grainfit.problem import Problem, Relative
from grainfit.solvers.base import Solver

#: Largest share by which a fixed number of a near run may differ, and that of a count, such as the
#: number of particles.
LARGEST_CHANGE, LARGEST_CHANGE_OF_COUNT = 0.2, 1.0
#: Most near runs of a test: they guide, and every metamodel asks them.
MOST_NEAR = 60
#: Values of one number that are named one by one, and names that are.
_MOST_NAMED = 3
#: Share up to which numbers are the same but for the digits that conversions lose.
_SAME = 1e-6
#: Of a run, what may be another and is no number of the experiment.
_VERSION, _RANKS = "version", "ranks"
_SIZES = ("diameters", "mass_fractions")
#: Hexadecimal digits of an identity that serve as a seed: near runs may share those of own runs.
_DIGITS_OF_SEED = 12

Shown = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class NearRuns:
    """Runs of near problems, as those of relatives.

    Parameters
    ----------
    evaluations : tuple of Evaluation
        Their responses carry the names of the relatives.
    tests : tuple of str
        Scopes of the problem that they are near to.
    notice : str
        Their number, and what differs, for people; empty without any.
    """

    evaluations: tuple[Evaluation, ...] = ()
    tests: tuple[str, ...] = ()
    notice: str = ""

    @property
    def identities(self) -> list[str]:
        """Identities of the runs in the store."""
        return [run for one in self.evaluations for run in one.runs.values()]


@dataclass(frozen=True)
class _NearRun:
    record: RunRecord
    values: Mapping[str, float]
    responses: Mapping[str, Response]
    differs: Mapping[str, tuple[float, str]]


class _NearRunMatcher:
    """Recognise runs that are near to those of a test, and bring them to its scale."""

    def __init__(self, solver: Solver, problem: Problem, needed: Collection[str]) -> None:
        self._needed = needed
        self._test = solver.bulk_test
        self._exact = RunMatcher(solver, problem)
        self._scaled = ScaledRunMatcher(solver, problem)
        self._known: dict[str, bool] = {}
        #: What differs in the apparatus, by the hash of the model.
        self._apparatus: dict[str, dict[str, tuple[float, str]]] = {}

    def is_model_near(self, run: NaturalRun) -> bool:
        """Whether the apparatus of a run is near to that of the test."""
        here = self._scaled.natural
        if run.model_hash not in self._known:
            self._known[run.model_hash] = here is not None and _is_model_near(here, run)
        return self._known[run.model_hash]

    def match(self, stored: RunRecord) -> _NearRun | None:
        """Return a run at the scale of the problem; None if it is its own, or not near."""
        record, run = with_needed(stored, self._needed), natural_run(stored.definition)
        if record.status != "finished" or run is None or not self.is_model_near(run):
            return None
        found = self._scaled.at_scale(run, record.definition.seed)
        if found is None or self._exact.match(record) is not None:
            return None
        numbers, others = found.here.numbers, run.numbers
        if numbers.keys() != others.keys() or not all(
            _is_near(numbers[name], others[name]) for name in numbers
        ):
            return None
        responses = scalars(found.responses_of(record))
        return _NearRun(record, found.values, responses, dict(self._differences(found)))

    def _differences(self, found: RunAtScale) -> Iterator[tuple[str, tuple[float, str]]]:
        """Yield what differs, with the value of the stored run at the scale of the problem."""
        here, run, scale = found.here, found.run, found.here.scale
        if here.model[_VERSION] != run.model[_VERSION]:
            yield _VERSION, (0.0, str(run.model[_VERSION]))
        for name, value in run.numbers.items():
            known = material_parameter(name)
            if known is not None and not _is_same(here.numbers[name], value):
                si = value * scale.of(known.unit)
                yield name, (si, with_unit(number(si, 3), unit_for_people(known.unit)))
        if run.model_hash not in self._apparatus:
            self._apparatus[run.model_hash] = dict(self._apparatus_of(found))
        yield from self._apparatus[run.model_hash].items()

    def _apparatus_of(self, found: RunAtScale) -> Iterator[tuple[str, tuple[float, str]]]:
        """Yield what differs in the apparatus: what was given, where something was."""
        run, here = found.run, found.here
        options = [*_differing_options(here, run)]
        # The same apparatus with other particles differs in diameters, and not in SI units.
        there, ours = run.test.resolved_options(), here.test.resolved_options()
        kept = [name for name in options if not _is_same(ours[name], there[name])]
        if len(kept) < len(options):
            yield "particle diameter", (run.scale.length, millimetres(run.scale.length))
        given = {one.option for one in apparatus_of(run.test) if one.origin == "given"}
        chosen = [
            name for name in kept if name in given or getattr(self._test, name, None) is not None
        ]
        for name in chosen or kept[: 1 if len(kept) == len(options) else 0]:
            yield name, _shown_option(found, name)


def _shown_option(found: RunAtScale, name: str) -> tuple[float, str]:
    value = found.run.model["test"]["options"][name]
    [key] = [key for key in found.run.test.option_keys() if key.name == name]
    unit = str(getattr(key.kind, "unit", "") or "")
    if not _is_number(value):
        return 0.0, str(value)
    si = float(value * found.here.scale.of(unit))
    return si, in_usual_unit(si, unit)


def _differing_options(here: NaturalRun, run: NaturalRun) -> Iterator[str]:
    ours, theirs = here.model["test"]["options"], run.model["test"]["options"]
    for name, value in theirs.items():
        if not _is_same(ours[name], value):
            yield name


def _is_model_near(here: NaturalRun, run: NaturalRun) -> bool:
    ours, theirs = _parts(here.model), _parts(run.model)
    return ours[0] == theirs[0] and _is_near(ours[1], theirs[1])


def _parts(model: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return what must be the same in a model, and its numbers, which may differ a little."""
    test = dict(model["test"])
    numbers = {name: test.pop(name, None) for name in ("options", *_SIZES)}
    rest = {name: v for name, v in model.items() if name not in ("test", _VERSION, _RANKS)}
    return (rest, test), numbers


def _is_near(one: Any, other: Any) -> bool:
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_is_near(one[n], other[n]) for n in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_is_near, one, other))
    if not (_is_number(one) and _is_number(other)):
        return bool(one == other)
    is_count = isinstance(one, int) and isinstance(other, int)
    most = LARGEST_CHANGE_OF_COUNT if is_count else LARGEST_CHANGE
    low, high = sorted((abs(one), abs(other)))
    return bool(one == other) or (one * other > 0 and high <= low * (1.0 + most) * (1.0 + _SAME))


def _is_same(one: Any, other: Any) -> bool:
    if _is_number(one) and _is_number(other):
        return bool(abs(one - other) <= _SAME * max(abs(one), abs(other)))
    return bool(one == other)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _matchers(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, _NearRunMatcher]:
    """Return the matchers of the bulk tests that have a target, by name of the test."""
    if len(solvers) > 1 and not problem.tests:
        return {}
    needed = needed_responses(problem, solvers)
    found = {}
    for test, solver in solvers.items():
        if solver.bulk_test is not None and needed.get(test):
            try:
                found[test] = _NearRunMatcher(solver, problem, needed[test])
            except GrainfitError:
                # Its program is missing; another place says so.
                continue
    return found


def near_records(
    store: RunStore, problem: Problem, solvers: Mapping[str, Solver]
) -> list[RunRecord]:
    """Return the finished runs of a store whose apparatus is near to that of a test.

    Parameters
    ----------
    store : RunStore
        Store to read from.
    problem : Problem
        The calibration problem, with the scopes of its tests.
    solvers : mapping of str to Solver
        By name of the test.
    """
    matchers = _matchers(problem, solvers)
    if not matchers:
        return []
    models = [natural_run(record.definition) for record in store.models_at_any_scale()]
    near = {
        model.model_hash
        for model in models
        if model is not None and any(m.is_model_near(model) for m in matchers.values())
    }
    return store.runs_at_any_scale(near) if near else []


def near_runs(
    problem: Problem, solvers: Mapping[str, Solver], records: Iterable[RunRecord], seed: int
) -> NearRuns:
    """Return the runs of near problems, at most `MOST_NEAR` of a test.

    A run is near when it is of the same test, solver and procedure, when its fixed parameters and
    its apparatus differ by at most `LARGEST_CHANGE` each, and counts by a factor of two. Of too
    many, half are those nearest to what looks like the answer, and half are spread over the rest.

    Parameters
    ----------
    problem : Problem
        The calibration problem, with the scopes of its tests.
    solvers : mapping of str to Solver
        By name of the test.
    records : iterable of RunRecord
        Stored runs. Those of the problem itself are left out.
    seed : int
        Decides the choice of too many.
    """
    pool = sorted(records, key=lambda record: record.identity)
    evaluations: list[Evaluation] = []
    tests: list[str] = []
    shown: list[Shown] = []
    differing: dict[str, dict[str, float]] = defaultdict(dict)
    for test, matcher in _matchers(problem, solvers).items():
        found = [run for record in pool if (run := matcher.match(record)) is not None]
        by_run = {run.record.identity: run for run in found}
        own = _chosen(problem, test, len(solvers), by_run.values(), seed)
        if not own:
            continue
        evaluations += own
        tests.append(test if problem.tests else "")
        for one in own:
            [identity] = one.runs.values()
            differs = by_run[identity].differs
            shown.append(tuple((name, words) for name, (_, words) in differs.items()))
            for name, (value, words) in differs.items():
                differing[name][words] = value
    if not evaluations:
        return NearRuns()
    notice = messages.NEAR_RUNS(
        runs=counted(len(evaluations), "run"),
        problems=counted(len(set(shown)), "near problem"),
        differs=_in_words(differing),
    )
    return NearRuns(tuple(evaluations), tuple(tests), notice)


def _chosen(
    problem: Problem, test: str, tests: int, found: Iterable[_NearRun], seed: int
) -> list[Evaluation]:
    """Return the chosen runs of a test, with the names of its relative."""
    names = [target.name for target in problem.targets]
    scope = problem.scope_of_test(test if problem.tests else "")
    targets = [target for target in problem.targets if target.name in scope.targets]
    relative = Relative(scope.name, None)
    near = []
    for run in found:
        values = problem.middle | dict(run.values)
        responses = {response_name(test, name, tests): one for name, one in run.responses.items()}
        proposal = Proposal(
            {parameter.name: values[parameter.name] for parameter in problem.parameters},
            int(run.record.identity[:_DIGITS_OF_SEED], 16),
            "design",
            (relative.name,),
        )
        known = {name: one for name, one in responses.items() if name in names}
        one = Evaluation(proposal, known, runs={relative.name: run.record.identity})
        if known and distance_outside(problem, run.values) <= LARGEST_DISTANCE:
            near.append(one.scaled(problem.ratios))
    places = {tuple(one.proposal.parameters[n] for n in scope.parameters) for one in near}
    # As many as a metamodel needs.
    if len(places) < len(scope.parameters) + 2 or not targets:
        return []
    chosen = nearest_runs(problem.with_targets(targets), near, seed=seed, most=MOST_NEAR)
    return [
        replace(
            one,
            responses={relative.response_name(name): r for name, r in one.responses.items()},
        )
        for one in chosen
    ]


def _in_words(differing: Mapping[str, Mapping[str, float]]) -> str:
    """Return what differs, with its values in the order of their size."""
    names = [*differing]
    parts = []
    for name, short in zip(names, short_names(names), strict=True):
        values = sorted(differing[name], key=lambda words, name=name: differing[name][words])  # type: ignore[misc]
        few = len(values) <= _MOST_NAMED
        parts.append(f"{short} {', '.join(values) if few else f'{values[0]} to {values[-1]}'}")
    left = len(parts) - _MOST_NAMED
    more = [f"{counted(left, 'other number')}"] if left > 0 else []
    return "; ".join([*parts[:_MOST_NAMED], *more])


def take_near_runs(
    other: RunStore, problem: Problem, solvers: Mapping[str, Solver], store: RunStore, seed: int
) -> int:
    """Copy the runs of near problems from another store; return how many it has.

    Parameters
    ----------
    other : RunStore
        Store to read from.
    problem, solvers, seed
        As of `near_runs`.
    store : RunStore
        Store to copy to.
    """
    records = {record.identity: record for record in near_records(other, problem, solvers)}
    there = store.states()
    found = near_runs(problem, solvers, records.values(), seed).identities
    store.save_many(
        replace(records[run], origin=records[run].origin or other.place)
        for run in found
        if run not in there
    )
    return len(found)
