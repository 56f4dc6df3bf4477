"""What the atlas tells about the targets of a calibration, over the cube of its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array
from grainfit.atlas import messages
from grainfit.atlas.differences import REFERENCE, Difference, usual_difference
from grainfit.atlas.expectation import relative_scatter
from grainfit.atlas.reading import NotInAtlasError, Reading
from grainfit.atlas.shelf import Atlas, shipped_atlas
from grainfit.atlas.surrogate import ResponseModel, clipped
from grainfit.problem import Problem
from grainfit.problem.parameter import Parameter
from grainfit.problem.target import Target
from grainfit.problem.test_scope import named_test
from grainfit.solvers.base import Solver


class _Told(NamedTuple):
    target: Target
    response: str
    reading: Reading
    model: ResponseModel
    solver: Solver

    def inside(self, points: Array) -> Array:
        """Return points of the atlas with a chosen apparatus no farther than the rows."""
        return clipped(points, self.reading.chosen_columns)


class Forecast:
    """Predictions of the atlas for the targets of a problem.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test.
    atlas : Atlas, optional
        By default the one that ships with the package.

    Attributes
    ----------
    problem : Problem
        The same with the targets alone that the atlas tells about; None without any.
    untold : dict of str to str
        Why the atlas tells nothing about the others, by target or curve.
    less_sure : dict of str to str
        By target, which dimensions of its apparatus are beyond those of the atlas.
    """

    def __init__(
        self, problem: Problem, solvers: Mapping[str, Solver], atlas: Atlas | None = None
    ) -> None:
        self._atlas = atlas or shipped_atlas()
        self._parameters = problem.parameters
        self.untold: dict[str, str] = {curve.name: messages.CURVE() for curve in problem.curves}
        self.less_sure: dict[str, str] = {}
        self._told = [
            told for scope in problem.scopes for told in self._told_of(problem, scope.name, solvers)
        ]
        targets = [one.target for one in self._told]
        self.problem = problem.with_targets(targets) if targets else None

    def _told_of(self, problem: Problem, name: str, solvers: Mapping[str, Solver]) -> list[_Told]:
        test = named_test(name, solvers)
        targets = problem.targets_of(test)
        try:
            reading = Reading(solvers[test], problem.middle)
            surrogate = self._atlas.require(reading.stratum.name)
            reading.require_inside(problem.middle)
        except NotInAtlasError as error:
            self.untold |= {target.name: str(error) for target in targets.values()}
            return []
        found = []
        for response, target in targets.items():
            if (model := surrogate.models.get(response)) is None:
                self.untold[target.name] = messages.NO_RESPONSE()
            else:
                found.append(_Told(target, response, reading, model, solvers[test]))
                if beyond := " ".join(reading.beyond()):
                    self.less_sure[target.name] = beyond
        return found

    def predict(self, points: ArrayLike) -> tuple[Array, Array]:
        """Return means and variances of the expected responses, each of shape (m, targets).

        Parameters
        ----------
        points : array_like, shape (m, d)
            Points of the unit cube of the parameters.
        """
        means, variances = [], []
        for one, at, unit in self._at(points):
            mean, variance = one.model.predict_beyond(at, one.reading.chosen_columns)
            if one.solver.name != REFERENCE:
                other = self._difference(one)
                variance = (1 + other.mean) ** 2 * variance + (other.spread * mean) ** 2
                mean = (1 + other.mean) * mean
            means.append(mean * unit)
            variances.append(variance * unit**2)
        return np.column_stack(means), np.column_stack(variances)

    def possible(self, responses: Array) -> Array:
        """Return responses, shape (m, targets), none beyond what is physically possible."""
        limits = [one.reading.kind.responses[one.response].limits for one in self._told]
        low = [-np.inf if low is None else low for low, _ in limits]
        high = [np.inf if high is None else high for _, high in limits]
        return np.clip(responses, low, high)

    @property
    def _readings(self) -> Iterable[Reading]:
        """Tests of the targets, each once."""
        return {id(one.reading): one.reading for one in self._told}.values()

    @cached_property
    def correlation(self) -> Array:
        """Correlation of the errors of the predictions, shape (targets, targets)."""
        found = np.eye(len(self._told))
        for reading in self._readings:
            own = [place for place, one in enumerate(self._told) if one.reading is reading]
            surrogate = self._atlas.require(reading.stratum.name)
            names = [self._told[place].response for place in own]
            found[np.ix_(own, own)] = surrogate.correlation(names)
        return found

    def is_inside(self, points: ArrayLike) -> Array:
        """Return which points of the cube are not outside of the rows, shape (m,)."""
        outside = [found for *_, found in self._outside(points)]
        return np.asarray(~np.any(outside, axis=0))

    def left_out(self, points: ArrayLike) -> Iterator[str]:
        """Yield a sentence for every range of the rows that some points are outside of."""
        found = (reading.left_out(name) for reading, name, at in self._outside(points) if at.any())
        yield from dict.fromkeys(found)

    def _outside(self, points: ArrayLike) -> Iterator[tuple[Reading, str, Array]]:
        """Yield every reading and input with which points are outside of its rows."""
        values = values_at(self._parameters, np.atleast_2d(np.asarray(points)))
        for reading in self._readings:
            for name, found in reading.outside(values).items():
                yield reading, name, found

    def _difference(self, one: _Told) -> Difference:
        stratum = one.reading.stratum.name
        told = self._atlas.difference(one.solver.name, stratum, one.response)
        return told or usual_difference(one.reading.kind.responses[one.response].unit)

    def scatter(self, points: ArrayLike) -> Array:
        """Return standard deviations from run to run, shape (m, targets).

        See `relative_scatter`.
        """
        means, _ = self.predict(points)
        shares = [
            relative_scatter(one.reading.kind.responses[one.response], one.model, one.inside(at))
            for one, at, _ in self._at(points)
        ]
        return np.abs(means) * np.column_stack(shares)

    def chance(self, points: ArrayLike) -> Array:
        """Return the chance that runs have all responses, shape (m,): the least of them."""
        found = {
            id(one.model.chance): (one.model, one.inside(at)) for one, at, _ in self._at(points)
        }
        return np.asarray(np.min([model.chance_at(at) for model, at in found.values()], axis=0))

    def _at(self, points: ArrayLike) -> Iterator[tuple[_Told, Array, Array]]:
        """Yield every target that is told with the points in the atlas, and the unit there."""
        values = values_at(self._parameters, np.atleast_2d(np.asarray(points)))
        shares = {id(one.reading): one.reading.shares(values) for one in self._told}
        for one in self._told:
            yield one, shares[id(one.reading)], one.reading.unit(one.response, values)


def values_at(parameters: Sequence[Parameter], points: Array) -> dict[str, Array]:
    """Return the values of the parameters at points of their unit cube, SI, each of shape (m,)."""
    found = {}
    for axis, one in enumerate(parameters):
        share = points[:, axis]
        if one.scale == "log":
            found[one.name] = one.minimum * (one.maximum / one.minimum) ** share
        else:
            found[one.name] = one.minimum + share * (one.maximum - one.minimum)
    return found
