"""Sensitivity: share of a response's variation over the intervals that each parameter explains."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis import messages
from grainfit.analysis.response_surfaces import draw_surfaces
from grainfit.arrays import Array
from grainfit.errors import InputError
from grainfit.formatting import in_a_row
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import spread_points
from grainfit.one_line import OneLine
from grainfit.one_thread import one_thread

_SURFACES = 200
#: Ends of intervals nearer to 0 or 1 are 0 or 1.
_NEXT_TO_NOTHING = 0.01
#: A response that varies by less than this share of itself is constant except for rounding.
_CONSTANT = 1e-9
_PROBED = 256
#: Shares of the variance: the smallest that is named, and the smallest due to interactions.
_NAMED = 0.05
_INTERACTION = 0.1
#: Upper end from which on a parameter with a small share may matter all the same.
_PERHAPS = 0.2
#: Indices whose intervals are wider say nothing.
_LARGEST_UNCERTAINTY = 0.5


@dataclass(frozen=True)
class Sensitivity(OneLine):
    """Sobol' indices of all responses, with 95 % intervals that hold the metamodel's error.

    All arrays have the shape (number of targets, d); all numbers are shares of the variance of
    the expected response over the intervals of the parameters, from 0 to 1, and 0 for a response
    that is constant. An index is the mean of those of all surfaces that agree with the runs.

    Attributes
    ----------
    names : tuple of str
        Free parameters.
    responses : tuple of str
        Names of the targets.
    first, first_low, first_high : ndarray
        First-order indices: effect of a parameter by itself.
    total, total_low, total_high : ndarray
        Total indices: its effect by itself and together with others.
    scopes : tuple of tuple of str
        Parameters that the test of each target depends on; empty if all targets depend on all.
    """

    names: tuple[str, ...]
    responses: tuple[str, ...]
    first: Array
    first_low: Array
    first_high: Array
    total: Array
    total_low: Array
    total_high: Array
    scopes: tuple[tuple[str, ...], ...] = ()

    def uncertainty(self, row: int) -> float:
        """Return the width of the widest interval of a response's total indices."""
        return float((self.total_high[row] - self.total_low[row]).max())

    def is_known(self, row: int) -> bool:
        """Whether the indices of a response are certain enough to be shown.

        Judged by the width of their own intervals, which means something wherever the runs are.
        A Q2 does not for runs that a search has placed close together. Of a design, hardly any
        metamodel with a Q2 below 0.5 passes.
        """
        return self.uncertainty(row) <= _LARGEST_UNCERTAINTY

    def in_words(self) -> tuple[str, ...]:
        """Return one or two sentences per response about the parameters on which it depends."""
        return tuple(self._sentence(row, name) for row, name in enumerate(self.responses))

    def _sentence(self, row: int, response: str) -> str:
        total = self.total[row]
        if not total.any():
            return messages.DEPENDS_ON_NONE(response=response)
        if not self.is_known(row):
            share = 100 * self.uncertainty(row)
            return messages.SENSITIVITY_NOT_KNOWN(response=response, uncertainty=share)
        order = np.argsort(-total, kind="stable")
        named = [
            (messages.SHARE_WITH_OTHERS if self._interacts(row, i) else messages.SHARE)(
                parameter=self.names[i], share=100 * total[i]
            )
            for i in order
            if total[i] >= _NAMED or i == order[0]
        ]
        known = self.scopes[row] if self.scopes else self.names
        others = [i for i in order[1:] if total[i] < _NAMED and self.names[i] in known]
        perhaps = [self.names[i] for i in others if self.total_high[row, i] > _PERHAPS]
        hardly = [self.names[i] for i in others if self.total_high[row, i] <= _PERHAPS]
        rest = f", perhaps on {in_a_row(perhaps)}" if perhaps else ""
        rest += f", hardly on {in_a_row(hardly)}" if hardly else ""
        return messages.DEPENDS_ON(response=response, parameters=in_a_row(named), rest=rest)

    def _interacts(self, row: int, column: int) -> bool:
        return bool(self.total[row, column] - self.first[row, column] >= _INTERACTION)


def estimate_sensitivity(
    metamodels: Metamodels, *, seed: int = 1, points: int = 512
) -> Sensitivity:
    """Estimate Sobol' indices of the expected responses over the intervals of the parameters.

    The indices of many surfaces that agree with the runs are computed, each at another bootstrap
    sample of the points. Their spread has the error of the metamodel and that of the points.

    A metamodel may take an effect that it does not resolve for scatter. So the intervals are wider:
    they hold the indices of the metamodel's mean for two extreme cases. In the first, the
    unexplained variance is due to one parameter alone; in the second, to the others. Unexplained
    is the variance of the surfaces drawn, or that of runs left out.

    Parameters
    ----------
    metamodels : Metamodels
        Of all responses.
    seed : int
        The same seed gives the same indices.
    points : int
        Power of two; each surface is computed at (d + 2) times as many points.

    Returns
    -------
    Sensitivity

    Raises
    ------
    InputError
        The number of points is no power of two.

    References
    ----------
    Saltelli, Annoni, Azzini, Campolongo, Ratto & Tarantola (2010), Comput. Phys. Commun. 181,
    259-270: indices.
    Le Gratiet, Cannamela & Iooss (2014), SIAM/ASA J. Uncertain. Quantif. 2, 336-363: surfaces drawn
    from the metamodel, with bootstrap.
    """
    if points < 2 or points & (points - 1):
        raise InputError(messages.NO_POWER_OF_TWO.fault("points", given=points))
    problem = metamodels.problem
    names = tuple(parameter.name for parameter in problem.parameters)
    scopes = tuple(tuple(problem.scope_of(t.name).parameters) for t in problem.targets)
    with one_thread():
        varied = _varied(metamodels, np.random.default_rng(seed))
        found = np.zeros((6, len(problem.targets), problem.dimension))
        for row in np.flatnonzero(varied):
            indices = _indices(metamodels.models[row], problem.dimension, seed, points)
            # No error of a metamodel is due to a parameter that the test does not have.
            found[:, row] = np.where(np.isin(names, scopes[row]), indices, 0.0)
    responses = tuple(target.name for target in problem.targets)
    return replace(Sensitivity(names, responses, *found), scopes=scopes)


def _varied(metamodels: Metamodels, random: np.random.Generator) -> NDArray[np.bool_]:
    """Return for each response True if it varies over the cube."""
    means, _ = metamodels.predict(spread_points(_PROBED, metamodels.problem.dimension, random))
    return np.asarray(np.ptp(means, axis=0) > _CONSTANT * np.abs(means).max(axis=0))


def _indices(model: Kriging, dimension: int, seed: int, points: int) -> Array:
    """First and total indices of a response, each with its ends, shape (6, d)."""
    if dimension == 1:
        # By definition; an estimate from a sample could differ.
        return np.ones((6, 1))
    random = np.random.default_rng(seed)
    asked = _points(dimension, points, random)
    mean = model.predict(asked).mean
    unseen = _mean_squared_error(model)
    drawn, least, most = [], [], []
    for surface in draw_surfaces(model, asked, _SURFACES, random):
        chosen = random.integers(points, size=points)
        of_mean, variance = _of_surface(mean, dimension, chosen)
        _, unknown = _of_surface(surface - mean, dimension, chosen)
        # Whatever the metamodel does not explain may be due to any parameter, or to none.
        share = max(unknown, unseen) / (variance + max(unknown, unseen))
        drawn.append(_of_surface(surface, dimension, chosen)[0])
        least.append((1.0 - share) * of_mean)
        most.append((1.0 - share) * of_mean + share)
    low = np.quantile([drawn, least], 0.025, axis=1).min(axis=0)
    high = np.quantile([drawn, most], 0.975, axis=1).max(axis=0)
    # No surface that is drawn is exactly flat along a parameter.
    low = np.where(low < _NEXT_TO_NOTHING, 0.0, low)
    high = np.where(high > 1.0 - _NEXT_TO_NOTHING, 1.0, high)
    best = np.clip(np.mean(drawn, axis=0), low, high)
    return np.stack([best, low, high], axis=1).reshape(6, dimension)


def _mean_squared_error(model: Kriging) -> float:
    """Mean squared error of a run that is left out: scatter, and what the metamodel misses."""
    components = model.to_plain(factors=False)
    values = components["offset"] + components["scale"] * np.array(components["values"])
    return float(np.mean((values - model.leave_one_out().predicted) ** 2))


def _points(dimension: int, points: int, random: np.random.Generator) -> Array:
    """Two samples, and the first with each coordinate in turn taken from the second."""
    base = spread_points(points, 2 * dimension, random)
    first, second = base[:, :dimension], base[:, dimension:]
    exchanged = np.tile(first, (dimension, 1, 1))
    for axis in range(dimension):
        exchanged[axis, :, axis] = second[:, axis]
    return np.vstack([first, second, exchanged.reshape(-1, dimension)])


def _of_surface(surface: Array, dimension: int, chosen: NDArray[np.intp]) -> tuple[Array, float]:
    """First and total indices of a surface at some of the points, shape (2, d); its variance."""
    answers = surface.reshape(dimension + 2, -1)[:, chosen]
    first, second, exchanged = answers[0], answers[1], answers[2:]
    middle, variance = answers[:2].mean(), float(answers[:2].var())
    alone = ((second - middle) * (exchanged - first)).mean(axis=1)
    whole = 0.5 * ((first - exchanged) ** 2).mean(axis=1)
    # Estimates of shares near 0 or 1 can lie outside that range.
    return np.clip(np.array([alone, whole]) / max(variance, 1e-300), 0.0, 1.0), variance
