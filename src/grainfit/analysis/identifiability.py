"""Identifiability: parameters that the tests determine, open ones, and tests to add."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from grainfit.analysis import messages
from grainfit.analysis.intervals import parameter_intervals
from grainfit.analysis.posterior import Posterior
from grainfit.formatting import ends, in_a_row, number, unit_for_people, with_unit
from grainfit.one_line import OneLine
from grainfit.problem import Parameter, Problem
from grainfit.result import ParameterInterval
from grainfit.which_test.determination import DETERMINED, bound_reached, narrowing
from grainfit.which_test.determining_tests import determining_tests, separating_tests
from grainfit.which_test.slopes import nearest_to_median

#: Smallest correlation (or as much information) of two parameters that replace each other.
_STRONG = 0.7
_CLASSES = 8
#: Smallest component of a unit vector with which a parameter takes part in a direction.
_TAKES_PART = 0.3
#: Share of the sample at an end of a ridge.
_END = 0.05
#: A ridge farther from a straight line (share of the cube's edge) is described by three points.
_BENT = 0.1
_VARIANCE_BEFORE = 1.0 / 12.0
#: Parts of an interval, and the share of an even spread below which a part counts as empty.
_PARTS, _EMPTY = 20, 0.1


@dataclass(frozen=True)
class Direction(OneLine):
    """A direction in the unit cube, and the uncertainty along it.

    Attributes
    ----------
    components : dict of str to float
        Unit vector by name of the parameter; the largest component is positive.
    narrowing : float
        Standard deviation along it over that before the tests: 0 when fixed, 1 when the tests gave
        no information.
    determined : bool
        Whether the narrowing is 0.25 or less.
    """

    components: dict[str, float]
    narrowing: float
    determined: bool


@dataclass(frozen=True)
class Identifiability(OneLine):
    """Parameters that the tests determine, and those that they leave open.

    Attributes
    ----------
    directions : tuple of Direction
        Principal directions of the posterior distribution, best determined first.
    narrowing : dict of str to float
        Width of each parameter's 95 % interval over that before the tests, 0 to 1; of logarithms
        for a parameter with ``scale="log"``.
    verdicts : tuple of str
        Sentences; those about open parameters first.
    further_tests : tuple of str
        Sentences about further bulk tests that would determine the open parameters.
    """

    directions: tuple[Direction, ...]
    narrowing: dict[str, float]
    verdicts: tuple[str, ...]
    further_tests: tuple[str, ...]


def assess_identifiability(
    posterior: Posterior,
    problem: Problem,
    answer: Mapping[str, float] | None = None,
    biases: Mapping[str, str] | None = None,
) -> Identifiability:
    """Find the parameters that the tests determine, and those that they leave open.

    Parameters
    ----------
    posterior : Posterior
        A sample of the parameter sets that agree with the measurements.
    problem : Problem
        Has the intervals and units of the parameters.
    answer : mapping of str to float, optional
        The calibrated values, which the intervals hold; see `parameter_intervals`.
    biases : mapping of str to str, optional
        Reasons why parameters are biased, by name.

    Returns
    -------
    Identifiability
    """
    directions = _directions(posterior, posterior.names)
    intervals = parameter_intervals(posterior, problem, answer, biases)
    found = [(p, intervals[p.name]) for p in problem.parameters]
    widths = {p.name: narrowing(p, interval.low, interval.high) for p, interval in found}
    own = {p.name for p in problem.measured}
    groups = _inseparable(posterior, {n: w for n, w in widths.items() if n not in own})
    grouped = {name for group in groups for name in group}
    parameters = {parameter.name: parameter for parameter in problem.parameters}
    alone = sorted((n for n in widths if n not in grouped), key=lambda n: -widths[n])
    is_open = [name for name in alone if widths[name] > DETERMINED and name not in own]
    verdicts = [_verdict_of_group(posterior, parameters, group) for group in groups]
    verdicts += [
        _verdict(posterior, parameters[name], intervals[name], (answer or {}).get(name))
        + _what_would_narrow_it(posterior, name, widths)
        for name in alone
    ]
    return Identifiability(
        directions=directions,
        narrowing=widths,
        verdicts=tuple(verdicts),
        further_tests=(
            *(separating_tests(group, problem.responses) for group in groups),
            *(determining_tests(name, problem.responses) for name in is_open),
        ),
    )


def _directions(posterior: Posterior, names: Sequence[str]) -> tuple[Direction, ...]:
    """Principal directions of the distribution of some parameters, best determined first."""
    if not names:
        return ()
    cloud = posterior.points[:, [posterior.names.index(name) for name in names]]
    eigenvalues, vectors = np.linalg.eigh(np.atleast_2d(np.cov(cloud, rowvar=False)))
    directions = []
    for eigenvalue, vector in zip(eigenvalues, vectors.T, strict=True):
        largest = vector[np.abs(vector).argmax()]
        components = (vector * np.sign(largest)).tolist()
        # Two peaks at opposite bounds are farther apart than an even spread.
        narrowing = min(sqrt(max(float(eigenvalue), 0.0) / _VARIANCE_BEFORE), 1.0)
        directions.append(
            Direction(
                components=dict(zip(names, components, strict=True)),
                narrowing=narrowing,
                determined=narrowing <= DETERMINED,
            )
        )
    return tuple(directions)


# Ridges -------------------------------------------------------------------------------------


def _inseparable(posterior: Posterior, narrowing: dict[str, float]) -> list[tuple[str, ...]]:
    """Groups of parameters that are open individually but determined together."""
    is_open = [name for name in posterior.names if narrowing.get(name, 0.0) > DETERMINED]
    groups: list[set[str]] = []
    for pair in combinations(is_open, 2):
        if _dependence(posterior, *pair) >= _STRONG:
            joined = [group for group in groups if group & set(pair)]
            groups = [group for group in groups if not group & set(pair)]
            groups.append(set(pair).union(*joined))
    # Three or more may be related although no two of them are.
    for direction in _directions(posterior, _spread_out(posterior, is_open)):
        if direction.determined:
            tied = {n for n, share in direction.components.items() if abs(share) >= _TAKES_PART}
            if len(tied) > 2 and not tied <= set[str]().union(*groups):
                groups.append(tied)
    return [tuple(name for name in posterior.names if name in group) for group in groups]


def _spread_out(posterior: Posterior, names: Sequence[str]) -> list[str]:
    """Parameters that are open also by standard deviation, the measure of directions."""
    spread = dict(zip(posterior.names, posterior.points.var(axis=0).tolist(), strict=True))
    return [name for name in names if sqrt(spread[name] / _VARIANCE_BEFORE) > DETERMINED]


def _dependence(posterior: Posterior, first: str, second: str) -> float:
    """Dependence of one parameter on another, on any curve: 0 none, 1 complete.

    The correlation of two normal variates with as much mutual information, from counts in classes
    of equal probability, corrected for chance (Miller & Madow).
    """
    count = len(posterior.points)
    columns = [posterior.names.index(name) for name in (first, second)]
    ranks = rankdata(posterior.points[:, columns], method="ordinal", axis=0) - 1
    classes = (_CLASSES * ranks // count).astype(int)
    shares = np.zeros((_CLASSES, _CLASSES))
    np.add.at(shares, (classes[:, 0], classes[:, 1]), 1.0 / count)
    expected = np.outer(shares.sum(axis=1), shares.sum(axis=0))
    filled = shares > 0.0
    information = float((shares[filled] * np.log(shares[filled] / expected[filled])).sum())
    by_chance = (_CLASSES - 1) ** 2 / (2.0 * max(posterior.effective_samples, 1.0))
    return sqrt(-float(np.expm1(-2.0 * max(information - by_chance, 0.0))))


def _stops(posterior: Posterior, group: Sequence[str]) -> NDArray[np.intp]:
    """Members of the sample at both ends of a ridge, and in its middle when it is bent.

    The sample is cut across its principal direction. Of each slice, the member nearest to the
    medians is returned: it lies on the ridge even if the ridge is a ring.
    """
    cloud = posterior.points[:, [posterior.names.index(name) for name in group]]
    _, vectors = np.linalg.eigh(np.cov(cloud, rowvar=False))
    along = vectors[:, -1] * np.sign(vectors[np.abs(vectors[:, -1]).argmax(), -1])
    order = np.argsort(cloud @ along, kind="stable")
    size = max(int(_END * len(order)), 1)
    middle = (len(order) - size) // 2
    slices = (order[:size], order[middle : middle + size], order[-size:])
    start, between, end = (nearest_to_median(cloud, members) for members in slices)
    way = cloud[end] - cloud[start]
    share = (cloud[between] - cloud[start]) @ way / max(float(way @ way), 1e-300)
    aside = np.abs(cloud[between] - cloud[start] - share * way).max()
    return np.array([start, between, end] if aside > _BENT else [start, end])


# Words --------------------------------------------------------------------------------------


def _verdict_of_group(
    posterior: Posterior, parameters: dict[str, Parameter], group: tuple[str, ...]
) -> str:
    stops = _stops(posterior, group)
    values = {name: posterior.values[stops, posterior.names.index(name)] for name in group}
    names = in_a_row(group)
    if len(group) == 2:
        along = ", ".join(
            _with_unit(f"{name} {' → '.join(map(_shown, values[name]))}", parameters[name])
            for name in group
        )
        return messages.PAIRS_FIT(names=names, along=along)
    sets = (
        ", ".join(_with_unit(f"{n} {_shown(values[n][stop])}", parameters[n]) for n in group)
        for stop in range(len(stops))
    )
    return messages.SETS_FIT(names=names, sets=" fits as well as ".join(sets))


def _verdict(
    posterior: Posterior, parameter: Parameter, found: ParameterInterval, answer: float | None
) -> str:
    name = parameter.name
    between = _with_unit(ends(found.low, found.high), parameter)
    if parameter.measured is not None:
        return messages.KNOWN_BY_ITSELF(name=name, between=between)
    if found.determination == "not determined":
        if parts := _parts_that_fit(posterior, parameter):
            return messages.PARTS_FIT(name=name, parts=parts)
        return messages.NOT_DETERMINED(name=name, between=between)
    bound = bound_reached(parameter, found)
    but = messages.UP_TO_BOUND(bound=bound) if bound else ""
    but += messages.BUT_BIASED(bias=found.bias) if found.bias else ""
    if found.determination == "narrowed":
        return messages.NARROWED(name=name, between=between, but=but)
    value = posterior.median(name) if answer is None else answer
    if share := found.percentage(value):
        return messages.DETERMINED_TO(name=name, share=share, between=between, but=but)
    return messages.DETERMINED(name=name, between=between, but=but)


def _parts_that_fit(posterior: Posterior, parameter: Parameter) -> str:
    """Return the ranges of a parameter that fit, where there are several."""
    ranges = _occupied(posterior, parameter)
    parts = " or ".join(f"{_shown(low)} to {_shown(high)}" for low, high in ranges)
    return _with_unit(parts, parameter) if len(ranges) > 1 else ""


def _occupied(posterior: Posterior, parameter: Parameter) -> list[tuple[float, float]]:
    """Ranges of a parameter's interval that contain a part of the distribution."""
    position = posterior.points[:, posterior.names.index(parameter.name)]
    counts, edges = np.histogram(position, bins=_PARTS, range=(0.0, 1.0))
    filled = np.concatenate([[False], counts > _EMPTY * len(position) / _PARTS, [False]])
    starts, ends = (
        np.flatnonzero(filled[1:] & ~filled[:-1]),
        np.flatnonzero(~filled[1:] & filled[:-1]),
    )
    return [
        (parameter.from_unit(edges[start]), parameter.from_unit(edges[end]))
        for start, end in zip(starts, ends, strict=True)
    ]


def _what_would_narrow_it(posterior: Posterior, name: str, narrowing: dict[str, float]) -> str:
    """Name the open parameters on which a determined one depends."""
    if narrowing[name] > DETERMINED:
        return ""
    tied = [
        other
        for other in posterior.names
        if narrowing[other] > DETERMINED and _dependence(posterior, name, other) >= _STRONG
    ]
    return f" {messages.KNOWN_BETTER_IF(others=' or '.join(tied))}" if tied else ""


def _with_unit(text: str, parameter: Parameter) -> str:
    return with_unit(text, unit_for_people(parameter.unit))


def _shown(value: float) -> str:
    return number(value, 3)
