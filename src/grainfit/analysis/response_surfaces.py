"""Draw response surfaces that agree with the runs: samples of what a metamodel leaves open."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy import linalg
from scipy.spatial.distance import cdist

from grainfit.arrays import Array
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.predictor import matern

#: Cosines that a surface is the sum of: their error is small beside that of few runs.
_COSINES = 512
#: Twice the smoothness of the Matérn covariance: degrees of freedom of its spectrum.
_SPECTRUM = 5.0


def draw_surfaces(model: Kriging, points: Array, count: int, random: np.random.Generator) -> Array:
    """Draw surfaces of the expected response from what the metamodel knows of it.

    Each surface is that of one set of hyperparameters, drawn by their probabilities: the mean of
    the metamodel, plus the error that it would make with a surface of the same covariance that
    is seen at the same runs with the same scatter (conditioning by Kriging). Its variance is
    drawn too, because it is estimated from the runs.

    Parameters
    ----------
    model : Kriging
        Metamodel of one response.
    points : ndarray, shape (m, d)
        Points of the unit cube.
    count : int
        Number of surfaces.
    random : numpy.random.Generator
        Draws them.

    Returns
    -------
    ndarray, shape (count, m)

    References
    ----------
    Chilès & Delfiner (2012), Geostatistics, 2nd edition, 7.3: conditioning by Kriging.
    Rahimi & Recht (2007), NIPS 20: random Fourier features.
    """
    known = model.to_plain(factors=False)
    weights = np.array([component["weight"] for component in known["components"]])
    counts = random.multinomial(count, weights / weights.sum())
    drawn = [
        _of_one_set(_OneSet(known, component), points, number, random)
        for component, number in zip(known["components"], counts.tolist(), strict=True)
        if number
    ]
    return np.asarray(known["offset"] + known["scale"] * np.concatenate(drawn))


class _OneSet:
    """Universal Kriging of any responses at the runs, with one set of hyperparameters."""

    def __init__(self, known: Mapping[str, Any], component: Mapping[str, Any]) -> None:
        self.ranges = np.array(component["ranges"])
        self.signal_variance = float(component["signal_variance"])
        self.columns = list(component["trend_columns"])
        self.runs = np.array(known["points"])
        self.values = np.array(known["values"])
        ratios = np.array(known.get("noise_ratios", np.ones(len(self.runs))))
        self.noise = component["noise_variance"] * ratios + np.array(known["known_noise"])
        covariance = self.covariance(self.runs) + np.diag(self.noise)
        self._factor = linalg.cho_factor(covariance, lower=True)
        self._trend = self.trend(self.runs)
        self._weighted = linalg.cho_solve(self._factor, self._trend)
        self.degrees_of_freedom = self._trend.shape[0] - self._trend.shape[1]

    def covariance(self, points: Array) -> Array:
        """Covariances of points with the runs, shape (m, n)."""
        distance = cdist(points / self.ranges, self.runs / self.ranges)
        return self.signal_variance * matern(distance)

    def trend(self, points: Array) -> Array:
        """Values of the trend's functions, shape (m, q)."""
        return np.column_stack([np.ones(len(points)), points[:, self.columns] - 0.5])

    def coefficients(self, responses: Array) -> tuple[Array, Array]:
        """Coefficients of trend and covariances for some responses, shape (n, k)."""
        normal = self._trend.T @ self._weighted
        of_trend = linalg.solve(normal, self._weighted.T @ responses, assume_a="pos")
        left = responses - self._trend @ of_trend
        return of_trend, linalg.cho_solve(self._factor, left)


def _of_one_set(kriging: _OneSet, points: Array, count: int, random: np.random.Generator) -> Array:
    both = np.vstack([points, kriging.runs])
    unconditional = _unconditional(kriging, both, count, random)
    there, at_runs = np.split(unconditional, [len(points)])
    scatter = np.sqrt(kriging.noise)[:, None] * random.standard_normal(at_runs.shape)
    # The mean first, then the errors.
    seen = np.column_stack([kriging.values, at_runs + scatter])
    of_trend, of_covariance = kriging.coefficients(seen)
    predicted = kriging.trend(points) @ of_trend + kriging.covariance(points) @ of_covariance
    freedom = kriging.degrees_of_freedom
    spread = np.sqrt(freedom / random.chisquare(freedom, count))
    return np.asarray((predicted[:, :1] + spread * (there - predicted[:, 1:])).T)


def _unconditional(
    kriging: _OneSet, points: Array, count: int, random: np.random.Generator
) -> Array:
    """Surfaces with the covariance alone, shape (m, count): sums of random cosines."""
    dimension = points.shape[1]
    stretch = np.sqrt(2.0 * _SPECTRUM / random.chisquare(_SPECTRUM, _COSINES))
    frequencies = random.standard_normal((dimension, _COSINES)) * stretch
    phases = random.uniform(0.0, 2.0 * np.pi, _COSINES)
    cosines = points / kriging.ranges @ frequencies
    # In place: new arrays of this size take longer than the arithmetic.
    cosines += phases
    np.cos(cosines, out=cosines)
    cosines *= np.sqrt(2.0 * kriging.signal_variance / _COSINES)
    return np.asarray(cosines @ random.standard_normal((_COSINES, count)))
