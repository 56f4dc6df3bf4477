"""Weighted points of a probability density over the unit cube, by adaptive importance sampling.

Rougher than the ensembles of the analysis, and much faster: a search asks for it after every run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from grainfit.arrays import Array
from grainfit.metamodels.unit_cube import spread_points

#: Logarithms of the density at points, but for a constant, shape (m, d) to (m,).
LogDensity = Callable[[Array], Array]


_POINTS, _FINAL_POINTS = 2048, 4096
#: Share of the points that must count with each sharpening of the density.
_KEPT = 0.12
#: Kernels of a proposal density.
_CENTRES = 256
#: Share of points that are drawn from the whole cube, so that no weight grows without limit.
_EVERYWHERE = 0.05
#: No metamodel has a density that takes more sharpenings.
_MOST_SHARPENINGS = 60
#: Least factor from one power of the density to the next.
_GROWTH = 1.3
_NO_SPREAD = 1e-9
_BLOCK = 512
#: Centres that make the neighbourhood of one; width of a kernel over its neighbourhood, and over
#: the whole at least.
_NEIGHBOURS = 40
_WIDTH, _SHARE_OF_WHOLE = 1.0, 0.01


@dataclass(frozen=True)
class ImportanceSample:
    """Points and the logarithm of the density from which they were drawn.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        In the unit cube.
    log_proposals : ndarray, shape (n,)
        Logarithms of the density from which each was drawn.
    """

    points: Array
    log_proposals: Array

    def weights(self, log_densities: Array) -> Array:
        """Return the weights with which the points represent a density, summing to 1, shape (n,).

        Parameters
        ----------
        log_densities : ndarray, shape (n,)
            Logarithms of that density at the points, but for a constant.
        """
        return _normalised(log_densities - self.log_proposals)


def importance_sample(
    log_density: LogDensity, dimension: int, random: np.random.Generator
) -> ImportanceSample:
    """Draw points that lie where a density over the unit cube has its mass.

    Points are drawn from kernels about earlier points, beginning with points all over the cube,
    while the density is sharpened from a constant to its final form.

    Parameters
    ----------
    log_density : callable
        Logarithms of the density at points of the cube.
    dimension : int
        Number of parameters.
    random : numpy.random.Generator
        Draws the points.

    Returns
    -------
    ImportanceSample

    References
    ----------
    Cappé, Guillin, Marin & Robert (2004), J. Comput. Graph. Stat. 13, 907-929: population Monte
    Carlo.
    West (1993), J. R. Stat. Soc. B 55, 409-422: mixtures of kernels as proposal densities.
    Del Moral, Doucet & Jasra (2006), J. R. Stat. Soc. B 68, 411-436: sharpening step by step.
    """
    sample = ImportanceSample(spread_points(_POINTS, dimension, random), np.zeros(_POINTS))
    power = 0.0
    for _ in range(_MOST_SHARPENINGS):
        values = log_density(sample.points)
        # Where the kernels fit a density badly, it is sharpened all the same.
        is_refined, least = power >= 1.0, _GROWTH * power
        power = min(1.0, max(_largest_power(values, sample.log_proposals), least))
        kernels = _Kernels.about(sample, power * values, random)
        if is_refined:
            break
        sample = kernels.draw(_POINTS, random)
    return kernels.draw(_FINAL_POINTS, random)


def weighted_quantiles(values: Array, weights: Array, shares: tuple[float, ...]) -> Array:
    """Return quantiles of values with weights that sum to 1, shape (shares,)."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order]) - 0.5 * weights[order]
    return np.asarray(np.interp(shares, below, values[order]))


def representatives(
    points: Array, weights: Array, count: int, random: np.random.Generator
) -> Array:
    """Return points of which each stands for an equal share of the weights, shape (count, d)."""
    places = (np.arange(count) + random.random()) / count
    found = np.searchsorted(np.cumsum(weights), places)
    return np.asarray(points[np.minimum(found, len(weights) - 1)])


@dataclass(frozen=True)
class _Kernels:
    """Normal kernels, each of the shape of its neighbourhood, and an even share over the cube.

    What a kernel has beyond the cube is never drawn; weights do not mind a constant.
    """

    centres: Array
    factors: Array

    @classmethod
    def about(
        cls, sample: ImportanceSample, log_densities: Array, random: np.random.Generator
    ) -> _Kernels:
        """Place kernels about points where a density has its mass."""
        weights = sample.weights(log_densities)
        centres = representatives(sample.points, weights, _CENTRES, random)
        off = centres - centres.mean(axis=0)
        whole = off.T @ off / len(centres) + _NO_SPREAD**2 * np.eye(centres.shape[1])
        whitening = np.linalg.inv(np.linalg.cholesky(whole)).T
        distances = cdist(centres @ whitening, centres @ whitening)
        # Along a curved ridge, the shape of the whole fits nowhere.
        near = centres[np.argpartition(distances, _NEIGHBOURS, axis=1)[:, :_NEIGHBOURS]]
        apart = near - centres[:, None]
        local = np.einsum("cni,cnj->cij", apart, apart) / _NEIGHBOURS
        return cls(centres, np.linalg.cholesky(_WIDTH**2 * local + _SHARE_OF_WHOLE**2 * whole))

    def draw(self, count: int, random: np.random.Generator) -> ImportanceSample:
        """Draw about as many points; those beyond the cube are left out."""
        dimension = self.centres.shape[1]
        everywhere = random.random((math.ceil(_EVERYWHERE * count), dimension))
        chosen = np.arange(count - len(everywhere)) % len(self.centres)
        moves = random.standard_normal((len(chosen), dimension))
        moved = self.centres[chosen] + np.einsum("nij,nj->ni", self.factors[chosen], moves)
        inside = ((moved >= 0.0) & (moved <= 1.0)).all(axis=1)
        points = np.vstack([moved[inside], everywhere])
        return ImportanceSample(points, self._logarithms(points))

    def _logarithms(self, points: Array) -> Array:
        """Logarithms of the density at points, shape (m,)."""
        count, dimension = self.centres.shape
        whitening = np.linalg.inv(self.factors)
        places = np.einsum("cij,cj->ci", whitening, self.centres)
        sizes = np.log(np.diagonal(self.factors, axis1=1, axis2=2)).sum(axis=1)
        constant = 0.5 * dimension * math.log(2.0 * math.pi) + math.log(count)
        kernels = np.empty(len(points))
        for start in range(0, len(points), _BLOCK):
            block = slice(start, start + _BLOCK)
            squares = np.zeros((len(points[block]), count))
            for axis in range(dimension):
                squares += (points[block] @ whitening[:, axis].T - places[:, axis]) ** 2
            logarithms = -0.5 * squares - sizes
            largest = logarithms.max(axis=1)
            shares = np.exp(logarithms - largest[:, None]).sum(axis=1)
            kernels[block] = largest + np.log(shares) - constant
        return np.asarray(
            np.logaddexp(math.log(1.0 - _EVERYWHERE) + kernels, math.log(_EVERYWHERE))
        )


def _normalised(logarithms: Array) -> Array:
    weights = np.exp(logarithms - logarithms.max())
    return np.asarray(weights / weights.sum())


def _largest_power(values: Array, log_proposals: Array) -> float:
    """Largest power of the density, up to 1, with which enough points still count (bisection)."""
    enough = _KEPT * len(values)

    def counting(power: float) -> float:
        return 1.0 / float((_normalised(power * values - log_proposals) ** 2).sum())

    if counting(1.0) >= enough:
        return 1.0
    # In logarithms: the first power of a sharp density is many orders of magnitude below one.
    low, high = -300.0, 0.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if counting(10.0**middle) >= enough else (low, middle)
    return float(10.0**low)
