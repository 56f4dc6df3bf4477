"""Expected responses of the atlas as runs of relatives of the tests: they guide a search."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grainfit.arrays import Array
from grainfit.atlas import messages
from grainfit.atlas.expectation import Expectation
from grainfit.atlas.forecast import values_at
from grainfit.atlas.reading import DamagedAtlasError, NotInAtlasError, Reading
from grainfit.atlas.shelf import Atlas
from grainfit.evaluation import Evaluation, Proposal, Response, scalars
from grainfit.metamodels.known_runs import nearest_and_spread
from grainfit.metamodels.unit_cube import spread_points
from grainfit.problem import Problem, Relative, Target, TestScope
from grainfit.problem.test_scope import named_test
from grainfit.solvers.base import Solver

#: Points at which the atlas is asked, and how many of them guide.
_ASKED, _KEPT = 512, 60
#: Most free parameters that so few points tell about in the time of a run.
_MOST_PARAMETERS = 5
#: Chance of all responses below which a run is expected to fail.
_FAILS = 0.5


class Told(NamedTuple):
    """What the atlas expects at a point: responses of relatives, and the relatives that fail."""

    parameters: Mapping[str, float]
    responses: Mapping[str, Response]
    failing: Sequence[str] = ()


class Guide(NamedTuple):
    """What the atlas expects at points of the intervals.

    Parameters
    ----------
    evaluations : sequence of Evaluation
        Expected responses with their errors, as runs of the relatives of the tests.
    tests : sequence of str
        Scopes of the problem that it tells about.
    fault : str
        Why it does not tell of others that it has; empty where it is not damaged.
    """

    evaluations: Sequence[Evaluation] = ()
    tests: Sequence[str] = ()
    fault: str = ""

    @classmethod
    def of_points(cls, points: Iterable[Told], tests: Sequence[str], fault: str = "") -> Guide:
        """Return the guide of what is expected at points."""
        asked = tuple(Relative(test, None).name for test in tests)
        why = messages.EXPECTED_TO_FAIL()
        evaluations = [
            Evaluation(
                Proposal(told.parameters, number, "design", asked),
                told.responses,
                dict.fromkeys(told.failing, why),
            )
            for number, told in enumerate(points)
        ]
        return cls(tuple(evaluations), tuple(tests), fault)

    def to_json(self) -> dict[str, Any]:
        """Return the guide as JSON, without its fault."""
        return {
            "tests": list(self.tests),
            "points": [
                {
                    "parameters": dict(one.proposal.parameters),
                    "responses": {
                        name: [found.value, found.standard_error]
                        for name, found in scalars(one.responses).items()
                    },
                    "failing": list(one.failures),
                }
                for one in self.evaluations
            ],
        }

    @classmethod
    def from_json(cls, plain: Mapping[str, Any]) -> Guide:
        """Return the guide of `to_json`; an empty one of an empty mapping."""
        points = [
            Told(
                one["parameters"],
                {name: Response(*r) for name, r in one["responses"].items()},
                one.get("failing", ()),
            )
            for one in plain.get("points", ())
        ]
        return cls.of_points(points, tuple(plain.get("tests", ())))


def guided(
    problem: Problem, solvers: Mapping[str, Solver], without: Collection[str] = ()
) -> list[TestScope]:
    """Return the tests of which the atlas may guide the search, without a look at its rows.

    Nothing stands for what it does not have: a search that is led past the answer takes longer.
    Tests that have a relative are guided by that.

    Parameters
    ----------
    problem, solvers, without
        As of `guide`.
    """
    if problem.dimension > _MOST_PARAMETERS:
        return []
    others = {*without, *(one.of for one in problem.relatives)}
    left = [scope for scope in problem.scopes if scope.name not in others]
    return [scope for scope in left if _is_told(problem, scope, solvers)]


def _is_told(problem: Problem, scope: TestScope, solvers: Mapping[str, Solver]) -> bool:
    test = named_test(scope.name, solvers)
    try:
        reading = Reading(solvers[test], problem.middle)
    except NotInAtlasError:
        return False
    responses = reading.kind.responses.keys() & problem.targets_of(test).keys()
    return bool(responses) and any(map(reading.tells_of, scope.parameters))


def guide(
    problem: Problem,
    solvers: Mapping[str, Solver],
    seed: int,
    without: Collection[str] = (),
    atlas: Atlas | None = None,
) -> Guide:
    """Return what the atlas expects, at half of the points where it agrees with the targets.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets, and relatives of tests.
    solvers : mapping of str to Solver
        By name of the test.
    seed : int
        Decides the points.
    without : collection of str
        Scopes of the problem that earlier runs guide.
    atlas : Atlas, optional
        By default the one that ships with the package.
    """
    if not (scopes := guided(problem, solvers, without)):
        return Guide()
    points = spread_points(_ASKED, problem.dimension, np.random.default_rng(seed))
    found: dict[str, list[Response]] = {}
    fails: dict[str, NDArray[np.bool_]] = {}
    fault = ""
    for scope in scopes:
        try:
            told = _expected(problem, scope, solvers, points, atlas)
        except DamagedAtlasError as error:
            fault, told = str(error), None
        except NotInAtlasError:
            told = None
        if told is not None:
            found |= told.responses
            fails[scope.name] = told.chances < _FAILS
    targets = [target for target in problem.targets if target.name in found]
    if not targets:
        return Guide(fault=fault)
    relatives = {t.name: Relative(problem.scope_of(t.name).name, None) for t in targets}

    def told_at(place: int) -> Told:
        responses = {
            relatives[name].response_name(name): every[place]
            for name, every in found.items()
            if not fails[relatives[name].of][place]
        }
        failing = tuple(Relative(test, None).name for test, one in fails.items() if one[place])
        return Told(problem.from_unit(points[place]), responses, failing)

    return Guide.of_points(map(told_at, _chosen(targets, found)), tuple(fails), fault)


def _chosen(targets: Sequence[Target], found: Mapping[str, Sequence[Response]]) -> list[int]:
    """Return places of points: half are those that agree best with the targets."""
    off = [
        [(one.value - target.value) / target.tolerance for one in found[target.name]]
        for target in targets
    ]
    return sorted(nearest_and_spread((np.array(off) ** 2).sum(axis=0), _KEPT))


class _Expected(NamedTuple):
    """Responses by target, and the chance of all of them, at the points."""

    responses: dict[str, list[Response]]
    chances: Array


def _expected(
    problem: Problem,
    scope: TestScope,
    solvers: Mapping[str, Solver],
    points: Array,
    atlas: Atlas | None,
) -> _Expected | None:
    """Return what the atlas expects of a test at points of the unit cube.

    Raises
    ------
    NotInAtlasError
        It tells nothing about the test.
    """
    test = named_test(scope.name, solvers)
    targets = problem.targets_of(test)
    expectation = Expectation(solvers[test], problem.middle, atlas, is_nearest=False)
    values = values_at(problem.parameters, points)
    expected = expectation.responses(values, targets)
    if not expected:
        return None
    found = {}
    for name, one in expected.items():
        target = targets[name]
        means = problem.ratios.get(target.name, 1.0) * one.means
        pairs = zip(means.tolist(), (np.abs(means) * one.errors).tolist(), strict=True)
        found[target.name] = [Response(*pair) for pair in pairs]
    return _Expected(found, expectation.chance(values, targets))
