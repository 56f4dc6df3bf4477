"""Posterior of the hyperparameters of Kriging: correlation ranges and noise"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import linalg
from scipy.linalg import lapack
from scipy.spatial.distance import cdist, squareform

from grainfit.arrays import Array
from grainfit.metamodels.predictor import Contrasts, Hyperparameters, matern_and_slope

# Weak priors: a response changes smoothly over the unit cube, and its residuals from the trend may
# be all noise or hardly any. Ranges grow with the square root of the dimension, as distances do.
RANGE_MEDIAN = 3.0
_RANGE_SPREAD = 1.0
_NOISE_LOGIT_MEAN = 1.0
_NOISE_LOGIT_SPREAD = 2.0
_LOG_RANGE_LIMITS = (math.log(0.02), math.log(100.0))
_NOISE_LOGIT_LIMITS = (-20.0, 8.0)
# The share of known noise in the residuals is kept below one, so that some variance remains.
_LARGEST_KNOWN_SHARE = 0.98
# With more hyperparameters, one coarser search and half as many points about its end have to do.
_THOROUGH_UP_TO = 8
# Relative change of the negative log density at which that search ends: less than 0.001 in all.
_COARSE = 1e-6
# Share of the largest weight that a set of hyperparameters needs to count: with few of them, and
# with many.
_SMALLEST_WEIGHTS = (1e-4, 1e-2)
# Negative log density where rounding makes the covariance indefinite.
_INDEFINITE = 1e25
#: Runs that a scatter that is known before the runs counts as. Recorded scatters and those of other
#: runs differ by a factor of 1.4 (standard deviation of 22 responses), as estimates of 5 runs do.
RUNS_OF_KNOWN_SCATTER = 5
#: Standard errors beyond which runs contradict a known scatter.
_CONTRADICTION = 1.0


def _weighted_squares(weights: Array, points: Array, ranges: Array) -> Array:
    """Sum over all pairs of points of weight times squared difference over range, per column."""
    squares = 2.0 * (weights.sum(axis=1) @ points**2)
    cross = 2.0 * np.einsum("ij,ij->j", points, weights @ points)
    return np.asarray((squares - cross) / ranges**2)


def _inverse(factor: Array) -> Array:
    """Inverse of a symmetric matrix from its lower Cholesky factor, which is zero elsewhere."""
    lower, _ = lapack.dpotri(factor, lower=1)
    inverse = lower + lower.T
    inverse[np.diag_indices(len(inverse))] /= 2.0
    return np.asarray(inverse)


class _Covariance(NamedTuple):
    """Covariance of the contrasts, up to the common variance, and its parts.

    The correlation of the contrasts; the slope of that of each pair of runs over their distance.
    """

    matrix: Array
    correlation: Array
    slope: Array
    ranges: Array
    noise_share: float
    mean_correlation: float


class _Factorised(NamedTuple):
    """Lower Cholesky factor of a covariance, and the values divided by that covariance."""

    factor: Array
    coefficients: Array
    sum_of_squares: float
    #: Part of the sum that a known scatter adds.
    of_known: float


class HyperparameterPosterior:
    """Posterior density: restricted likelihood, with the variance integrated out, times priors.

    The covariance of the runs is a common variance times
    ``(1 - u) ((1 - p) R / r + p W) + u N``: R the correlation, r its mean in the contrasts, so
    that p is the share of noise in the residuals from the trend; W the ratios of the runs' noise
    variances to their mean, on the diagonal; N the known noise, or a known covariance, and u its
    share.

    A scatter that is known before the runs makes the prior of the noise's variance scaled inverse
    chi-squared, with the degrees of freedom `RUNS_OF_KNOWN_SCATTER`. Given the other
    hyperparameters, the common variance stays so, with the degrees of freedom of both.

    References
    ----------
    Gelman et al. (2013), *Bayesian Data Analysis*, section 2.6: scaled inverse chi-squared prior.
    """

    def __init__(
        self,
        points: Array,
        values: Array,
        contrasts: Contrasts,
        known_noise: Array,
        noise_ratios: Array | None = None,
        known_variance: float = 0.0,
    ) -> None:
        self.points = points
        #: Places of the pairs of runs in the flat matrix of all distances.
        self._pairs = np.flatnonzero(np.triu(np.ones((len(points),) * 2), 1))
        self._known_runs = RUNS_OF_KNOWN_SCATTER if known_variance > 0 else 0
        self._known_squares = self._known_runs * known_variance
        self.contrasts = contrasts
        self.values = contrasts.complement.T @ values
        self.degrees_of_freedom = len(self.values) + self._known_runs
        #: Of the noise that is estimated, in the contrasts.
        self.noise = np.eye(len(self.values))
        if noise_ratios is not None:
            self.noise = contrasts.covariance(np.diag(noise_ratios))
        residual_variance = float(self.values @ self.values) / len(self.values)
        matrix = known_noise if known_noise.ndim == 2 else np.diag(known_noise)
        known = contrasts.covariance(matrix)
        size = float(np.trace(known)) / len(self.values)
        self.known_share = min(size / residual_variance, _LARGEST_KNOWN_SHARE)
        self.known = self.known_share / size * known if size > 0 else known
        d = points.shape[1]
        median = RANGE_MEDIAN * math.sqrt(d)
        self.centre = np.append(np.full(d, math.log(median)), _NOISE_LOGIT_MEAN)
        self.spread = np.append(np.full(d, _RANGE_SPREAD), _NOISE_LOGIT_SPREAD)
        self.bounds = [_LOG_RANGE_LIMITS] * d + [_NOISE_LOGIT_LIMITS]

    def _covariance(self, theta: Array) -> _Covariance:
        ranges = np.exp(theta[:-1])
        noise_share = 1.0 / (1.0 + math.exp(-theta[-1]))
        scaled = self.points / ranges
        # `pdist` would look up the library of its arrays at each call, which takes longer.
        of_pairs, slope = matern_and_slope(cdist(scaled, scaled).take(self._pairs))
        of_runs = squareform(of_pairs)
        np.fill_diagonal(of_runs, 1.0)
        correlation = self.contrasts.covariance(of_runs)
        mean_correlation = float(np.trace(correlation)) / len(self.values)
        covariance = (1.0 - noise_share) / mean_correlation * correlation
        covariance += noise_share * self.noise
        covariance = (1.0 - self.known_share) * covariance + self.known
        return _Covariance(covariance, correlation, slope, ranges, noise_share, mean_correlation)

    def value(self, theta: Array) -> float:
        """Negative logarithm of the posterior density, up to a constant of the runs."""
        parts = self._covariance(theta)
        return self._value(theta, parts, self._factorised(parts))

    def __call__(self, theta: Array) -> tuple[float, Array]:
        """Return `value` and its gradient."""
        parts = self._covariance(theta)
        solved = self._factorised(parts)
        if solved is None:
            return _INDEFINITE, np.zeros_like(theta)
        contrasts, mean = len(self.values), parts.mean_correlation
        sensitivity = _inverse(solved.factor)
        outer = np.outer(solved.coefficients, solved.coefficients)
        sensitivity -= self.degrees_of_freedom / solved.sum_of_squares * outer
        signal = (1.0 - self.known_share) * (1.0 - parts.noise_share)
        on_signal = float(np.vdot(sensitivity, parts.correlation)) / mean
        on_noise = float(np.vdot(sensitivity, self.noise))
        sensitivity[np.diag_indices(contrasts)] -= on_signal / contrasts
        weights = self.contrasts.spread(sensitivity) * squareform(parts.slope)
        of_ranges = 0.5 * signal / mean * _weighted_squares(weights, self.points, parts.ranges)
        of_noise = 0.5 * signal * parts.noise_share * (on_noise - on_signal)
        pull = self.degrees_of_freedom * solved.of_known / solved.sum_of_squares
        of_noise += 0.5 * (1.0 - parts.noise_share) * (self._known_runs - pull)
        of_prior = (theta - self.centre) / self.spread**2
        return self._value(theta, parts, solved), np.append(of_ranges, of_noise) + of_prior

    def _factorised(self, parts: _Covariance) -> _Factorised | None:
        factor, info = lapack.dpotrf(parts.matrix, lower=1)
        if info:
            return None
        coefficients, _ = lapack.dpotrs(factor, self.values, lower=1)
        of_known = self._known_squares / self._noise(parts)
        squares = float(self.values @ coefficients) + of_known
        return _Factorised(factor, coefficients, squares, of_known)

    def _noise(self, parts: _Covariance) -> float:
        """Variance of the estimated noise over the common variance."""
        return (1.0 - self.known_share) * parts.noise_share

    def _value(self, theta: Array, parts: _Covariance, solved: _Factorised | None) -> float:
        if solved is None:
            return _INDEFINITE
        offset = (theta - self.centre) / self.spread
        return (
            float(np.log(np.diag(solved.factor)).sum())
            + 0.5 * self.degrees_of_freedom * math.log(solved.sum_of_squares)
            + 0.5 * self._known_runs * math.log(self._noise(parts))
            + 0.5 * float(offset @ offset)
        )

    @cached_property
    def _is_large(self) -> bool:
        """Whether there are so many hyperparameters that a thorough search takes too long."""
        return len(self.centre) > _THOROUGH_UP_TO

    @cached_property
    def _best(self) -> tuple[float, Array]:
        """Lowest value and its place: of three searches, from long, medium and short ranges."""
        starts = [self._start(shift) for shift in (0.0, -1.5, -3.0)]
        if self._is_large:
            starts = [min(starts, key=self.value)]
        return min((self._search(start) for start in starts), key=lambda found: found[0])

    def maximum(self) -> Array:
        """Most probable hyperparameters."""
        return self._best[1]

    @property
    def most_probable(self) -> Hyperparameters:
        """The set at the maximum."""
        parts = self._covariance(self.maximum())
        solved = self._factorised(parts)
        if solved is None:
            raise linalg.LinAlgError("the covariance of the contrasts has no Cholesky factor")
        return self._estimated(parts, solved, 1.0)

    @property
    def log_density(self) -> float:
        """Logarithm of the posterior density at its maximum, up to a constant of the runs."""
        return -self._best[0]

    def _start(self, shift: float) -> Array:
        """Return the best of some shares of noise."""
        ranges = self.centre[:-1] + shift
        return min((np.append(ranges, logit) for logit in (-6.0, -3.0, 0.0)), key=self.value)

    def _search(self, start: Array) -> tuple[float, Array]:
        """Lowest value and its place."""
        # Loaded late: metamodels of the atlas are fitted already.
        from scipy.optimize import minimize

        options = {"ftol": _COARSE} if self._is_large else {}
        found = minimize(
            self, start, jac=True, method="L-BFGS-B", bounds=self.bounds, options=options
        )
        # Rounded, so that rounding errors do not decide between searches that ended at one place.
        return round(float(found.fun), 6), np.asarray(found.x, dtype=float)

    def _curvature(self, theta: Array) -> Array:
        shifts = 1e-3 * np.eye(len(theta))
        after = np.array([self(theta + shift)[1] for shift in shifts])
        before = [self(theta - shift)[1] for shift in shifts if not self._is_large]
        # One-sided differences take half as many factorisations.
        rows = (after - before) / 2e-3 if before else (after - self(theta)[1]) / 1e-3
        return np.asarray((rows + rows.T) / 2)

    def _around(self, mode: Array) -> list[Array]:
        """Return points that represent the posterior distribution about its maximum.

        The rows of a Hadamard matrix, stretched by the curvature at the maximum, have the mean
        and the covariance of the normal approximation; with their mirror images they also have its
        third moments.
        """
        eigenvalues, vectors = np.linalg.eigh(self._curvature(mode))
        # Except for rounding, the posterior is nowhere much flatter than the prior.
        floor = 0.5 / self.spread.max() ** 2
        stretch = vectors / np.sqrt(np.maximum(eigenvalues, floor))
        p = len(mode)
        directions = linalg.hadamard(2 ** math.ceil(math.log2(p)))[:, :p].astype(float)
        if not self._is_large:
            directions = np.vstack([directions, -directions])
        low, high = np.array(self.bounds).T
        return [np.clip(mode + stretch @ direction, low, high) for direction in directions]

    def hyperparameters(self) -> list[Hyperparameters]:
        """Weighted sets of hyperparameters to predict with, with their estimated variances.

        The weights correct for a posterior that is not normal.
        """
        mode = self.maximum()
        around = self._around(mode)
        parts = [self._covariance(theta) for theta in around]
        solved = [self._factorised(one) for one in parts]
        values = np.array([self._value(*each) for each in zip(around, parts, solved, strict=True)])
        depth = values - self.value(mode) - 0.5 * len(mode)
        # Limited, so that one point above the local maximum does not get all the weight.
        weights = np.exp(-np.clip(depth, -3.0, None))
        kept = weights > _SMALLEST_WEIGHTS[self._is_large] * weights.max()
        weights /= weights[kept].sum()
        return [
            self._estimated(one, factorised, float(weight))
            for one, factorised, weight, is_kept in zip(parts, solved, weights, kept, strict=True)
            if is_kept and factorised is not None
        ]

    def supports(self, variance: float) -> bool:
        """Whether the noise that the runs show is that of a scatter that is known before them."""
        sets = self.hyperparameters()
        weights = np.array([one.weight for one in sets])
        logarithms = np.log([one.noise_variance for one in sets])
        mean = float(weights @ logarithms)
        spread = float(weights @ (logarithms - mean) ** 2)
        spread += 2.0 / self.degrees_of_freedom + 2.0 / RUNS_OF_KNOWN_SCATTER
        return abs(mean - math.log(variance)) < _CONTRADICTION * math.sqrt(spread)

    def _estimated(self, parts: _Covariance, solved: _Factorised, weight: float) -> Hyperparameters:
        variance = solved.sum_of_squares / self.degrees_of_freedom * (1.0 - self.known_share)
        noise = variance * parts.noise_share
        signal = (variance - noise) / parts.mean_correlation
        return Hyperparameters(parts.ranges, signal, noise, weight)
