"""Expected responses of the atlas as runs of relatives of the tests: they guide a search."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from grainfit.arrays import Array
from grainfit.atlas.expectation import Expectation
from grainfit.atlas.forecast import values_at
from grainfit.atlas.reading import DamagedAtlasError, NotInAtlasError
from grainfit.atlas.shelf import Atlas
from grainfit.evaluation import Evaluation, Proposal, Response, scalars
from grainfit.metamodels.known_runs import nearest_and_spread
from grainfit.metamodels.unit_cube import spread_points
from grainfit.problem import Problem, Relative, Target, TestScope
from grainfit.solvers.base import Solver

#: Points at which the atlas is asked, and how many of them guide.
_ASKED, _KEPT = 512, 60
#: Most free parameters that so few points tell about in the time of a run.
_MOST_PARAMETERS = 5


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
    def of_points(
        cls,
        points: Iterable[tuple[Mapping[str, float], Mapping[str, Response]]],
        tests: Sequence[str],
        fault: str = "",
    ) -> Guide:
        """Return the guide of the responses of relatives at parameters."""
        asked = tuple(Relative(test, None).name for test in tests)
        evaluations = [
            Evaluation(Proposal(parameters, number, "design", asked), responses)
            for number, (parameters, responses) in enumerate(points)
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
                }
                for one in self.evaluations
            ],
        }

    @classmethod
    def from_json(cls, plain: Mapping[str, Any]) -> Guide:
        """Return the guide of `to_json`; an empty one of an empty mapping."""
        points = [
            (one["parameters"], {name: Response(*r) for name, r in one["responses"].items()})
            for one in plain.get("points", ())
        ]
        return cls.of_points(points, tuple(plain.get("tests", ())))


def guide(
    problem: Problem,
    solvers: Mapping[str, Solver],
    seed: int,
    without: Collection[str] = (),
    atlas: Atlas | None = None,
) -> Guide:
    """Return what the atlas expects, at half of the points where it agrees with the targets.

    The nearest apparatus and dry spheres stand for what it does not have: the runs of the search
    tell the difference.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test.
    seed : int
        Decides the points.
    without : collection of str
        Scopes of the problem that something else guides.
    atlas : Atlas, optional
        By default the one that ships with the package.
    """
    if problem.dimension > _MOST_PARAMETERS:
        return Guide()
    points = spread_points(_ASKED, problem.dimension, np.random.default_rng(seed))
    found: dict[str, list[Response]] = {}
    fault = ""
    for scope in problem.scopes:
        try:
            if scope.name not in without:
                found |= _expected(problem, scope, solvers, points, atlas)
        except DamagedAtlasError as error:
            fault = str(error)
        except NotInAtlasError:
            continue
    targets = [target for target in problem.targets if target.name in found]
    if not targets:
        return Guide(fault=fault)
    relatives = {t.name: Relative(problem.scope_of(t.name).name, None) for t in targets}
    tests = tuple(dict.fromkeys(one.of for one in relatives.values()))
    return Guide.of_points(
        [
            (
                problem.from_unit(points[place]),
                {relatives[n].response_name(n): every[place] for n, every in found.items()},
            )
            for place in _chosen(targets, found)
        ],
        tests,
        fault,
    )


def _chosen(targets: Sequence[Target], found: Mapping[str, Sequence[Response]]) -> list[int]:
    """Return places of points: half are those that agree best with the targets."""
    off = [
        [(one.value - target.value) / target.tolerance for one in found[target.name]]
        for target in targets
    ]
    return sorted(nearest_and_spread((np.array(off) ** 2).sum(axis=0), _KEPT))


def _expected(
    problem: Problem,
    scope: TestScope,
    solvers: Mapping[str, Solver],
    points: Array,
    atlas: Atlas | None,
) -> dict[str, list[Response]]:
    """Return what the atlas expects of a test at points of the unit cube, by target.

    Raises
    ------
    NotInAtlasError
        It tells nothing about the test.
    """
    # The scope of the only test has no name.
    test = scope.name or next(iter(solvers))
    targets = problem.targets_of(test)
    expectation = Expectation(solvers[test], problem.middle, atlas)
    if not any(map(expectation.tells_of, scope.parameters)):
        return {}
    expected = expectation.responses(values_at(problem.parameters, points), targets)
    found = {}
    for name, one in expected.items():
        target = targets[name]
        means = problem.ratios.get(target.name, 1.0) * one.means
        pairs = zip(means.tolist(), (np.abs(means) * one.errors).tolist(), strict=True)
        found[target.name] = [Response(*pair) for pair in pairs]
    return found
