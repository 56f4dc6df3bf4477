"""A cheaper relative of a response as a part of its prior: autoregressive co-Kriging.

A relative is the same response of a cheaper model: softer or larger particles, a table of runs. The
response is a ratio times that of the relative, plus a difference that is a Gaussian process of its
own. With the runs of the relative known, the ratio times its expected response is a prior mean, and
the ratio squared times its covariance is added to that of the difference. A relative may have a
relative itself.

References
----------
Kennedy & O'Hagan (2000), Biometrika 87, 1-13: autoregressive model of a code and cheaper ones.
Le Gratiet & Garnier (2014), Int. J. Uncertain. Quantif. 4, 365-386: one level after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array

#: Ratios of a response to that of its relative, and their probabilities before any run. With a
#: ratio of 0 the relative tells nothing.
RATIOS = {0.0: 0.3, 0.5: 0.1, 0.75: 0.15, 1.0: 0.25, 1.25: 0.1, 1.5: 0.1}
#: Step of the differences by which the slopes are computed, in intervals.
_STEP = 1e-5


class RelativeModel(Protocol):
    """What is needed of the metamodel of a relative: a `grainfit.metamodels.kriging.Kriging`."""

    @property
    def n(self) -> int:
        """Number of its runs."""
        ...

    @property
    def points(self) -> Array:
        """Points of its runs."""
        ...

    def mean(self, points: ArrayLike) -> Array:
        """Return its expected response."""
        ...

    def covariance_with(self, points: ArrayLike) -> Callable[[Array], tuple[Array, Array]]:
        """Prepare covariances of its expected response."""
        ...

    def scatter_at(self, points: Array) -> Array:
        """Return the variance that the scatter of its runs adds."""
        ...

    def condition_on_pending(self, points: ArrayLike) -> RelativeModel:
        """Add pending runs."""
        ...

    def embedded(self, axes: Sequence[int], points: Array) -> RelativeModel:
        """Return it over a larger unit cube."""
        ...

    def reduced(self, components: int) -> RelativeModel:
        """Return it with fewer sets of hyperparameters."""
        ...


class RelativeAt(NamedTuple):
    """What the relative tells of some points, in units of the standardised response.

    Its mean, shape (m,), its covariances with the runs of the response, shape (n, m), and its
    variances, shape (m,).
    """

    mean: Array
    covariance: Array
    variance: Array


class RelativePrior:
    """Metamodel of a relative, in the units of a standardised response.

    Parameters
    ----------
    model : RelativeModel
        Of the runs of the relative.
    offset, scale : float
        Of the standardised response.
    points : ndarray, shape (n, d)
        Points of the runs of the response.
    """

    def __init__(self, model: RelativeModel, offset: float, scale: float, points: Array) -> None:
        self.model = model
        self.points = points
        self._offset, self._scale = offset, scale
        self._covariances = model.covariance_with(points)
        # All sets of hyperparameters ask for the same points, one after the other.
        self._latest: tuple[bytes, RelativeAt] | None = None

    def at(self, points: Array) -> RelativeAt:
        """Return what the relative tells of some points."""
        key = points.tobytes()
        if self._latest is None or self._latest[0] != key:
            covariance, variance = self._covariances(points)
            mean = (self.model.mean(points) - self._offset) / self._scale
            squared = self._scale**2
            self._latest = key, RelativeAt(mean, covariance / squared, variance / squared)
        return self._latest[1]

    def pull_slopes(self, points: Array, ratio: float, pull: Array) -> Array:
        """Return slopes of what the relative adds to the expected response, shape (m, d).

        Parameters
        ----------
        points : ndarray, shape (m, d)
            Points in the unit cube.
        ratio : float
            Ratio of the mean.
        pull : ndarray, shape (n,)
            Factors of the covariances with the runs.
        """
        steps = _STEP * np.eye(points.shape[1])
        there = np.concatenate([points + side * step for step in steps for side in (1.0, -1.0)])
        found = self.at(there)
        added = (ratio * found.mean + pull @ found.covariance).reshape(-1, 2, len(points))
        return np.asarray((added[:, 0] - added[:, 1]).T / (2.0 * _STEP))

    def with_runs(self, points: Array) -> RelativePrior:
        """Return the same for other runs of the response."""
        return RelativePrior(self.model, self._offset, self._scale, points)

    def with_model(self, model: RelativeModel) -> RelativePrior:
        """Return the same with another metamodel of the relative."""
        return RelativePrior(model, self._offset, self._scale, self.points)

    def embedded(self, axes: Sequence[int], points: Array) -> RelativePrior:
        """Return the same over a larger unit cube, see `Kriging.embedded`."""
        own = np.full((self.model.n, points.shape[1]), 0.5)
        own[:, list(axes)] = self.model.points
        return RelativePrior(self.model.embedded(axes, own), self._offset, self._scale, points)
