"""Find targets that no parameter set within the intervals meets, and the bound in the way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grainfit.contact_models.registry import material_parameter
from grainfit.formatting import rounded_off, value_with_unit
from grainfit.metamodels.curve_reduction import CurveBasis
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import shrinking_search, spread_points
from grainfit.problem import CurveTarget, Parameter, Problem, Target
from grainfit.strategies import messages
from grainfit.strategies.feasibility import FeasibilityModel
from grainfit.verdict.out_of_reach import CurveMiss, OutOfReach

#: Standard errors by which a target must be missed beyond its tolerance to be out of reach.
STANDARD_ERRORS = 2.0
_AT_BOUND = 0.01
#: Extra width of a suggested interval, as a share of the missing deviation.
_MARGIN = 1.15
#: Interval widths from the middle up to which a linear extrapolation is suggested.
_FARTHEST = 3.0
#: Points of a curve that are named.
_MOST_POINTS = 3
_STARTS = 64


def out_of_reach(
    metamodels: Metamodels,
    optimum: NDArray[np.float64],
    feasibility: FeasibilityModel,
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
    feasibility : FeasibilityModel
        A target that is met only where runs fail is out of reach.
    seed : int
        Decides the starts of the search for the nearest response.
    standard_errors : float
        Number of standard errors by which a target must be missed beyond its tolerance.
    """
    alone, together = [], []
    for group in _groups(metamodels):
        if not _is_missed(metamodels, group, optimum, standard_errors):
            continue
        anywhere = _nearest(metamodels, group, seed)
        nearest_point = _where_runs_succeed(metamodels, group, anywhere, feasibility, seed)
        if _is_missed(metamodels, group, nearest_point, standard_errors):
            miss = _describe(metamodels, group, nearest_point, False)
            fails = nearest_point is not anywhere
            alone.append(replace(miss, runs_fail_nearer=fails))
        else:
            together.append(_describe(metamodels, group, optimum, True))
    # A target missed only together with such a target may be met once that one is met.
    return tuple(alone or together)


@dataclass(frozen=True)
class _Group:
    """A target, or all components of a curve, by their indices."""

    indices: Sequence[int]
    basis: CurveBasis | None = None


def _groups(metamodels: Metamodels) -> Iterator[_Group]:
    names = [target.name for target in metamodels.problem.targets]
    bases = metamodels.reduction.bases
    components = {name for basis in bases for name in basis.names}
    yield from (_Group([i]) for i, name in enumerate(names) if name not in components)
    yield from (_Group([names.index(name) for name in basis.names], basis) for basis in bases)


def _is_missed(
    metamodels: Metamodels, group: _Group, point: NDArray[np.float64], standard_errors: float
) -> bool:
    """Return whether an expected response at a point is off by more than its errors explain."""
    means, variances = metamodels.predict(point)
    off = _off(metamodels, group, means[0])
    margins = standard_errors * np.sqrt(variances[0, group.indices])
    tolerances = [metamodels.problem.targets[i].tolerance for i in group.indices]
    return bool((np.abs(off) > tolerances + margins).any())


def _off(metamodels: Metamodels, group: _Group, means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the deviations of responses from the targets of a group."""
    return np.array([means[i] - metamodels.problem.targets[i].value for i in group.indices])


def _nearest(metamodels: Metamodels, group: _Group, seed: int) -> NDArray[np.float64]:
    """Point at which the responses of a group are nearest to their targets."""
    # Loaded late: most targets are within reach.
    from scipy.optimize import minimize

    dimension = metamodels.problem.dimension
    pairs = _pairs(metamodels, group)

    def squared(point: NDArray[np.float64]) -> float:
        return float((_misfits(pairs, point[None]) ** 2).sum())

    def slope(point: NDArray[np.float64]) -> NDArray[np.float64]:
        slopes = [model.gradients(point[None])[0] / target.misfit_unit for model, target in pairs]
        return np.asarray(2 * _misfits(pairs, point[None])[0] @ np.array(slopes))

    starts = maximin_latin_hypercube(8, dimension, seed)
    ends = [
        minimize(squared, start, jac=slope, bounds=[(0, 1)] * dimension, method="L-BFGS-B").x
        for start in starts
    ]
    return np.asarray(min(ends, key=squared))


def _where_runs_succeed(
    metamodels: Metamodels,
    group: _Group,
    nearest: NDArray[np.float64],
    feasibility: FeasibilityModel,
    seed: int,
) -> NDArray[np.float64]:
    """Point nearest to the targets at which runs succeed: the nearest of all, if they do there."""
    if feasibility.is_likely(nearest[None])[0]:
        return nearest
    pairs, random = _pairs(metamodels, group), np.random.default_rng(seed)

    def misfit(points: NDArray[np.float64]) -> NDArray[np.float64]:
        squares = (_misfits(pairs, points) ** 2).sum(axis=1)
        return np.where(feasibility.is_likely(points), squares, np.inf)

    starts = spread_points(_STARTS, metamodels.problem.dimension, random)
    return np.asarray(shrinking_search(misfit, starts, random, rounds=6)[0][0])


def _pairs(metamodels: Metamodels, group: _Group) -> list[tuple[Kriging, Target]]:
    return [(metamodels.models[i], metamodels.problem.targets[i]) for i in group.indices]


def _misfits(
    pairs: Sequence[tuple[Kriging, Target]], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Expected misfits at points, shape (m, number of pairs)."""
    off = [(model.predict(points).mean - t.value) / t.misfit_unit for model, t in pairs]
    return np.column_stack(off)


def _describe(
    metamodels: Metamodels, group: _Group, point: NDArray[np.float64], jointly: bool
) -> OutOfReach:
    means, variances = metamodels.predict(point)
    off = _off(metamodels, group, means[0])
    tolerances = [metamodels.problem.targets[i].tolerance for i in group.indices]
    worst = int(np.argmax(np.abs(off) / tolerances))
    index, missing = group.indices[worst], -float(off[worst])
    if group.basis is not None:
        scores, errors = means[0, group.indices], variances[0, group.indices]
        miss = _miss_of_curve(group.basis, scores, errors, jointly)
    else:
        target, error = metamodels.problem.targets[index], float(np.sqrt(variances[0, index]))
        nearest = float(means[0, index])
        basics = (target.name, target.value, nearest, error, jointly)
        miss = OutOfReach(*basics, is_relative=target.is_relative, unit=target.unit)
    slopes = metamodels.models[index].gradients(point[None])[0]
    blocked = list(_blocking(point, slopes * np.sign(missing)))
    if not blocked:
        return miss
    axis = max(blocked, key=lambda j: abs(slopes[j]))
    parameter = metamodels.problem.parameters[axis]
    upper = bool(point[axis] > 0.5)
    bound = parameter.maximum if upper else parameter.minimum
    position = float(point[axis] + _MARGIN * missing / slopes[axis])
    return replace(
        miss,
        parameter=parameter.name,
        parameter_unit=parameter.unit,
        bound="max" if upper else "min",
        bound_value=bound,
        suggestion=_suggestion(parameter, position, bound, upper),
    )


def _miss_of_curve(
    basis: CurveBasis,
    scores: NDArray[np.float64],
    variances: NDArray[np.float64],
    jointly: bool,
) -> OutOfReach:
    """Return where an expected curve deviates most from the measured one."""
    measured = basis.target
    expected, errors = basis.expected(scores, variances)
    miss = miss_of(measured, np.asarray(measured.values), expected)
    place, value, nearest = miss.points[0]
    return OutOfReach(
        measured.name,
        value,
        nearest,
        float(errors[measured.coordinates.index(place)]),
        jointly,
        is_relative=False,
        curve=replace(miss, has_other_shape=basis.has_other_shape),
    )


def miss_of(
    measured: CurveTarget, wanted: NDArray[np.float64], found: NDArray[np.float64]
) -> CurveMiss:
    """Return how far a curve is from another one, and at which points most.

    Parameters
    ----------
    measured : CurveTarget
        The measured curve, of n points, whose uncertainties are the measure.
    wanted, found : ndarray, shape (n,)
        Both curves at its coordinates.
    """
    off = (found - wanted) / measured.standard_uncertainties
    worst = np.argsort(-np.abs(off), kind="stable")[:_MOST_POINTS].tolist()
    return CurveMiss(
        measured.coordinate,
        measured.coordinate_unit,
        float(np.sqrt((off**2).mean())),
        tuple((float(measured.coordinates[i]), float(wanted[i]), float(found[i])) for i in worst),
    )


def _blocking(point: NDArray[np.float64], gain: NDArray[np.float64]) -> Iterator[int]:
    """Axes on a bound of which the point lies while the response still improves beyond it."""
    relevant = 0.1 * np.abs(gain).max()
    for axis, (position, slope) in enumerate(zip(point, gain, strict=True)):
        if (position > 1 - _AT_BOUND and slope > relevant) or (
            position < _AT_BOUND and slope < -relevant
        ):
            yield axis


def _suggestion(parameter: Parameter, position: float, bound: float, upper: bool) -> float | None:
    """Bound to try, or None where linear extrapolation fails or physics sets a limit."""
    if abs(position - 0.5) > _FARTHEST:
        return None
    value = rounded_off(parameter.from_unit(position), 3, up=upper)
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
    """Return messages that say which bounds were moved."""
    return [
        messages.BOUND_MOVED(
            bound=f"{old.name}.{key}",
            was=value_with_unit(was, old.unit),
            now=value_with_unit(now, old.unit),
        )
        for old, new in zip(before.parameters, after.parameters, strict=True)
        for key, was, now in (
            ("min", old.minimum, new.minimum),
            ("max", old.maximum, new.maximum),
        )
        if was != now
    ]
