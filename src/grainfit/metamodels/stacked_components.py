"""Predictions by all sets of hyperparameters of a metamodel at once.

At few points a prediction by one set after the other is mostly overhead of NumPy: calls on small
arrays. Stacked, all sets take as many calls as one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grainfit.arrays import Array
from grainfit.metamodels.predictor import Component, matern, matern_slope

#: Most points, and most correlations of all sets, for which stacking pays: larger arrays leave the
#: caches of the processor, where one set after the other stays within.
_MOST_POINTS = 256
_MOST_CORRELATIONS = 100_000


class StackedComponents:
    """Kriging predictors of the same runs and trend, without a relative, as one.

    Parameters
    ----------
    components : sequence of Component
        One for each set of hyperparameters.
    """

    def __init__(self, components: Sequence[Component]) -> None:
        first, parts = components[0], [component.parts for component in components]
        self._trend = first.trend
        self._runs = first.points.T[:, :, None]
        sets = [component.hyperparameters for component in components]
        self._inverse_squares = np.array([1.0 / one.ranges**2 for one in sets])
        self._signal_variances = np.array([one.signal_variance for one in sets])[:, None]
        self._coefficients = np.array([one.coefficients for one in parts])[:, None, :]
        self._trend_coefficients = np.array([one.trend_coefficients for one in parts])
        dimension = first.points.shape[1]
        self._slopes_of_trend = np.array(
            [first.trend.slopes(one.trend_coefficients, dimension) for one in parts]
        )
        self._trend_covariances = np.array([one.trend_covariance for one in parts])
        self._least_squares = np.array([one.least_squares for one in parts])
        self._roots = np.array([one.root for one in parts])
        self._roots_of_trend = np.array([one.root_of_trend for one in parts])

    @staticmethod
    def pays(components: Sequence[Component], points: int) -> bool:
        """Return whether predictions at so many points are faster than one after the other."""
        correlations = len(components) * len(components[0].points) * points
        return 0 < points <= _MOST_POINTS and correlations <= _MOST_CORRELATIONS

    def means(self, points: Array) -> Array:
        """Means at points, shape (sets, points)."""
        return self._means(self._covariance(points), self._trend.matrix(points).T)

    def _means(self, covariance: Array, trend: Array) -> Array:
        return np.asarray(
            self._trend_coefficients @ trend + (self._coefficients @ covariance)[:, 0]
        )

    def predict(self, points: Array) -> tuple[Array, Array]:
        """Means and variances of the mean at points, shape (sets, points) each."""
        covariance = self._covariance(points)
        trend = self._trend.matrix(points).T
        of_trend = self._trend_covariances @ trend - 2.0 * (self._least_squares @ covariance)
        of_trend *= trend
        explained = self._roots @ covariance
        explained -= self._roots_of_trend @ trend
        explained *= explained
        variances = self._signal_variances + of_trend.sum(axis=1) - explained.sum(axis=1)
        return self._means(covariance, trend), np.maximum(variances, 0.0)

    def gradients(self, points: Array) -> Array:
        """Slopes of the means, shape (sets, points, d)."""
        pull = matern_slope(self._distances(points))
        pull *= self._signal_variances[:, :, None] * np.swapaxes(self._coefficients, 1, 2)
        away = pull.sum(axis=1)[:, :, None] * points
        away -= np.swapaxes(pull, 1, 2) @ self._runs[:, :, 0].T
        away *= self._inverse_squares[:, None, :]
        return np.asarray(self._slopes_of_trend[:, None, :] - away)

    def _covariance(self, points: Array) -> Array:
        """Covariances between runs and points, shape (sets, runs, points)."""
        covariance = matern(self._distances(points))
        covariance *= self._signal_variances[:, :, None]
        return covariance

    def _distances(self, points: Array) -> Array:
        """Distances between runs and points in ranges, shape (sets, runs, points)."""
        squares = points.T[:, None, :] - self._runs
        squares *= squares
        dimension, runs, count = squares.shape
        found = np.sqrt(self._inverse_squares @ squares.reshape(dimension, runs * count))
        return found.reshape(-1, runs, count)
