"""Kriging predictor at given hyperparameters: trend, correlation, posterior of the coefficients."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy import linalg
from scipy.spatial.distance import cdist

from grainfit.arrays import Array
from grainfit.metamodels.relative_prior import RelativePrior

#: Scale of the distance in the Matérn 5/2 correlation, 2 sqrt(5/2).
_MATERN_SCALE = math.sqrt(10.0)
#: Range of a parameter that a response does not depend on, in intervals.
_NO_EFFECT = 1e9
#: Fewest runs per coefficient of a linear trend: it must leave as many degrees of freedom as it
#: uses, and at least those below. Otherwise the trend is constant: with fewer runs, least-squares
#: slopes predict worse than none.
RUNS_PER_COEFFICIENT = 2
_FREE_CONTRASTS = 3
#: Variances, over the largest, that are added one after the other until a covariance that rounding
#: makes indefinite has a Cholesky factor.
_JITTERS = (1e-9, 1e-8, 1e-7, 1e-6)


def runs_for_trend(dimension: int) -> int:
    """Return the fewest runs that determine a linear trend, and so tell it from scatter."""
    coefficients = dimension + 1
    return max(RUNS_PER_COEFFICIENT * coefficients, coefficients + _FREE_CONTRASTS)


def matern(distance: Array) -> Array:
    """Matérn 5/2 correlation of a scaled distance h: (1 + t + t²/3) exp(-t), t = sqrt(10) h.

    References
    ----------
    Stein, Interpolation of Spatial Data (1999), equation 2.7.14 for a smoothness of 5/2.
    """
    scaled = _MATERN_SCALE * distance
    # In place: with hundreds of runs, new arrays take longer than the arithmetic.
    correlation = scaled / 3.0
    correlation += 1.0
    correlation *= scaled
    correlation += 1.0
    correlation *= np.exp(-scaled)
    return np.asarray(correlation)


def matern_slope(distance: Array) -> Array:
    """Negative derivative of the correlation, divided by the distance (finite at zero)."""
    return matern_and_slope(distance)[1]


def matern_and_slope(distance: Array) -> tuple[Array, Array]:
    """Return `matern` and `matern_slope`, which share the exponential."""
    scaled = _MATERN_SCALE * distance
    decay = np.exp(-scaled)
    slope = scaled + 1.0
    slope *= decay
    decay *= scaled
    decay *= scaled
    decay /= 3.0
    decay += slope
    slope *= 10.0 / 3.0
    return decay, slope


@dataclass(frozen=True)
class Trend:
    """Trend: a constant, or a constant and the linearly independent columns of the points."""

    columns: tuple[int, ...]

    @classmethod
    def choose(cls, points: Array, linear: bool) -> Trend:
        """Choose a linear trend if the runs determine its slopes, else a constant."""
        n, d = points.shape
        if not linear or n < runs_for_trend(d):
            return cls(())
        centred = points - points.mean(axis=0)
        _, triangle, order = linalg.qr(centred, mode="economic", pivoting=True)
        size = np.abs(np.diag(triangle))
        columns = tuple(sorted(int(j) for j in order[size > 1e-6 * math.sqrt(n)]))
        trend = cls(columns)
        # A trend that depends on a single run could not be judged by leaving that run out.
        basis, _ = np.linalg.qr(trend.matrix(points))
        return trend if float((basis**2).sum(axis=1).max()) < 1 - 1e-6 else cls(())

    def matrix(self, points: Array) -> Array:
        """Values of the trend functions at points, shape (points, functions)."""
        values = np.ones((len(points), 1 + len(self.columns)), order="F")
        values[:, 1:] = points[:, list(self.columns)]
        values[:, 1:] -= 0.5
        return values

    def slopes(self, coefficients: Array, d: int) -> Array:
        """Slopes of the trend along all d axes."""
        slopes = np.zeros(d)
        slopes[list(self.columns)] = coefficients[1:]
        return slopes


@dataclass(frozen=True)
class Contrasts:
    """Contrasts of the runs, which do not depend on the trend, and the least-squares trend.

    The contrasts are the last columns of an orthogonal matrix ``Q = I - V T V'``. Its few
    reflections V turn a covariance of the runs into one of the contrasts, and back, with far fewer
    operations than the matrix itself.

    References
    ----------
    Schreiber & Van Loan (1989), SIAM J. Sci. Stat. Comput. 10, 53-57: compact WY form of Q.
    """

    complement: Array
    least_squares: Array
    _reflections: Array
    _mixing: Array

    @classmethod
    def of(cls, trend_matrix: Array) -> Contrasts:
        """Split the space of the runs into that of the trend and its complement (by QR)."""
        n, rank = trend_matrix.shape
        (packed, factors), triangle = linalg.qr(trend_matrix, mode="raw")
        reflections = np.tril(packed, -1) + np.eye(n, rank)
        mixing = np.diag(factors)
        for j in range(1, rank):
            overlap = reflections[:, :j].T @ reflections[:, j]
            mixing[:j, j] = -factors[j] * (mixing[:j, :j] @ overlap)
        basis = np.eye(n) - reflections @ mixing @ reflections.T
        least_squares = linalg.solve_triangular(triangle[:rank], basis[:, :rank].T)
        return cls(basis[:, rank:], least_squares, reflections, mixing)

    @property
    def degrees_of_freedom(self) -> int:
        """Number of contrasts."""
        return int(self.complement.shape[1])

    def covariance(self, of_runs: Array) -> Array:
        """Turn a symmetric matrix of the runs into that of the contrasts: C' M C."""
        rank = len(self._mixing)
        return self._turned(of_runs, self._mixing)[rank:, rank:]

    def spread(self, of_contrasts: Array) -> Array:
        """Turn a symmetric matrix of the contrasts into that of the runs: C M C'."""
        rank, n = len(self._mixing), len(self._reflections)
        padded = np.zeros((n, n))
        padded[rank:, rank:] = of_contrasts
        return self._turned(padded, self._mixing.T)

    def _turned(self, matrix: Array, mixing: Array) -> Array:
        turned = self._reflections @ mixing
        across = matrix @ turned
        half = self._reflections @ (0.5 * (turned.T @ across)) - across
        left = np.concatenate([half, self._reflections], axis=1)
        right = np.concatenate([self._reflections, half], axis=1)
        return np.asarray(matrix + left @ right.T)


@dataclass(frozen=True)
class Hyperparameters:
    """One set of hyperparameters, in units of the standardised response."""

    ranges: Array
    signal_variance: float
    noise_variance: float
    weight: float
    #: Ratio of the response to that of its relative.
    ratio: float = 0.0


def _cholesky(covariance: Array) -> Array:
    """Lower Cholesky factor, also of runs without scatter so close that rounding hides them."""
    largest = float(np.diagonal(covariance).max())
    # By how much rounding hides a run depends on the linear algebra of the processor.
    for jitter in (0.0, *_JITTERS):
        raised = covariance + jitter * largest * np.eye(len(covariance)) if jitter else covariance
        with suppress(linalg.LinAlgError):
            return np.asarray(linalg.cholesky(raised, lower=True))
    raise linalg.LinAlgError("the covariance of the runs has no Cholesky factor")


class LeavingOut:
    """Runs left out one by one, at hyperparameters that stay the same.

    The common variance is estimated from the runs that are kept.

    Parameters
    ----------
    precision : ndarray, shape (n, n)
        Inverse covariance of the runs in the space of the contrasts.
    values : ndarray, shape (n,)
        Responses of the runs.
    trend : int
        Number of coefficients of the trend.

    References
    ----------
    Dubrule (1983), Math. Geol. 15, 687-699, with several runs left out at once.
    """

    def __init__(self, precision: Array, values: Array, trend: int) -> None:
        self._of_all = precision
        self._pull_of_all = precision @ values
        self._precision = precision.copy()
        self._pull = self._pull_of_all.copy()
        self._squares = float(values @ self._pull)
        self._freedom = len(values) - trend
        self._left_out: list[int] = []

    def leave_out_worst(self) -> None:
        """Leave out the run that the others predict worst."""
        own = np.diag(self._precision).copy()
        own[self._left_out] = np.inf
        worst = int(np.argmax(self._pull**2 / own))
        across = self._precision[worst] / own[worst]
        self._squares -= float(self._pull[worst] ** 2 / own[worst])
        self._pull -= across * self._pull[worst]
        self._precision -= np.outer(across, self._precision[worst])
        self._left_out.append(worst)

    def deviations_of_left_out(self) -> Array:
        """Deviations of the runs left out from what the others predict, in standard deviations."""
        out = self._left_out
        covariance = np.linalg.inv(self._of_all[np.ix_(out, out)])
        variance = max(self._squares, 0.0) / (self._freedom - len(out))
        scatter = np.sqrt(np.maximum(np.diag(covariance) * variance, np.finfo(float).tiny))
        return np.asarray(np.abs(covariance @ self._pull_of_all[out]) / scatter)


class _Projection(NamedTuple):
    """Points prepared for one predictor, one column per point.

    The points over the ranges; their prior mean and variance; their trend; their covariance with
    the runs; its least-squares trend; and the part of it that the contrasts explain.
    """

    scaled: Array
    prior_mean: Array | float
    prior_variance: Array | float
    trend: Array
    covariance: Array
    on_trend: Array
    explained: Array


class Parts(NamedTuple):
    """Arrays of a component that its predictions are computed from."""

    coefficients: Array
    trend_coefficients: Array
    trend_covariance: Array
    least_squares: Array
    root: Array
    root_of_trend: Array


class Component:
    """Kriging predictor of one set of hyperparameters, factorised once."""

    def __init__(
        self,
        hyperparameters: Hyperparameters,
        trend: Trend,
        points: Array,
        values: Array,
        known_noise: Array,
        contrasts: Contrasts | None = None,
        noise_ratios: Array | None = None,
        relative: RelativePrior | None = None,
    ) -> None:
        self.hyperparameters = hyperparameters
        self.trend = trend
        self.points = points
        self.values = values
        self.known_noise = known_noise
        self.noise_ratios = noise_ratios
        self._relative = relative
        self._ratio = 0.0 if relative is None else hyperparameters.ratio
        self._scaled = points / hyperparameters.ranges
        contrasts = contrasts or Contrasts.of(trend.matrix(points))
        covariance = self._covariance(points)
        covariance[np.diag_indices_from(covariance)] += self._noise() + known_noise
        complement, least_squares = contrasts.complement, contrasts.least_squares
        factor = _cholesky(contrasts.covariance(covariance))
        self._root = linalg.solve_triangular(factor, complement.T, lower=True)
        self._residuals = values - self._prior(points)[0]
        self._coefficients = self._root.T @ (self._root @ self._residuals)
        self._least_squares = least_squares
        across = covariance @ least_squares.T
        self._trend_coefficients = least_squares @ (
            self._residuals - covariance @ self._coefficients
        )
        self._trend_covariance = least_squares @ across
        self._root_of_trend = self._root @ across

    @property
    def parts(self) -> Parts:
        """Arrays that its predictions are computed from, where it has no relative."""
        return Parts(
            self._coefficients,
            self._trend_coefficients,
            self._trend_covariance,
            self._least_squares,
            self._root,
            self._root_of_trend,
        )

    def _noise(self) -> Array | float:
        """Estimated variance of the noise of each run."""
        variance = self.hyperparameters.noise_variance
        return variance if self.noise_ratios is None else variance * self.noise_ratios

    def _covariance(self, points: Array) -> Array:
        correlation = matern(cdist(self._scaled, points / self.hyperparameters.ranges))
        correlation *= self.hyperparameters.signal_variance
        if self._relative is not None and self._ratio:
            correlation += self._ratio**2 * self._relative.at(points).covariance
        return correlation

    def _prior(self, points: Array) -> tuple[Array | float, Array | float]:
        """Mean and variance at points before the runs, but for the trend."""
        signal = self.hyperparameters.signal_variance
        if self._relative is None or not self._ratio:
            return 0.0, signal
        there = self._relative.at(points)
        return self._ratio * there.mean, signal + self._ratio**2 * there.variance

    def project(self, points: Array) -> _Projection:
        """Compute the parts of predictions at points and of their covariances."""
        trend = self.trend.matrix(points).T
        covariance = self._covariance(points)
        return _Projection(
            points / self.hyperparameters.ranges,
            *self._prior(points),
            trend,
            covariance,
            self._least_squares @ covariance,
            self._root @ covariance - self._root_of_trend @ trend,
        )

    def predict(self, points: Array) -> tuple[Array, Array]:
        """Mean and variance of the mean."""
        return self.predict_at(self.project(points))

    def mean(self, points: Array) -> Array:
        """Mean alone, which takes far fewer operations."""
        trend = self.trend.matrix(points) @ self._trend_coefficients
        expected = trend + self._coefficients @ self._covariance(points)
        return np.asarray(expected + self._prior(points)[0])

    def predict_at(self, at: _Projection) -> tuple[Array, Array]:
        """Mean and variance of the mean at projected points."""
        mean = self._trend_coefficients @ at.trend + self._coefficients @ at.covariance
        mean += at.prior_mean
        variance = (
            at.prior_variance
            - 2.0 * np.einsum("ij,ij->j", at.trend, at.on_trend)
            + np.einsum("ij,ij->j", at.trend, self._trend_covariance @ at.trend)
            - np.einsum("ij,ij->j", at.explained, at.explained)
        )
        return mean, np.maximum(variance, 0.0)

    def joint(self, first: _Projection, second: _Projection) -> Array:
        """Covariances of the mean between two sets of points, shape (first, second).

        Without the ratio squared times those of the relative, see `relative_factor`.
        """
        correlation = matern(cdist(first.scaled, second.scaled))
        joint = self.hyperparameters.signal_variance * correlation
        joint -= first.explained.T @ second.explained
        joint += first.trend.T @ (self._trend_covariance @ second.trend - second.on_trend)
        joint -= first.on_trend.T @ second.trend
        return np.asarray(joint)

    def gradients(self, points: Array) -> Array:
        """Slopes of the mean, shape (m, d)."""
        ranges, runs = self.hyperparameters.ranges, self._scaled
        scaled = points / ranges
        slope = matern_slope(cdist(scaled, runs))
        pull = self.hyperparameters.signal_variance * slope * self._coefficients
        away = scaled * pull.sum(axis=1)[:, None] - pull @ runs
        slopes = self.trend.slopes(self._trend_coefficients, points.shape[1])
        if self._relative is not None and self._ratio:
            pull_of_relative = self._ratio**2 * self._coefficients
            slopes = slopes + self._relative.pull_slopes(points, self._ratio, pull_of_relative)
        return np.asarray(slopes - away / ranges)

    @property
    def ratio(self) -> float:
        """Ratio of the response to that of its relative; 0 without one."""
        return self._ratio

    def covariance_of_relative(
        self, here: _Projection, covariance: Array, relative: Array
    ) -> tuple[Array, Array]:
        """Covariances of the mean at points with the relative's, given all runs.

        Parameters
        ----------
        here : _Projection
            Projected points, m of them.
        covariance : ndarray, shape (m, k)
            Covariances of the relative between these and other points, given its own runs.
        relative : ndarray, shape (n, k)
            The same between the runs of the response and the other points.

        Returns
        -------
        ndarray, shape (m, k)
            The covariances.
        ndarray, shape (k,)
            Reduction of the relative's variances at the other points by the runs of the response.
        """
        with_runs = self._ratio * relative
        explained = self._root @ with_runs
        joint = self._ratio * covariance - here.explained.T @ explained
        joint -= here.trend.T @ (self._least_squares @ with_runs)
        return np.asarray(joint), np.einsum("ij,ij->j", explained, explained)

    def leave_one_out(self) -> tuple[Array, Array]:
        """Mean and variance of each run left out, by the formulas of Dubrule (1983)."""
        precision = (self._root**2).sum(axis=0)
        return self.values - self._coefficients / precision, 1.0 / precision

    def leaving_out(self) -> LeavingOut:
        """Start to leave runs out one by one."""
        return LeavingOut(self._root.T @ self._root, self._residuals, len(self._trend_coefficients))

    def condition(
        self,
        points: Array,
        values: Array,
        known_noise: Array,
        added_ratios: Array,
        relative: RelativePrior | None = None,
    ) -> Component:
        """Add runs; the ratios of their noise only count where those of the others are known.

        ``relative`` is that of all runs.
        """
        ratios = self.noise_ratios
        return Component(
            self.hyperparameters,
            self.trend,
            np.vstack([self.points, points]),
            np.append(self.values, values),
            np.append(self.known_noise, known_noise),
            noise_ratios=None if ratios is None else np.append(ratios, added_ratios),
            relative=relative,
        )

    def condition_on_pending(
        self,
        points: Array,
        known_noise: Array,
        added_ratios: Array,
        relative: RelativePrior | None = None,
    ) -> Component:
        """Add pending runs, which get the predicted mean."""
        expected = self.predict(points)[0]
        return self.condition(points, expected, known_noise, added_ratios, relative)

    def related_to(self, relative: RelativePrior) -> Component:
        """Return the component with another state of its relative."""
        return Component(
            self.hyperparameters,
            self.trend,
            self.points,
            self.values,
            self.known_noise,
            noise_ratios=self.noise_ratios,
            relative=relative,
        )

    def weighing(self, weight: float) -> Component:
        """Return the component with another weight in the mixture."""
        other = copy(self)
        other.hyperparameters = replace(self.hyperparameters, weight=weight)
        return other

    def embedded(
        self, axes: Sequence[int], points: Array, relative: RelativePrior | None = None
    ) -> Component:
        """Return the same over a larger unit cube, see `Kriging.embedded`."""
        other = copy(self)
        other._relative = relative
        other.points = points
        ranges = np.full(points.shape[1], _NO_EFFECT)
        ranges[list(axes)] = self.hyperparameters.ranges
        other.hyperparameters = replace(self.hyperparameters, ranges=ranges)
        other._scaled = points / ranges
        other.trend = Trend(tuple(axes[column] for column in self.trend.columns))
        return other

    @property
    def effective_dimension(self) -> int:
        """Number of parameters that the response can depend on."""
        return int((self.hyperparameters.ranges < _NO_EFFECT).sum())

    def to_plain(self, factors: bool) -> dict[str, Any]:
        """Return the component's part of `Kriging.to_plain`."""
        known = {
            "weight": float(self.hyperparameters.weight),
            "ranges": self.hyperparameters.ranges.tolist(),
            "signal_variance": float(self.hyperparameters.signal_variance),
            "noise_variance": float(self.hyperparameters.noise_variance),
            "trend_columns": list(self.trend.columns),
        }
        return known | self._plain_factors() if factors else known

    def _plain_factors(self) -> dict[str, Any]:
        # A rotation from the left changes no length and makes half of the numbers zero.
        both = np.hstack([self._root, -self._root_of_trend])
        triangle: Array = linalg.qr(both, mode="r", check_finite=False)[0][: len(both)]
        return {
            "coefficients": self._coefficients.tolist(),
            "trend_coefficients": self._trend_coefficients.tolist(),
            "least_squares": self._least_squares.tolist(),
            "trend_covariance": self._trend_covariance.tolist(),
            "triangle": triangle[np.triu_indices(len(triangle), m=triangle.shape[1])].tolist(),
        }
