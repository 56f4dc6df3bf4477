"""Slopes of responses over a cloud of parameter sets, from a few runs in it or by the atlas."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import hadamard

from grainfit.arrays import Array
from grainfit.atlas.expectation import ExpectedResponse
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.problem import Parameter
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.knowledge import Knowledge, in_relative_units, in_si_units

#: Share of a cloud at an end of a direction.
_END = 0.05
#: Standard errors below which a slope counts as none: of runs, and of the atlas, whose metamodels
#: leave most of what chance makes out of their means.
_BY_CHANCE, _BY_CHANCE_IN_ATLAS = 2.0, 1.0
#: Members of an even spread, and most of a cloud over which slopes by the atlas are taken.
_MEMBERS = 128
#: Rankings that take the correlations from an even spread.
_RANKINGS = 4
#: Smallest variance along a direction, over the largest: below it, the cloud is flat.
_FLAT = 1e-9


@dataclass(frozen=True)
class Run:
    """One run of a test: the parameter set, by its number, the seed, and the response."""

    point: int
    seed: int
    value: float


@dataclass(frozen=True)
class Cloud:
    """Parameter sets that agree with the measurements, in relative units.

    Parameters
    ----------
    parameters : tuple of Parameter
        Free parameters.
    points : ndarray, shape (n, d)
        ln p, or p over the middle of its interval where that reaches zero.
    """

    parameters: tuple[Parameter, ...]
    points: Array

    @classmethod
    def of(cls, parameters: Sequence[Parameter], values: Array) -> Cloud:
        """Return the cloud of parameter sets in SI units, shape (n, d)."""
        return cls(tuple(parameters), _relative(parameters, values))

    @classmethod
    def even(cls, parameters: Sequence[Parameter]) -> Cloud:
        """Return an even spread over the intervals."""
        unit = _even_points(_MEMBERS, len(parameters))
        columns = [[p.from_unit(float(x)) for x in unit[:, i]] for i, p in enumerate(parameters)]
        return cls.of(tuple(parameters), np.array(columns).T)

    @property
    def thinned(self) -> Cloud:
        """The same cloud with as many members as slopes by the atlas need."""
        return replace(self, points=self.points[:: max(len(self.points) // _MEMBERS, 1)])

    @cached_property
    def values(self) -> dict[str, Array]:
        """Values of the parameters in SI units, each of shape (n,)."""
        return {p.name: in_si_units(p, self.points[:, i]) for i, p in enumerate(self.parameters)}

    @cached_property
    def middle(self) -> dict[str, float]:
        """The median of every parameter, SI."""
        return {name: float(np.median(values)) for name, values in self.values.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(p.name for p in self.parameters)

    def relative(self, points: Sequence[Mapping[str, float]]) -> Array:
        """Return parameter sets in relative units, shape (m, d)."""
        values = np.array([[point[name] for name in self.names] for point in points])
        return _relative(self.parameters, values)

    @property
    def knowledge(self) -> Knowledge:
        """Covariance of the cloud."""
        return Knowledge(self.names, np.atleast_2d(np.cov(self.points, rowvar=False)))

    @cached_property
    def whitening(self) -> Array:
        """Matrix that turns the cloud into one of unit variances along its directions."""
        values, vectors = np.linalg.eigh(self.knowledge.covariance)
        wide = values > _FLAT * values.max()
        return np.asarray((vectors[:, wide] / np.sqrt(values[wide])).T)

    def spread(self) -> list[int]:
        """Return members in the middle and at both ends of every principal direction.

        Directions are those of the cloud in units of its standard deviations. Of each slice of the
        cloud the member nearest to the medians is taken: it lies within a bent cloud.
        """
        scale = self.points.std(axis=0)
        scaled = (self.points - self.points.mean(axis=0)) / np.where(scale > 0, scale, 1.0)
        _, vectors = np.linalg.eigh(np.atleast_2d(np.cov(scaled, rowvar=False)))
        size = max(int(_END * len(scaled)), 1)
        chosen = [nearest_to_median(scaled, np.arange(len(scaled)))]
        # The widest direction first: it is the most open one.
        for vector in vectors.T[::-1]:
            order = np.argsort(scaled @ vector, kind="stable")
            chosen += [nearest_to_median(scaled, order[:size])]
            chosen += [nearest_to_median(scaled, order[-size:])]
        return list(dict.fromkeys(chosen))


def _even_points(count: int, dimension: int) -> Array:
    """Return points of the unit cube whose coordinates are even and not correlated, with mirrors.

    A Latin hypercube that is ranked again without its correlations (Iman and Conover 1982,
    *Communications in Statistics B* 11, 311-334), and its image at the middle of the cube: what
    bends a response is in no slope then. SciPy's designs take half of the start of a check.
    """
    half = count // 2
    random = np.random.default_rng(1)
    ranks = np.stack([random.permutation(half) for _ in range(dimension)], axis=1)
    for _ in range(_RANKINGS):
        root = np.linalg.cholesky(np.atleast_2d(np.corrcoef(ranks, rowvar=False)))
        ranks = np.linalg.solve(root, ranks.T).T.argsort(axis=0).argsort(axis=0)
    points = (ranks + 0.5) / half
    return np.vstack([points, 1.0 - points])


def corners(dimension: int) -> Array:
    """Return corners of the cube from -1 to 1 at which no two parameters vary together.

    Rows of a Hadamard matrix and their mirror images: each slope comes from all runs, and what two
    parameters do together is in none of them (Box and Wilson 1951, *Journal of the Royal
    Statistical Society B* 13, 1-45).
    """
    size = 2 ** math.ceil(math.log2(dimension))
    half = np.asarray(hadamard(size)[:, :dimension], dtype=float)
    return np.vstack([half, -half])


def _relative(parameters: Sequence[Parameter], values: Array) -> Array:
    columns = [in_relative_units(p, values[:, i]) for i, p in enumerate(parameters)]
    return np.stack(columns, axis=1)


def nearest_to_median(cloud: Array, members: NDArray[np.intp]) -> int:
    """Return the one of some members of a cloud that is nearest to their medians."""
    part = cloud[members]
    return int(members[((part - np.median(part, axis=0)) ** 2).sum(axis=1).argmin()])


def simulated_response(
    name: str,
    accuracy: Accuracy,
    cloud: Cloud,
    points: Array,
    runs: Sequence[Run],
    unit: str = "",
) -> CandidateResponse | None:
    """Fit the dependence of a response on the parameters, by least squares.

    All responses are fitted as logarithms where they are above zero, with a constant for each
    seed: the same seed at all points shares its packing. In units of the cloud's standard
    deviations, a slope of which chance explains a part is shortened by that, and its uncertainty
    counts as an error of the measurement. So noise is not taken for information.

    Parameters
    ----------
    name, accuracy, unit
        As for `CandidateResponse`.
    cloud : Cloud
        Parameter sets among which the measurement is to decide.
    points : ndarray, shape (m, d)
        Simulated parameter sets, in relative units.
    runs : sequence of Run
        Their responses.

    Returns
    -------
    CandidateResponse or None
        None if there are too few runs to know their scatter, or the mean is zero.
    """
    values = np.array([run.value for run in runs], dtype=float)
    mean = float(values.mean()) if len(values) else 0.0
    if not mean:
        return None
    relative = np.log(values) if (values > 0).all() else values / abs(mean)
    fit = _fit(points[[run.point for run in runs]] @ cloud.whitening.T, relative, runs)
    if fit is None:
        return None
    repeated = _scatter(relative, runs)
    scatter = math.sqrt(fit.noise) if repeated is None else repeated
    return fit.response(name, mean, accuracy, cloud, scatter, unit, _BY_CHANCE)


def expected_response(
    name: str, accuracy: Accuracy, cloud: Cloud, expected: ExpectedResponse, unit: str = ""
) -> CandidateResponse:
    """Return a response whose dependence on the parameters the atlas tells.

    Slopes are those of the straight line through the cloud, as of `simulated_response`; what the
    errors of the atlas explain of them is left out.

    Parameters
    ----------
    name, accuracy, cloud, unit
        As of `simulated_response`.
    expected : ExpectedResponse
        At the members of the cloud.
    """
    means = expected.means
    mean = float(means.mean())
    relative = np.log(means) if (means > 0).all() else means / abs(mean)
    where = cloud.points @ cloud.whitening.T
    line = np.linalg.pinv(where - where.mean(axis=0))
    errors = np.diag(line @ expected.covariance @ line.T)
    fit = _Fit(line @ relative, errors, noise=expected.scatter**2)
    scatter = expected.scatter
    return fit.response(name, mean, accuracy, cloud, scatter, unit, _BY_CHANCE_IN_ATLAS)


@dataclass(frozen=True)
class _Fit:
    """Slopes along the directions of a cloud, with their squared standard errors."""

    slopes: Array
    errors: Array
    noise: float

    def response(
        self,
        name: str,
        mean: float,
        accuracy: Accuracy,
        cloud: Cloud,
        scatter: float,
        unit: str,
        by_chance: float,
    ) -> CandidateResponse:
        """Return the response, without slopes of so few standard errors that chance makes them."""
        kept = cloud.whitening.T @ _beyond_chance(self.slopes, self.errors, by_chance)
        slopes = dict(zip(cloud.names, kept.tolist(), strict=True))
        variance = float(self.errors.sum())
        return CandidateResponse(name, mean, accuracy, slopes, scatter, variance, unit)


def _fit(where: Array, values: Array, runs: Sequence[Run]) -> _Fit | None:
    """Fit slopes and a constant for each seed; None if nothing is left to know the noise from."""
    seeds = sorted({run.seed for run in runs})
    blocks = np.array([[run.seed == seed for seed in seeds] for run in runs], dtype=float)
    matrix = np.hstack([blocks, where])
    freedom = len(runs) - matrix.shape[1]
    if freedom < 1 or np.linalg.matrix_rank(matrix) < matrix.shape[1]:
        return None
    fitted, *_ = np.linalg.lstsq(matrix, values, rcond=None)
    residuals = values - matrix @ fitted
    noise = float(residuals @ residuals) / freedom
    errors = noise * np.diag(np.linalg.inv(matrix.T @ matrix))
    return _Fit(fitted[len(seeds) :], errors[len(seeds) :], noise)


def _beyond_chance(slopes: Array, errors: Array, by_chance: float) -> Array:
    """Return slopes with the part left out that chance explains."""
    squares = np.maximum(slopes**2, 1e-300)
    return np.asarray(slopes * np.maximum(1.0 - by_chance**2 * errors / squares, 0.0))


def _scatter(values: Array, runs: Sequence[Run]) -> float | None:
    """Return the standard deviation between seeds of one point; None without repetitions."""
    squares, freedom = 0.0, 0
    for point in {run.point for run in runs}:
        own = values[[run.point == point for run in runs]]
        squares += float(((own - own.mean()) ** 2).sum())
        freedom += len(own) - 1
    return math.sqrt(squares / freedom) if freedom else None
