"""Posterior of the hyperparameters of Kriging: correlation ranges and noise"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import linalg, optimize
from scipy.spatial.distance import cdist

from grainfit.metamodels.predictor import (
    Contrasts,
    FloatArray,
    Hyperparameters,
    matern,
    matern_slope,
)

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
# With more hyperparameters the mirror images are not worth their computing time.
_MIRRORED_UP_TO = 8


def _weighted_squares(weights: FloatArray, points: FloatArray, ranges: FloatArray) -> FloatArray:
    """Sum over all pairs of points of weight times squared difference over range, per column."""
    squares = 2.0 * (weights.sum(axis=1) @ points**2)
    cross = 2.0 * np.einsum("ij,ij->j", points, weights @ points)
    return np.asarray((squares - cross) / ranges**2)


class _Covariance(NamedTuple):
    """Covariance of the contrasts, up to the common variance, and its parts."""

    matrix: FloatArray
    correlation: FloatArray
    distance: FloatArray
    ranges: FloatArray
    noise_share: float
    mean_correlation: float


class HyperparameterPosterior:
    """Posterior density: restricted likelihood, with the variance integrated out, times priors.

    The covariance of the runs is a common variance times
    ``(1 - u) ((1 - p) R / r + p W) + u N``: R the correlation, r its mean in the contrasts, so
    that p is the share of noise in the residuals from the trend; W the ratios of the runs' noise
    variances to their mean, on the diagonal; N the known noise and u its share.
    """

    def __init__(
        self,
        points: FloatArray,
        values: FloatArray,
        contrasts: Contrasts,
        known_noise: FloatArray,
        noise_ratios: FloatArray | None = None,
    ) -> None:
        self.points = points
        self.contrasts = contrasts
        self.values = contrasts.complement.T @ values
        complement = contrasts.complement
        self.projector = complement @ complement.T
        self.noise: FloatArray | None = None
        self.noise_of_runs = self.projector
        if noise_ratios is not None:
            self.noise = (complement.T * noise_ratios) @ complement
            self.noise_of_runs = complement @ self.noise @ complement.T
        residual_variance = float(self.values @ self.values) / len(self.values)
        self.known_share = min(float(known_noise.mean()) / residual_variance, _LARGEST_KNOWN_SHARE)
        relative = known_noise / known_noise.mean() if self.known_share > 0 else known_noise
        self.known = self.known_share * (complement.T * relative) @ complement
        d = points.shape[1]
        median = RANGE_MEDIAN * math.sqrt(d)
        self.centre = np.append(np.full(d, math.log(median)), _NOISE_LOGIT_MEAN)
        self.spread = np.append(np.full(d, _RANGE_SPREAD), _NOISE_LOGIT_SPREAD)
        self.bounds = [_LOG_RANGE_LIMITS] * d + [_NOISE_LOGIT_LIMITS]

    def _covariance(self, theta: FloatArray) -> _Covariance:
        ranges = np.exp(theta[:-1])
        noise_share = 1.0 / (1.0 + math.exp(-theta[-1]))
        scaled = self.points / ranges
        distance = cdist(scaled, scaled)
        correlation = matern(distance)
        mean_correlation = float((self.projector * correlation).sum()) / len(self.values)
        complement = self.contrasts.complement
        signal = (1.0 - noise_share) / mean_correlation
        covariance = complement.T @ correlation @ complement * signal
        if self.noise is None:
            covariance[np.diag_indices_from(covariance)] += noise_share
        else:
            covariance += noise_share * self.noise
        covariance = (1.0 - self.known_share) * covariance + self.known
        return _Covariance(covariance, correlation, distance, ranges, noise_share, mean_correlation)

    def __call__(self, theta: FloatArray) -> tuple[float, FloatArray]:
        """Negative logarithm of the posterior density and its gradient."""
        covariance, correlation, distance, ranges, noise_share, mean = self._covariance(theta)
        try:
            factor = linalg.cholesky(covariance, lower=True, check_finite=False)
        except linalg.LinAlgError:
            return 1e25, np.zeros_like(theta)
        root = linalg.solve_triangular(
            factor, self.contrasts.complement.T, lower=True, check_finite=False
        )
        whitened = linalg.solve_triangular(factor, self.values, lower=True, check_finite=False)
        freedom = len(self.values)
        sum_of_squares = float(whitened @ whitened)
        coefficients = root.T @ whitened
        sensitivity = root.T @ root - freedom / sum_of_squares * np.outer(
            coefficients, coefficients
        )
        own = 1.0 - self.known_share
        on_signal = float((sensitivity * correlation).sum()) / mean
        weights = (sensitivity - on_signal / freedom * self.projector) * matern_slope(distance)
        of_ranges = (0.5 * own * (1.0 - noise_share) / mean) * _weighted_squares(
            weights, self.points, ranges
        )
        of_noise = (
            0.5
            * own
            * noise_share
            * (1.0 - noise_share)
            * (float(np.sum(sensitivity * self.noise_of_runs)) - on_signal)
        )
        offset = (theta - self.centre) / self.spread
        value = (
            float(np.log(np.diag(factor)).sum())
            + 0.5 * freedom * math.log(sum_of_squares)
            + 0.5 * float(offset @ offset)
        )
        return value, np.append(of_ranges, of_noise) + offset / self.spread

    @cached_property
    def _best(self) -> tuple[float, FloatArray]:
        """Lowest value and its place: of three searches, from long, medium and short ranges."""
        return min((self._search(shift) for shift in (0.0, -1.5, -3.0)), key=lambda found: found[0])

    def maximum(self) -> FloatArray:
        """Most probable hyperparameters."""
        return self._best[1]

    @property
    def log_density(self) -> float:
        """Logarithm of the posterior density at its maximum, up to a constant of the runs."""
        return -self._best[0]

    def _search(self, shift: float) -> tuple[float, FloatArray]:
        """Lowest value and its place, from the best of some shares of noise."""
        ranges = self.centre[:-1] + shift
        starts = [np.append(ranges, logit) for logit in (-6.0, -3.0, 0.0)]
        start = min(starts, key=lambda theta: self(theta)[0])
        found = optimize.minimize(self, start, jac=True, method="L-BFGS-B", bounds=self.bounds)
        # Rounded, so that rounding errors do not decide between searches that ended at one place.
        return round(float(found.fun), 6), np.asarray(found.x, dtype=float)

    def _curvature(self, theta: FloatArray) -> FloatArray:
        step = 1e-3
        rows = [
            (self(theta + shift)[1] - self(theta - shift)[1]) / (2 * step)
            for shift in step * np.eye(len(theta))
        ]
        return np.asarray((np.array(rows) + np.array(rows).T) / 2)

    def support(self) -> list[tuple[FloatArray, float]]:
        """Points and weights that represent the posterior distribution.

        The rows of a Hadamard matrix, stretched by the curvature at the maximum, have the mean
        and the covariance of the normal approximation; with their mirror images they also have its
        third moments. The weights correct for a posterior that is not normal.
        """
        mode = self.maximum()
        lowest = self(mode)[0]
        eigenvalues, vectors = np.linalg.eigh(self._curvature(mode))
        # Except for rounding, the posterior is nowhere much flatter than the prior.
        floor = 0.5 / self.spread.max() ** 2
        stretch = vectors / np.sqrt(np.maximum(eigenvalues, floor))
        p = len(mode)
        directions = linalg.hadamard(2 ** math.ceil(math.log2(p)))[:, :p].astype(float)
        if p <= _MIRRORED_UP_TO:
            directions = np.vstack([directions, -directions])
        low, high = np.array(self.bounds).T
        thetas = [np.clip(mode + stretch @ direction, low, high) for direction in directions]
        depth = np.array([self(theta)[0] for theta in thetas]) - lowest - 0.5 * p
        # Limited, so that one point above the local maximum does not get all the weight.
        weights = np.exp(-np.clip(depth, -3.0, None))
        kept = weights > 1e-4 * weights.max()
        weights /= weights[kept].sum()
        return [(thetas[i], float(weights[i])) for i in np.flatnonzero(kept)]

    def hyperparameters(self) -> list[Hyperparameters]:
        """Weighted sets of hyperparameters to predict with, with their estimated variances."""
        found = []
        for theta, weight in self.support():
            parts = self._covariance(theta)
            factor = linalg.cholesky(parts.matrix, lower=True)
            whitened = linalg.solve_triangular(factor, self.values, lower=True)
            variance = float(whitened @ whitened) / len(self.values) * (1.0 - self.known_share)
            noise = variance * parts.noise_share
            signal = (variance - noise) / parts.mean_correlation
            found.append(Hyperparameters(parts.ranges, signal, noise, weight))
        return found
