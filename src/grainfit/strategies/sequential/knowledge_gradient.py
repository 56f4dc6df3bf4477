"""Knowledge gradient: expected improvement of the answer by one more run at a point."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from grainfit.arrays import Array
from grainfit.metamodels.metamodels import Metamodels

#: Number of equally likely outcomes of a run to average over.
_OUTCOMES = 32
#: Largest step of the answer per axis, to follow the information from a run.
_STEP = 0.05
_LARGEST_BLOCK = 2_000_000


class KnowledgeGradient:
    """Expected decrease of the smallest expected misfit by one more run, noise accounted for.

    The misfit of a point is the expected sum of squared deviations of its *expected* responses,
    in units of the tolerances: ``m^T m + sum(v)``, with the means m and variances v of the
    deviations. A run at another point will change them by ``m + s z`` and ``v - s^2``: z is
    standard normal, and s is the covariance of both points over the standard deviation of the
    run, noise included. The improvement is the smallest misfit now, less the smallest misfit then,
    averaged over z. So a lucky run improves nothing, and a repeated run counts by its information.

    The smallest misfit is sought among finitely many points, each of which may take a short step
    to follow the information from the run: with the slopes J of the deviations and a step of length
    L, ``m^T m`` becomes ``m^T (I + L^2 J J^T)^-1 m``.

    With correlations R of the targets the misfit is ``m^T R^-1 m`` and the sum of the variances
    times the diagonal of ``R^-1``; R takes the place of I.

    Parameters
    ----------
    metamodels : Metamodels
        Conditioned on the pending runs.
    points : ndarray, shape (m, d)
        Possible answers.
    handicaps : ndarray, shape (m,)
        Added to the misfits of the possible answers, to prefer some of them.
    of_relatives : bool
        Whether the run is one of the relatives of tests.

    References
    ----------
    Uhrenholt & Jensen (2019), "Efficient Bayesian optimization for target vector estimation",
    AISTATS: one Gaussian process per response, improvement of the sum of squares.
    Scott, Frazier & Powell (2011), SIAM J. Optim. 21, 996-1026: the knowledge gradient, that is
    improvement of the expected response by a noisy run.
    Letham, Karrer, Ottoni & Bakshy (2019), Bayesian Anal. 14, 495-519: noisy expected improvement.
    """

    def __init__(
        self,
        metamodels: Metamodels,
        points: Array,
        handicaps: Array,
        *,
        of_relatives: bool = False,
    ) -> None:
        means, variances = metamodels.deviations(points)
        slopes = metamodels.slopes(points)
        stiffness = metamodels.correlation + _STEP**2 * slopes @ slopes.transpose(0, 2, 1)
        self._follows = np.linalg.inv(stiffness)
        self._pull = np.einsum("mkl,ml->mk", self._follows, means)
        self._precisions = metamodels.precisions
        unknown = (variances * self._precisions).sum(axis=1)
        self._now = (means * self._pull).sum(axis=1) + unknown + handicaps
        if of_relatives:
            self._covariance = metamodels.covariance_with_relatives(points)
            self._scatter_at = metamodels.scatter_of_relatives_at
        else:
            self._covariance = metamodels.covariance_with(points)
            self._scatter_at = metamodels.scatter_at
        self._outcomes = _normal_outcomes(means.shape[1])

    @property
    def smallest_misfit(self) -> float:
        """Smallest expected misfit of the possible answers now."""
        return float(self._now.min())

    def __call__(self, points: Array, yields: NDArray[np.bool_] | None = None) -> Array:
        """Expected improvement by a run at each of some points, shape (m,); not negative.

        ``yields`` says which targets the run yields, see `Metamodels.yielded_by`; all by default.
        """
        return self.with_unknown(points, yields)[0]

    def with_unknown(
        self, points: Array, yields: NDArray[np.bool_] | None = None
    ) -> tuple[Array, Array]:
        """Return the improvements, and the summed variances of these targets there."""
        per_block = max(1, _LARGEST_BLOCK // (len(self._now) * _OUTCOMES))
        blocks = [
            self._of_block(points[start : start + per_block], yields)
            for start in range(0, len(points), per_block)
        ]
        improvements, unknown = zip(*blocks, strict=True)
        return np.concatenate(improvements), np.concatenate(unknown)

    def _of_block(self, points: Array, yields: NDArray[np.bool_] | None) -> tuple[Array, Array]:
        covariance, variance = self._covariance(points)
        shifts = covariance / np.sqrt(variance + self._scatter_at(points).T)[:, None, :]
        if yields is not None:
            shifts = np.where(yields[:, None, None], shifts, 0.0)
        settled = self._now[:, None] - (shifts**2 * self._precisions[:, None, None]).sum(axis=0)
        linear = 2.0 * self._pull.T[:, :, None] * shifts
        first, second = np.triu_indices(len(shifts))
        twice = np.where(first == second, 1.0, 2.0)[:, None, None]
        quadratic = twice * self._follows[:, first, second].T[:, :, None]
        quadratic = quadratic * shifts[first] * shifts[second]
        terms = np.concatenate([linear, quadratic])
        outcomes = self._outcomes
        factors = np.hstack([outcomes, outcomes[:, first] * outcomes[:, second]])
        then = np.tensordot(factors, terms, axes=1) + settled
        improved = np.maximum(self.smallest_misfit - then.min(axis=1).mean(axis=0), 0.0)
        return improved, (variance if yields is None else variance[yields]).sum(axis=0)


@cache
def _normal_outcomes(responses: int) -> Array:
    """Equally likely standard normal vectors, symmetric about zero, shape (n, responses)."""
    # Loaded late, because it takes half a second.
    from scipy.stats import qmc

    uniform = qmc.Sobol(responses, rng=2019).random(_OUTCOMES // 2)
    half = ndtri(np.clip(uniform, 1e-3, 1 - 1e-3))
    return np.asarray(np.vstack([half, -half]))
