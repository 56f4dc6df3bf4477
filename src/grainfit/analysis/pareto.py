"""Pareto front of misfit and Rayleigh time step."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from grainfit.arrays import Array
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.time_steps import log_time_steps, with_long_steps
from grainfit.metamodels.unit_cube import gauss_newton, spread_points
from grainfit.one_line import OneLine
from grainfit.one_thread import one_thread
from grainfit.problem import Problem

_CANDIDATES = 1024
_REFINED = 32
#: Levels that outline the front, before those in its important part; and the end of that part: all
#: targets missed by five tolerances.
_OUTLINE = 9
_HOPELESS = 25.0
_STEP = 1e-5
#: Rounding error of the logarithm of the time step.
_ROUNDING = 1e-7
#: Smallest difference of misfits that counts, relative or in squared tolerances.
_RELATIVE_GAIN = 1e-3
_ABSOLUTE_GAIN = 1e-4


@dataclass(frozen=True)
class ParetoFront(OneLine):
    """Parameter sets of which none has both a larger time step and a smaller misfit.

    Attributes
    ----------
    time_steps : ndarray, shape (k,)
        Rayleigh time steps, s, smallest first.
    misfits : ndarray, shape (k,)
        Smallest expected sum of squared deviations at such a time step or a larger one, see
        `Metamodels.misfit`: each in units of its tolerance, so that a single target just met
        counts 1.
    parameters : list of dict of str to float
        Parameter sets with these misfits, SI.
    probability_all_met : ndarray, shape (k,)
        Probability that every expected response is within its tolerance.
    responses : ndarray, shape (k, number of targets)
        Expected responses.
    """

    time_steps: Array
    misfits: Array
    parameters: list[dict[str, float]]
    probability_all_met: Array
    responses: Array


def pareto_front(metamodels: Metamodels, *, seed: int = 1, points: int = 25) -> ParetoFront | None:
    """Find the smallest misfit at each Rayleigh time step.

    The misfit is minimised with the time step at or above a level (epsilon-constraint method), for
    levels from the time step of the best fit to the largest one within the intervals. Most levels
    are where the targets are not missed by far.

    Parameters
    ----------
    metamodels : Metamodels
        Of all responses.
    seed : int
        The same seed gives the same front.
    points : int
        Number of levels; the front has at most as many points.

    Returns
    -------
    ParetoFront or None
        None when no free parameter changes the Rayleigh time step, or there is no such time step.

    References
    ----------
    Haimes, Lasdon & Wismer (1971), IEEE Trans. Syst. Man Cybern. 1, 296-297.
    """
    problem = metamodels.problem
    limits = _limits(problem)
    if limits is None:
        return None
    with one_thread():
        search = _Search(metamodels, np.random.default_rng(seed))
        best = search.best_above(-math.inf, None)
        slowest = float(log_time_steps(problem, best[None])[0])
        fastest = math.log(limits[1])
        found = [best]
        outline = np.linspace(slowest, fastest, min(_OUTLINE, points))[1:]
        for level in outline:
            found.append(search.best_above(float(level), found[-1]))
        misfits = metamodels.misfit(np.array(found[1:]))
        hopeless = np.flatnonzero(misfits > _HOPELESS * len(problem.targets))
        end = outline[hopeless[0]] if len(hopeless) else fastest
        between = np.setdiff1d(np.linspace(slowest, end, points - len(outline) + 1)[1:-1], outline)
        previous = best
        for level in between:
            previous = search.best_above(float(level), previous)
            found.append(previous)
        return _front(metamodels, np.array(found))


def _limits(problem: Problem) -> tuple[float, float] | None:
    """Smallest and largest time step; None when they are equal."""
    if problem.rayleigh is None:
        return None
    smallest, largest = problem.rayleigh.limits(problem.intervals)
    return (smallest, largest) if largest - smallest > 1e-12 * largest else None


def _front(metamodels: Metamodels, points: Array) -> ParetoFront:
    problem = metamodels.problem
    steps, misfits = log_time_steps(problem, points), metamodels.misfit(points)
    chosen: list[int] = []
    smallest = math.inf
    for index in np.lexsort((misfits, -steps)):
        gain = max(_RELATIVE_GAIN * smallest, _ABSOLUTE_GAIN) if chosen else 0.0
        if misfits[index] < smallest - gain:
            smallest = float(misfits[index])
            chosen.append(int(index))
    points = points[chosen[::-1]]
    return ParetoFront(
        time_steps=np.exp(steps[chosen[::-1]]),
        misfits=misfits[chosen[::-1]],
        parameters=[problem.from_unit(point) for point in points],
        probability_all_met=metamodels.probability_all_met(points),
        responses=metamodels.predict(points)[0],
    )


class _Search:
    """Minimises the misfit where the time step is at least at a level."""

    def __init__(self, metamodels: Metamodels, random: np.random.Generator) -> None:
        self._metamodels = metamodels
        self._problem = metamodels.problem
        spread = spread_points(_CANDIDATES, self._problem.dimension, random)
        best = spread[np.argsort(metamodels.misfit(spread), kind="stable")[:_REFINED]]
        # Points with the largest time step satisfy every level.
        longest = with_long_steps(self._problem, spread[: _CANDIDATES // 4])
        self._candidates = np.vstack([spread, gauss_newton(metamodels, best), longest])
        self._misfits = metamodels.misfit(self._candidates)
        self._steps = log_time_steps(self._problem, self._candidates)

    def best_above(self, level: float, previous: Array | None) -> Array:
        """Best point with a time step whose logarithm is at least at the level, shape (d,).

        Parameters
        ----------
        level : float
            Logarithm of the time step.
        previous : ndarray, shape (d,), optional
            Answer for a lower level, as a good start.
        """
        complies = np.flatnonzero(self._steps >= level - _ROUNDING)
        best = complies[self._misfits[complies].argmin()]
        point, misfit = self._candidates[best], float(self._misfits[best])
        starts = [point] if previous is None else [previous, point]
        for number, start in enumerate(starts):
            if number and misfit < self._misfits[best]:
                break
            trial = self._descend(start, level)
            value = float(self._metamodels.misfit(trial[None])[0])
            if value < misfit and self._step(trial) >= level - _ROUNDING:
                point, misfit = trial, value
        return np.asarray(point)

    def _step(self, point: Array) -> float:
        return float(log_time_steps(self._problem, point[None])[0])

    def _descend(self, start: Array, level: float) -> Array:
        around = _STEP * np.eye(len(start))

        def logarithm_of_misfit(point: Array) -> tuple[float, Array]:
            # The logarithm is as smooth, and of similar size for good and hopeless fits.
            asked = np.vstack([point, point + around, point - around])
            values = np.log1p(self._metamodels.misfit(asked))
            ahead, behind = np.split(values[1:], 2)
            return float(values[0]), (ahead - behind) / (2.0 * _STEP)

        def room(point: Array) -> float:
            return self._step(point) - level

        def slope_of_room(point: Array) -> Array:
            asked = np.vstack([point + around, point - around])
            # Some parameters, such as Poisson's ratio, have no meaning beyond their bounds.
            inside = np.clip(asked, 0.0, 1.0)
            ahead, behind = np.split(log_time_steps(self._problem, inside), 2)
            width = np.diag(inside[: len(start)] - inside[len(start) :])
            return np.asarray((ahead - behind) / width)

        constraint = {"type": "ineq", "fun": room, "jac": slope_of_room}
        found = optimize.minimize(
            logarithm_of_misfit,
            start,
            jac=True,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * len(start),
            constraints=[constraint] if math.isfinite(level) else [],
            options={"maxiter": 60, "ftol": 1e-8},
        )
        return np.asarray(np.clip(found.x, 0.0, 1.0))
