"""Share of runs that do not belong to the others, at any point of the intervals.

A test may jam in every place alike, or in one region, or always beyond a threshold. So the share
at a point counts the runs near it: a Beta distribution with kernel weights. How near is near is
averaged over several reaches, by how well each predicts every run from the others.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.special import softmax

from grainfit.arrays import Array
from grainfit.one_line import OneLine

#: Reaches of a run, per root of the dimension: one share everywhere, or ever smaller regions.
_REACHES = np.array([np.inf, 0.5, 0.25, 0.12, 0.06])
#: Probability that the share is the same everywhere, before any run.
_EVERYWHERE = 0.5
#: Runs that the share of all runs counts as, where none is near.
_PRIOR_RUNS = 0.5


class ShareOfJams(OneLine):
    """Probability that a run does not belong to the others, by where they are.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Points of all runs in the unit cube.
    is_jam : ndarray of bool, shape (n,)
        Those that do not belong to the others.

    References
    ----------
    Goetschalckx, Poupart & Hoey (2011), "Continuous correlated Beta processes", IJCAI: a Beta
    distribution whose counts are weighted with a kernel.
    """

    def __init__(self, points: Array, is_jam: NDArray[np.bool_]) -> None:
        self._points = points
        self._is_jam = is_jam
        share = (is_jam.sum() + 0.5) / (len(is_jam) + 1)
        self._prior = _PRIOR_RUNS * np.array([share, 1 - share])

    def at(self, points: Array) -> tuple[Array, Array, Array]:
        """Return the share at points, its variance, and the runs that it rests on, shape (m,)."""
        jams, others = self._counts(self._kernels(points))
        runs = jams + others
        shares = jams / runs
        weights = self._weights[:, None]
        mean = (weights * shares).sum(axis=0)
        within = shares * (1 - shares) / (runs + 1)
        variance = (weights * (within + (shares - mean) ** 2)).sum(axis=0)
        return mean, variance, (weights * runs).sum(axis=0)

    @cached_property
    def _weights(self) -> Array:
        """Probabilities of the reaches, by the prediction of each run from the others."""
        kernels = self._kernels(self._points)
        kernels[:, np.arange(len(self._points)), np.arange(len(self._points))] = 0.0
        jams, others = self._counts(kernels)
        predicted = np.where(self._is_jam, jams, others) / (jams + others)
        local = (1 - _EVERYWHERE) / (len(_REACHES) - 1)
        prior = np.where(np.isinf(_REACHES), _EVERYWHERE, local)
        return np.asarray(softmax(np.log(predicted).sum(axis=1) + np.log(prior)))

    def _kernels(self, points: Array) -> Array:
        """Weights of the runs at points, shape (reaches, m, n)."""
        distances = cdist(points, self._points) / np.sqrt(points.shape[1])
        return np.asarray(np.exp(-0.5 * (distances / _REACHES[:, None, None]) ** 2))

    def _counts(self, kernels: Array) -> tuple[Array, Array]:
        jams = kernels[..., self._is_jam].sum(axis=-1) + self._prior[0]
        return jams, kernels[..., ~self._is_jam].sum(axis=-1) + self._prior[1]
