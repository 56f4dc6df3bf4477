"""Parameters that agree with the measurements by the atlas alone, before any simulation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array
from grainfit.atlas import messages
from grainfit.atlas.forecast import Forecast, values_at
from grainfit.atlas.shelf import Atlas, shipped_atlas
from grainfit.atlas.strata import strata
from grainfit.bulk_tests.abilities import options_for
from grainfit.bulk_tests.accuracy import Accuracy, usual_accuracy
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.errors import InputError
from grainfit.formatting import duration, ends, in_a_row, number, unit_for_people, with_unit
from grainfit.metamodels.credible_interval import extended_to_bounds
from grainfit.metamodels.importance_sampling import (
    importance_sample,
    representatives,
    weighted_quantiles,
)
from grainfit.metamodels.likelihood import Likelihood, log_prior
from grainfit.metamodels.unit_cube import spread_points
from grainfit.one_line import OneLine
from grainfit.one_thread import one_thread
from grainfit.problem import Parameter, Problem, Target
from grainfit.solvers.base import Solver
from grainfit.solvers.dem.program import DeckSolver
from grainfit.tables import Summary, TextTable
from grainfit.verdict.options import VERDICT
from grainfit.verdict.out_of_reach import bound_at

_SHARES = (0.025, 0.5, 0.975)
#: An interval that keeps this share of the given one leaves a parameter open.
_OPEN = 0.5
#: Width of an interval over the present one below which a measurement is worth naming, and points
#: of the sample that show it.
_NARROWS, _REPRESENTATIVES = 0.85, 400
#: Standard errors within which a target can be met, and points all over that show whether any does.
_REACH, _SPREAD = 2.5, 512
#: Of the density where the atlas has no rows, to its logarithm.
_NOWHERE = -100.0
#: Runs of a test that nobody makes.
_MOST_RUNS = 1000


@dataclass(frozen=True)
class EstimatedParameter:
    """A free parameter by the atlas.

    Parameters
    ----------
    parameter : Parameter
        With the interval that was given.
    low, median, high : float
        95 % interval and median, SI.
    is_open : bool
        Whether the interval is no narrower than half of the one that was given.
    """

    parameter: Parameter
    low: float
    median: float
    high: float
    is_open: bool


@dataclass(frozen=True)
class EstimatedResponse:
    """A response at the estimate.

    Parameters
    ----------
    target : Target
        The measured value.
    value, standard_error : float
        Expected response at the most probable parameters, and its standard error by the atlas.
    scatter : float
        Standard deviation of a run.
    miss : float
        By how much all parameters within the intervals miss the measured value; 0 where some give
        it.
    """

    target: Target
    value: float
    standard_error: float
    scatter: float
    miss: float

    @property
    def is_in_reach(self) -> bool:
        """Whether some parameters within the intervals give the measured value."""
        return self.agrees or self.miss == 0

    @property
    def agrees(self) -> bool:
        """Whether the measured value is met there within the errors of both."""
        return bool(self._off <= _reach(self.target.tolerance, self.standard_error))

    @property
    def is_met(self) -> bool:
        """Whether the measured value is met there within its tolerance."""
        return self._off <= self.target.tolerance

    def runs_needed(self, *, at_bound: bool) -> int:
        """Return the number of runs after which it is known whether the target is met.

        Their mean has a 95 % interval within the tolerance, or is known to be at its edge.

        Parameters
        ----------
        at_bound : bool
            Whether an interval keeps the search from parameters that come nearer.
        """
        tolerance = self.target.tolerance
        off = self._off if at_bound else 0.0
        room = max(tolerance - off, 2 * VERDICT.known_edge * tolerance)
        return max(VERDICT.fresh_seeds, math.ceil((2 * self.scatter / room) ** 2))

    @property
    def _off(self) -> float:
        return abs(self.value - self.target.value)


@dataclass(frozen=True)
class Estimate(Summary, OneLine):
    """Parameters that agree with the measurements by the atlas: nothing was simulated for them.

    Parameters
    ----------
    parameters : tuple of EstimatedParameter
        With their 95 % intervals.
    responses : tuple of EstimatedResponse
        Of the targets that the atlas tells about.
    best : mapping of str to float
        Most probable parameters, SI.
    untold : mapping of str to str
        Why the atlas tells nothing about other targets.
    less_sure : mapping of str to str
        By target, which dimensions of its apparatus are beyond those of the atlas.
    left_out : tuple of str
        What parts of the intervals the atlas has no rows of: the estimate is of the rest.
    chance : float
        Chance that a run at the most probable parameters has all responses.
    runs : int
        Expected number of runs of each test that a calibration verifies it with.
    seconds : float, optional
        Their expected computing time on one core, s.
    further : tuple of FurtherMeasurement
        What measurements that were not made would settle, in the usual apparatus.
    points, weights : ndarray
        Sample of the parameters, shape (n, d), in the unit cube, and its weights.
    doubts : tuple of str
        Measured values that are impossible, and what may be wrong with them.
    """

    parameters: tuple[EstimatedParameter, ...]
    responses: tuple[EstimatedResponse, ...]
    best: Mapping[str, float]
    untold: Mapping[str, str]
    less_sure: Mapping[str, str]
    left_out: tuple[str, ...]
    chance: float
    runs: int
    seconds: float | None
    further: tuple[FurtherMeasurement, ...]
    points: Array
    weights: Array
    doubts: tuple[str, ...] = ()

    @property
    def out_of_reach(self) -> tuple[str, ...]:
        """Names of the targets that no parameters within the intervals meet."""
        return tuple(one.target.name for one in self.responses if not one.is_in_reach)

    @property
    def at_odds(self) -> tuple[str, ...]:
        """Names of the targets that some parameters meet, but none that meet the others, too."""
        every = self.responses
        return tuple(one.target.name for one in every if one.is_in_reach and not one.agrees)

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the tables and the sentences that `print` and a notebook show."""
        return (
            messages.NOT_SIMULATED(),
            # Before the tables, which mean little then.
            *self.doubts,
            *(messages.OUT_OF_REACH(response=name) for name in self.out_of_reach),
            *(messages.AT_ODDS(response=name) for name in self.at_odds),
            TextTable(
                ("parameter", "most probable", "95 % interval", "given"),
                tuple(self._parameter_row(one) for one in self.parameters),
            ),
            TextTable(
                ("response", "expected", "measured", "scatter of a run"),
                tuple(_response_row(one) for one in self.responses),
                messages.ERRORS(),
            ),
            *self._sentences(),
        )

    def lines(self) -> Iterator[str]:
        """Yield in a sentence each that nothing was simulated, and every parameter."""
        yield messages.NOT_SIMULATED()
        for one in self.parameters:
            name, value, interval, _ = self._parameter_row(one)
            yield messages.ESTIMATED(name=name, value=value, interval=interval)

    def most_telling(self, name: str) -> FurtherMeasurement | None:
        """Return the further measurement that narrows a parameter most; None if none does."""
        best = min(self.further, key=lambda one: one.left[name], default=None)
        return best if best is not None and best.left[name] < _NARROWS else None

    @property
    def _on_bounds(self) -> list[str]:
        """Names of the parameters whose most probable value is on an end of its interval."""
        every = [one.parameter for one in self.parameters]
        return [one.name for one in every if bound_at(one.to_unit(self.best[one.name]))]

    def _parameter_row(self, one: EstimatedParameter) -> tuple[str, ...]:
        unit = unit_for_people(one.parameter.unit)
        given = ends(one.parameter.minimum, one.parameter.maximum)
        return (
            one.parameter.name,
            with_unit(number(self.best[one.parameter.name], 3), unit),
            with_unit(ends(one.low, one.high), unit),
            with_unit(given, unit),
        )

    def _sentences(self) -> Iterator[str]:
        off = [one.target.name for one in self.responses if one.agrees and not one.is_met]
        if off and (on_bounds := self._on_bounds):
            yield messages.BEYOND_BOUND(responses=in_a_row(off), names=in_a_row(on_bounds))
        if still := [one.parameter.name for one in self.parameters if one.is_open]:
            yield messages.OPEN(names=", ".join(still))
        for name in still:
            if (best := self.most_telling(name)) is not None:
                yield messages.WOULD_NARROW(
                    name=name,
                    response=best.response,
                    test=best.test,
                    accuracy=best.accuracy.in_words(
                        bulk_tests()[best.test].responses[best.response].unit
                    ),
                    left=100 * best.left[name],
                )
        if self.chance < 0.5:
            yield messages.MAY_FAIL(chance=100 * self.chance)
        for names, why in _by_reason(self.untold):
            yield messages.UNTOLD(responses=names, why=why)
        for names, why in _by_reason(self.less_sure):
            yield f"{names}: {why}"
        yield from self.left_out
        if self.out_of_reach or self.at_odds:
            return
        if self.runs > _MOST_RUNS:
            widest = max(self.responses, key=lambda one: one.scatter / one.target.tolerance)
            yield messages.TOO_MANY_RUNS(
                response=widest.target.name,
                times=number(widest.scatter / widest.target.tolerance, 2),
                most=_MOST_RUNS,
            )
            return
        time = "" if self.seconds is None else f", {duration(self.seconds)} on one core"
        yield messages.TO_VERIFY(runs=self.runs, time=time)


def _response_row(one: EstimatedResponse) -> tuple[str, ...]:
    target, unit = one.target, unit_for_people(one.target.unit)
    return (
        target.name,
        with_unit(f"{number(one.value, 4)} ± {number(one.standard_error, 2)}", unit),
        with_unit(f"{number(target.value, 4)} ± {number(target.tolerance, 2)}", unit),
        with_unit(number(one.scatter, 2), unit),
    )


@one_thread()
def estimate_of(
    problem: Problem, solvers: Mapping[str, Solver], atlas: Atlas | None = None, seed: int = 1
) -> Estimate:
    """Estimate the parameters that agree with the targets, by the atlas alone.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test.
    atlas : Atlas, optional
        By default the one that ships with the package.
    seed : int
        Decides the sample.

    Raises
    ------
    InputError
        The atlas tells nothing about any target; the reasons are named.
    """
    forecast = Forecast(problem, solvers, atlas)
    if forecast.problem is None:
        reasons = "; ".join(f"{names}: {why}" for names, why in _by_reason(forecast.untold))
        raise InputError(messages.NOTHING_TOLD.fault("", reasons=reasons))
    everywhere = spread_points(_SPREAD, problem.dimension, np.random.default_rng(seed))
    likelihood = Likelihood(forecast.problem)
    misses = _misses(forecast, forecast.problem, everywhere)

    def log_density(points: Array) -> Array:
        means, variances = forecast.predict(points)
        found = likelihood.logarithms(means, variances + misses**2, forecast.correlation)
        found = found + np.where(forecast.is_inside(points), 0.0, _NOWHERE)
        return np.asarray(found + log_prior(problem, points) + np.log(forecast.chance(points)))

    sample = importance_sample(log_density, problem.dimension, np.random.default_rng(seed))
    logarithms = log_density(sample.points)
    weights = sample.weights(logarithms)
    top = sample.points[[int(np.argmax(logarithms))]]
    means, variances = forecast.predict(top)
    scatters = forecast.scatter(top)[0]
    responses = tuple(
        EstimatedResponse(target, float(mean), math.sqrt(variance), float(scatter), float(miss))
        for target, mean, variance, scatter, miss in zip(
            forecast.problem.targets,
            forecast.possible(means)[0],
            variances[0],
            scatters,
            misses,
            strict=True,
        )
    )
    best = {name: float(found[0]) for name, found in values_at(problem.parameters, top).items()}
    at_bound = any(bound_at(float(share)) for share in top[0])
    runs = max(one.runs_needed(at_bound=at_bound) for one in responses)
    even = representatives(sample.points, weights, _REPRESENTATIVES, np.random.default_rng(seed))
    further = further_measurements(problem, solvers, even, atlas or shipped_atlas())
    return Estimate(
        parameters=tuple(_intervals(problem, sample.points, weights)),
        responses=responses,
        best=best,
        untold=forecast.untold,
        less_sure=forecast.less_sure,
        left_out=tuple(forecast.left_out(everywhere)),
        chance=float(forecast.chance(top)[0]),
        runs=runs,
        seconds=_seconds(solvers, best, runs),
        further=tuple(further),
        points=sample.points,
        weights=weights,
    )


def _reach(tolerance: ArrayLike, standard_error: ArrayLike) -> Array:
    """Return how far a measured value may be off and is met within the errors of both."""
    return np.hypot(tolerance, _REACH * np.asarray(standard_error))


def _misses(forecast: Forecast, problem: Problem, points: Array) -> Array:
    """Return by how much all parameters miss each target, shape (targets,); 0 of one in reach.

    As an error it makes the parameters count that come nearest, and not those of which least is
    known.
    """
    points = points[forecast.is_inside(points)]
    if not len(points):
        return np.zeros(len(problem.targets))
    means, variances = forecast.predict(points)
    off = np.abs(means - [target.value for target in problem.targets])
    within = _reach([target.tolerance for target in problem.targets], np.sqrt(variances))
    return np.where((off > within).all(axis=0), off.min(axis=0), 0.0)


def _by_reason(untold: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the targets that share a reason, with it."""
    for why in dict.fromkeys(untold.values()):
        yield in_a_row(name for name, own in untold.items() if own == why), why


def _intervals(problem: Problem, points: Array, weights: Array) -> Iterator[EstimatedParameter]:
    for axis, parameter in enumerate(problem.parameters):
        low, middle, high = weighted_quantiles(points[:, axis], weights, _SHARES)
        low, high = (float(end) for end in extended_to_bounds(low, high))
        ends = [parameter.from_unit(share) for share in (low, high)]
        median = parameter.from_unit(float(middle))
        yield EstimatedParameter(parameter, ends[0], median, ends[1], high - low > _OPEN)


def _seconds(
    solvers: Mapping[str, Solver], parameters: Mapping[str, float], runs: int
) -> float | None:
    costs = [solver.estimate_cost(parameters) for solver in solvers.values()]
    known = [cost.wall_seconds for cost in costs if cost is not None]
    return runs * sum(known) if len(known) == len(costs) else None


@dataclass(frozen=True)
class FurtherMeasurement:
    """A measurement that was not made, in the usual apparatus.

    Parameters
    ----------
    test, response : str
        What would be measured.
    accuracy : Accuracy
        With which a laboratory usually measures it.
    left : mapping of str to float
        Expected width of the interval of every free parameter, over the present one.
    """

    test: str
    response: str
    accuracy: Accuracy
    left: Mapping[str, float]


def further_measurements(
    problem: Problem, solvers: Mapping[str, Solver], points: Array, atlas: Atlas
) -> list[FurtherMeasurement]:
    """Return the measurements of which the atlas tells that were not made.

    A response that correlates with a parameter over the present sample narrows it by as much as a
    linear regression explains beside the errors of measurement and atlas.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test.
    points : ndarray, shape (m, d)
        An even sample of the present knowledge, in the unit cube.
    atlas : Atlas
        The atlas.
    """
    known = [one for one in solvers.values() if isinstance(one, DeckSolver)]
    if not known:
        return []
    made = {
        (solver.bulk_test.type, target.name.removeprefix(f"{name}."))
        for name, solver in solvers.items()
        if solver.bulk_test is not None
        for target in problem.targets
    }
    found: list[FurtherMeasurement] = []
    for test in dict.fromkeys(strata()[name].kind.type for name in atlas.strata):
        found += _of_test(test, made, problem, known[0], points, atlas)
    return found


def _of_test(
    test: str,
    made: set[tuple[str, str]],
    problem: Problem,
    solver: DeckSolver,
    points: Array,
    atlas: Atlas,
) -> Iterator[FurtherMeasurement]:
    kind = bulk_tests()[test]
    names = [name for name in kind.responses if (test, name) not in made]
    forecast = _forecast(test, names, problem, solver, atlas)
    if forecast is None or forecast.problem is None:
        return
    means, variances = forecast.predict(points)
    for axis, target in enumerate(forecast.problem.targets):
        accuracy = usual_accuracy(target.name, kind.responses[target.name].unit)
        values = means[:, axis]
        error = accuracy.of(float(values.mean())) ** 2 + float(variances[:, axis].mean())
        total = float(values.var()) + error
        left = {
            parameter.name: math.sqrt(max(1 - _explained(points[:, j], values, total), 0.0))
            for j, parameter in enumerate(problem.parameters)
        }
        yield FurtherMeasurement(test, target.name, accuracy, left)


def _forecast(
    test: str, names: Sequence[str], problem: Problem, solver: DeckSolver, atlas: Atlas
) -> Forecast | None:
    """Return predictions for the usual apparatus; None where there is none for the particles."""
    kind = bulk_tests()[test]
    if not names:
        return None
    try:
        material = {**solver.material, **problem.middle}
        apparatus = kind(solver.test.sizes, **options_for(kind, material))
        candidate = type(solver)(apparatus, solver.material)
        targets = [Target(name, 1.0, uncertainty=1.0) for name in names]
        return Forecast(Problem(problem.parameters, targets), {test: candidate}, atlas)
    except InputError:
        return None


def _explained(parameter: Array, values: Array, total: float) -> float:
    """Return the share of a parameter's variance that a measurement explains."""
    variance = float(parameter.var())
    if variance == 0:
        return 0.0
    together = float(np.mean((parameter - parameter.mean()) * (values - values.mean())))
    return together**2 / (variance * total)
