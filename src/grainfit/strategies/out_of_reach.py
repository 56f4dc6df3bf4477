"""Find targets that no parameter set within the intervals meets, and the bound in the way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import floor, log10

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from grainfit.contact_models.registry import material_parameter
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Parameter, Problem, Target
from grainfit.result import OutOfReach

#: Standard errors by which a target must be missed beyond its tolerance to be out of reach.
STANDARD_ERRORS = 2.0
_AT_BOUND = 0.01
#: Extra width of a suggested interval, as a share of the missing deviation.
_MARGIN = 1.15
#: Interval widths from the middle up to which a linear extrapolation is suggested.
_FARTHEST = 3.0


def out_of_reach(
    metamodels: Metamodels,
    optimum: NDArray[np.float64],
    seed: int,
    standard_errors: float = STANDARD_ERRORS,
) -> tuple[OutOfReach, ...]:
    """Find the targets that cannot be met within the intervals.

    Parameters
    ----------
    metamodels : Metamodels
        Fitted on the runs so far.
    optimum : ndarray, shape (d,)
        Point at which the misfit is smallest.
    seed : int
        Decides the starts of the search for the nearest response.
    standard_errors : float
        Number of standard errors by which a target must be missed beyond its tolerance.
    """
    means, variances = metamodels.predict(optimum)
    alone, together = [], []
    for index, target in enumerate(metamodels.problem.targets):
        error = float(np.sqrt(variances[0, index]))
        if not _misses(target, float(means[0, index]), standard_errors * error):
            continue
        nearest_point = _nearest(metamodels, index, seed)
        own_mean, own_variance = metamodels.predict(nearest_point)
        own, own_error = float(own_mean[0, index]), float(np.sqrt(own_variance[0, index]))
        if _misses(target, own, standard_errors * own_error):
            alone.append(_describe(metamodels, index, nearest_point, own, own_error, False))
        else:
            mean = float(means[0, index])
            together.append(_describe(metamodels, index, optimum, mean, error, True))
    # A target missed only together with such a target may be met once that one is met.
    return tuple(alone or together)


def _misses(target: Target, mean: float, margin: float) -> bool:
    return abs(mean - target.value) > target.tolerance + margin


def _nearest(metamodels: Metamodels, index: int, seed: int) -> NDArray[np.float64]:
    """Point at which one response is nearest to its target."""
    model = metamodels.models[index]
    target = metamodels.problem.targets[index].value
    dimension = metamodels.problem.dimension

    def squared(point: NDArray[np.float64]) -> float:
        return float((model.predict(point[None]).mean[0] / target - 1) ** 2)

    def slope(point: NDArray[np.float64]) -> NDArray[np.float64]:
        deviation = float(model.predict(point[None]).mean[0]) / target - 1
        return np.asarray(2 * deviation / target * model.gradients(point[None])[0])

    starts = maximin_latin_hypercube(8, dimension, seed)
    ends = [
        minimize(squared, start, jac=slope, bounds=[(0, 1)] * dimension, method="L-BFGS-B").x
        for start in starts
    ]
    return np.asarray(min(ends, key=squared))


def _describe(
    metamodels: Metamodels,
    index: int,
    point: NDArray[np.float64],
    nearest: float,
    error: float,
    jointly: bool,
) -> OutOfReach:
    target = metamodels.problem.targets[index]
    basics = (target.name, target.value, nearest, error, jointly)
    slopes = metamodels.models[index].gradients(point[None])[0]
    missing = target.value - nearest
    blocked = list(_blocking(point, slopes * np.sign(missing)))
    if not blocked:
        return OutOfReach(*basics, is_relative=target.is_relative)
    axis = max(blocked, key=lambda j: abs(slopes[j]))
    parameter = metamodels.problem.parameters[axis]
    upper = bool(point[axis] > 0.5)
    bound = parameter.maximum if upper else parameter.minimum
    position = float(point[axis] + _MARGIN * missing / slopes[axis])
    return OutOfReach(
        *basics,
        parameter=parameter.name,
        bound="max" if upper else "min",
        bound_value=bound,
        suggestion=_suggestion(parameter, position, bound, upper),
        is_relative=target.is_relative,
    )


def _blocking(point: NDArray[np.float64], gain: NDArray[np.float64]) -> Iterator[int]:
    """Axes on a bound of which the point lies while the response still improves beyond it."""
    relevant = 0.1 * np.abs(gain).max()
    for axis, (position, slope) in enumerate(zip(point, gain, strict=True)):
        if (position > 1 - _AT_BOUND and slope > relevant) or (
            position < _AT_BOUND and slope < -relevant
        ):
            yield axis


def _round_outward(value: float, upward: bool) -> float:
    """Round to three digits, away from the interval."""
    if value == 0:
        return 0.0
    unit = 10.0 ** (floor(log10(abs(value))) - 2)
    steps = np.ceil(value / unit) if upward else np.floor(value / unit)
    return float(f"{steps * unit:.6g}")


def _suggestion(parameter: Parameter, position: float, bound: float, upper: bool) -> float | None:
    """Bound to try, or None where linear extrapolation fails or physics sets a limit."""
    if abs(position - 0.5) > _FARTHEST:
        return None
    value = _round_outward(parameter.from_unit(position), upper)
    return _within_physics(parameter.name, value, bound, upper)


def _within_physics(name: str, value: float, bound: float, upper: bool) -> float | None:
    """Physically possible suggestion, or None if the bound is already at the limit."""
    known = material_parameter(name)
    if known is None:
        return value
    possible = min(value, known.highest) if upper else max(value, known.lowest)
    return None if possible == bound else possible


def widened(problem: Problem, misses: Iterable[OutOfReach]) -> Problem:
    """Return the problem with every bound in the way moved to the suggested value.

    Parameters
    ----------
    problem : Problem
        Problem whose intervals are too narrow.
    misses : iterable of OutOfReach
        Targets out of reach; those without a suggested bound change nothing.
    """
    bounds = {p.name: (p.minimum, p.maximum) for p in problem.parameters}
    for miss in misses:
        if miss.parameter is None or miss.suggestion is None:
            continue
        low, high = bounds[miss.parameter]
        bounds[miss.parameter] = (min(low, miss.suggestion), max(high, miss.suggestion))
    parameters = [_with_bounds(p, *bounds[p.name]) for p in problem.parameters]
    return replace(problem, parameters=parameters)


def _with_bounds(parameter: Parameter, low: float, high: float) -> Parameter:
    # A parameter that was positive everywhere stays positive: no material has negative friction.
    if low <= 0 < parameter.minimum:
        low = parameter.minimum
    return replace(parameter, minimum=low, maximum=high)


def widenings(before: Problem, after: Problem) -> list[str]:
    """Say in words which bounds were moved."""
    return [
        f"{old.name}.{key} = {was:g} was in the way and has been moved to {now:g}."
        for old, new in zip(before.parameters, after.parameters, strict=True)
        for key, was, now in (
            ("min", old.minimum, new.minimum),
            ("max", old.maximum, new.maximum),
        )
        if was != now
    ]
