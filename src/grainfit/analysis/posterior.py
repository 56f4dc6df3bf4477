"""Sample the posterior: parameter sets that agree with the measurements, given all runs."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.stats import rankdata

from grainfit.analysis import messages
from grainfit.analysis.ensemble import sample_cube
from grainfit.arrays import Array
from grainfit.errors import InputError
from grainfit.extras import import_extra
from grainfit.metamodels.credible_interval import extended_to_bounds
from grainfit.metamodels.likelihood import Succeeds, log_density
from grainfit.metamodels.metamodels import Metamodels
from grainfit.one_line import OneLine
from grainfit.one_thread import one_thread
from grainfit.problem import Parameter, Problem
from grainfit.student import LEVEL


@dataclass(frozen=True)
class Posterior(OneLine):
    """A sample of the parameter sets that agree with the measurements.

    Attributes
    ----------
    parameters : tuple of Parameter
        Free parameters.
    points : ndarray, shape (n, d)
        In the unit cube.
    values : ndarray, shape (n, d)
        The same in SI units.
    responses : ndarray, shape (n, number of targets)
        Expected responses at these points.
    converged : bool
        Whether the sample is good enough to quote its intervals.
    convergence : str
        Reasons for that, in words.
    effective_samples : float
        Number of independent samples with as much information.
    chains : ndarray, shape (walkers, steps, d)
        All steps of the walkers of emcee from which the sample is taken, SI.
    """

    parameters: tuple[Parameter, ...]
    points: Array
    values: Array
    responses: Array
    converged: bool
    convergence: str
    effective_samples: float
    chains: Array = field(default_factory=lambda: np.empty((0, 0, 0)), repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    def interval(self, name: str, level: float = LEVEL) -> tuple[float, float]:
        """Credible interval of a parameter, SI: equal-tailed, and up to bounds that are near.

        An end that is nearer to its bound than a tenth of the interval lies on the bound.

        Parameters
        ----------
        name : str
            Name of the parameter.
        level : float
            Probability that the value is inside, between 0 and 1.

        Raises
        ------
        InputError
            There is no such parameter, or the level is not between 0 and 1.
        """
        if not 0.0 < level < 1.0:
            raise InputError(messages.BAD_LEVEL.fault("level", given=level))
        tail = (1.0 - level) / 2.0
        axis = self._axis(name)
        ends = np.quantile(self.points[:, axis], [tail, 1.0 - tail])
        low, high = (float(end) for end in extended_to_bounds(*ends))
        parameter = self.parameters[axis]
        return parameter.from_unit(low), parameter.from_unit(high)

    def median(self, name: str) -> float:
        """Median of a parameter, SI."""
        return float(np.median(self.values[:, self._axis(name)]))

    @cached_property
    def correlations(self) -> Array:
        """Rank correlations (Spearman's) of the parameters, shape (d, d).

        Ranks make them the same on a linear and a logarithmic scale, and ±1 on any monotonic
        curve.
        """
        ranks = rankdata(self.points, axis=0)
        ranks -= ranks.mean(axis=0)
        lengths = np.sqrt((ranks**2).sum(axis=0))
        ranks /= np.where(lengths > 0.0, lengths, 1.0)
        found = np.clip(ranks.T @ ranks, -1.0, 1.0)
        np.fill_diagonal(found, 1.0)
        return np.asarray(found)

    def to_arviz(self) -> Any:
        """Return the chains for ArviZ: every walker of emcee is a chain, every step a draw.

        A ``/`` in the name of a parameter becomes ``_``, because ArviZ separates groups by it.

        Returns
        -------
        arviz.InferenceData
            With one variable for each parameter, SI; from ArviZ 1 on, the ``DataTree`` that
            replaces it.

        Raises
        ------
        InputError
            ArviZ is not installed.

        Examples
        --------
        >>> import arviz  # doctest: +SKIP
        >>> arviz.summary(saved.analyse().posterior.to_arviz())  # doctest: +SKIP
        """
        arviz = import_extra("arviz", "arviz", "a posterior for ArviZ")
        names = [name.replace("/", "_") for name in self.names]
        variables = {name: self.chains[..., axis] for axis, name in enumerate(names)}
        if arviz.__version__.startswith("0."):
            data = arviz.from_dict(posterior=variables)
        else:
            data = arviz.from_dict({"posterior": variables})
        data.posterior.attrs["inference_library"] = "emcee"
        return data

    def _axis(self, name: str) -> int:
        if name not in self.names:
            known = ", ".join(self.names)
            raise InputError(messages.NO_PARAMETER.fault("name", given=name, known=known))
        return self.names.index(name)


def sample_posterior(
    metamodels: Metamodels,
    succeeds: Succeeds | None = None,
    *,
    seed: int = 1,
    samples: int = 4000,
    max_steps: int = 500,
) -> Posterior:
    """Sample the posterior distribution of the parameters.

    Before the measurements, all points of the unit cube are equally likely (so all magnitudes of
    a parameter with ``scale="log"``) but those at which runs fail; a parameter with a measurement
    of its own is normally distributed about it. The measured values are normally distributed about
    the expected responses. Their variance is that of the measurement plus that of the metamodel's
    mean, which includes the scatter from run to run; correlations of the targets are those of the
    measurement.

    Parameters
    ----------
    metamodels : Metamodels
        Of all responses; `Kriging.reduced` makes them faster.
    succeeds : callable, optional
        Whether runs are likely to succeed at points; by default they are everywhere.
    seed : int
        The same seed gives the same sample.
    samples : int
        Number of points to return.
    max_steps : int
        Most steps of each walker; if they are too few, ``converged`` is False.

    Returns
    -------
    Posterior

    References
    ----------
    Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63, 425-464.
    """
    problem = metamodels.problem
    with one_thread():
        sample = sample_cube(
            log_density(metamodels, succeeds),
            problem.dimension,
            seed=seed,
            samples=samples,
            max_steps=max_steps,
        )
        responses, _ = metamodels.predict(sample.points)
    values = [list(problem.from_unit(point).values()) for point in sample.points]
    return Posterior(
        parameters=tuple(problem.parameters),
        points=sample.points,
        values=np.array(values),
        responses=responses,
        converged=sample.converged,
        convergence=sample.convergence,
        effective_samples=sample.effective_samples,
        chains=_in_units(problem, sample.chains),
    )


def _in_units(problem: Problem, points: Array) -> Array:
    """Return points of the unit cube, shape (..., d), in SI units."""
    columns = [
        p.minimum * (p.maximum / p.minimum) ** points[..., axis]
        if p.scale == "log"
        else p.minimum + points[..., axis] * (p.maximum - p.minimum)
        for axis, p in enumerate(problem.parameters)
    ]
    return np.stack(columns, axis=-1)
