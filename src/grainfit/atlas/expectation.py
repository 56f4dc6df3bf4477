"""Responses of a test over many parameter sets, by the atlas: what they depend on, and how much."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from grainfit.arrays import Array
from grainfit.atlas.reading import Reading
from grainfit.atlas.shelf import Atlas, shipped_atlas
from grainfit.atlas.surrogate import ResponseModel, least_chance
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.solvers.base import Solver

#: Share of an input's range below its lower end up to which responses follow the trend.
_BEYOND = 0.5


@dataclass(frozen=True)
class ExpectedResponse:
    """A response at parameter sets, by the atlas.

    Parameters
    ----------
    means : ndarray, shape (m,)
        Expected response, in its unit.
    scatter : float
        Relative standard deviation of a run.
    model : ResponseModel
        Of the response.
    points : ndarray, shape (m, inputs)
        The parameter sets in the atlas.
    """

    means: Array
    scatter: float
    model: ResponseModel
    points: Array

    @property
    def errors(self) -> Array:
        """Standard errors of the atlas over the means, shape (m,)."""
        return self.model.relative_error(self.points)

    @property
    def covariance(self) -> Array:
        """Covariance of the errors of the atlas, over the means, shape (m, m)."""
        return self.model.relative_covariance(self.points)


class Expectation:
    """What the atlas expects of a test.

    Parameters
    ----------
    solver : Solver
        Of the test.
    parameters : mapping of str to float
        Free parameters somewhere in their intervals.
    atlas : Atlas, optional
        By default the one that ships with the package.
    is_nearest : bool
        Whether the nearest rows stand for what the atlas does not have, see `Reading`.

    Raises
    ------
    NotInAtlasError
        The atlas has no such test, particles, contact law or apparatus.
    """

    def __init__(
        self,
        solver: Solver,
        parameters: Mapping[str, float],
        atlas: Atlas | None = None,
        *,
        is_nearest: bool = True,
    ) -> None:
        self._reading = Reading(solver, parameters, is_nearest=is_nearest)
        self._models = (atlas or shipped_atlas()).require(self._reading.stratum.name).models

    def tells_of(self, parameter: str) -> bool:
        """Return whether it says what a parameter does."""
        return self._reading.tells_of(parameter)

    def responses(
        self, values: Mapping[str, Array], names: Collection[str]
    ) -> dict[str, ExpectedResponse]:
        """Return responses at parameter sets, by name; those with too few rows are left out.

        Beyond the rows, responses follow the trend for a while; then the material at its end stands
        for any farther one.

        Parameters
        ----------
        values : mapping of str to ndarray
            Free parameters, SI, each of shape (m,).
        names : collection of str
            Of the responses that are wanted.
        """
        points = self._points(values)
        return {name: self._expected(name, points, values) for name in self._told(names)}

    def chance(self, values: Mapping[str, Array], names: Collection[str]) -> Array:
        """Return the chance that runs have all of some responses, shape (m,): the least of them.

        Parameters
        ----------
        values : mapping of str to ndarray
            Free parameters, SI, each of shape (m,).
        names : collection of str
            Of the responses; the atlas has one of them at least.
        """
        told = [self._models[name] for name in self._told(names)]
        return least_chance(told, self._points(values))

    def _told(self, names: Collection[str]) -> list[str]:
        return [name for name in self._models if name in names]

    def _points(self, values: Mapping[str, Array]) -> Array:
        limits = [span.limit for span in self._reading.ranges.values()]
        return np.clip(self._reading.shares(values), -_BEYOND, limits)

    def _expected(self, name: str, points: Array, values: Mapping[str, Array]) -> ExpectedResponse:
        model = self._models[name]
        shares = relative_scatter(self._reading.kind.responses[name], model, points)
        return ExpectedResponse(
            model.mean(points) * self._reading.unit(name, values),
            float(np.median(shares)),
            model,
            points,
        )


def relative_scatter(info: ResponseInfo, model: ResponseModel, points: Array) -> Array:
    """Return the standard deviation of a run over the response, shape (m,).

    That of recorded trials where there are some: the rows are too few to tell scatter from what
    they do not resolve.
    """
    if info.trials is not None:
        return np.full(len(points), info.trials.scatter)
    return model.relative_scatter(points)
