"""Kriging metamodels of all responses of a problem."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr, ndtri

from grainfit.arrays import Array
from grainfit.errors import RunFailedError
from grainfit.evaluation import Evaluation, Response
from grainfit.formatting import causes, counted
from grainfit.metamodels import messages
from grainfit.metamodels.blow_ups import without_blow_ups
from grainfit.metamodels.curve_reduction import (
    Reduction,
    about_other_kind,
    about_short_curves,
    runs_with_curve,
)
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.outliers import NO_OUTLIERS, Outliers, fit_without_outliers
from grainfit.one_line import OneLine
from grainfit.problem import Problem, Target, TestScope
from grainfit.problem.correlations import correlated_groups

_NO_NOISE = 1e-12
#: Change of an expected response by outlying runs, in tolerances, that is worth a run.
_MATTERS = 0.1
#: Largest effort of `Metamodels.reduced`: squared numbers of runs, times sets of hyperparameters,
#: summed over the responses.
_LARGEST_EFFORT = 400_000
#: Fixed cost of a prediction, in the same unit.
_EFFORT_OF_ASKING = 5_000
_FEWEST_COMPONENTS = 2
#: Runs at different places that a metamodel needs beside a relative.
_FEWEST_WITH_RELATIVE = 3
#: Fits that are kept, because the next ones are likely to need them again.
_KEPT_FITS = 32
#: Outcomes by which the share that meets correlated targets together is counted.
_OUTCOMES = 512


class Metamodels(OneLine):
    """One metamodel per target, in the order of the targets.

    Responses are given in two ways: as they are (`predict`, `gradients`), and as *deviations*
    from the targets in units of their uncertainties, times the weights of the targets. The
    uncertainty is the tolerance, which represents that of the measurement, plus in quadrature the
    scatter of the mean of all runs. So a target whose scatter is larger than its tolerance does not
    outweigh all others in the sum of squared deviations.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    models : sequence of Kriging
        One per target, of the runs without outliers.
    outliers : sequence of Outliers, optional
        Outlying runs, one object per target. Expected responses are those over all seeds: the
        outliers shift them.
    reduction : Reduction, optional
        Reduction of the curves whose components are among the targets.
    """

    def __init__(
        self,
        problem: Problem,
        models: Sequence[Kriging],
        outliers: Sequence[Outliers] | None = None,
        reduction: Reduction | None = None,
    ) -> None:
        self.problem = problem
        self.reduction = reduction or Reduction(problem)
        self.models = list(models)
        self.outliers = list(outliers or [NO_OUTLIERS] * len(self.models))
        self._counted = [
            NO_OUTLIERS if target.statistic == "median" else found
            for found, target in zip(self.outliers, problem.targets, strict=True)
        ]
        self._axes = [problem.axes_of(problem.scope_of(t.name)) for t in problem.targets]
        self._targets = np.array([target.value for target in problem.targets])
        self._tolerances = np.array([target.tolerance for target in problem.targets])
        weights = np.array([target.weight for target in problem.targets])
        least = np.array([model.variance_of_scatter / model.n for model in self.models])
        self._units = np.sqrt(self._tolerances**2 + least) / weights
        self.correlation = problem.correlation_matrix
        self._groups = correlated_groups(self.correlation)

    @classmethod
    def fit(cls, problem: Problem, evaluations: Sequence[Evaluation]) -> Metamodels:
        """Fit the metamodels to evaluations.

        Parameters
        ----------
        problem : Problem
            Parameters and targets.
        evaluations : sequence of Evaluation
            For each response, the evaluations that yielded it are used. Curves are replaced by
            their principal components in the metamodels' problem.

        Raises
        ------
        RunFailedError
            Too few runs yielded a response to fit a metamodel.
        """
        evaluations = without_blow_ups(problem, evaluations)
        for name in problem.responses:
            _require_runs(problem, evaluations, name)
        reduction = Reduction.of(problem, evaluations)
        reduced, runs = reduction.problem, reduction.evaluations(evaluations)
        fits = [_fit(reduced, runs, target.name) for target in reduced.targets]
        models, outliers = [model for model, _ in fits], [found for _, found in fits]
        return cls(reduced, models, outliers, reduction)

    def reduced(self) -> Metamodels:
        """Keep the most probable sets of hyperparameters alone, as many predictions need."""
        effort = sum(model.n**2 + _EFFORT_OF_ASKING for model in self.models)
        components = max(_LARGEST_EFFORT // effort, _FEWEST_COMPONENTS)
        models = [model.reduced(components) for model in self.models]
        return Metamodels(self.problem, models, self.outliers, self.reduction)

    def predict(self, points: ArrayLike) -> tuple[Array, Array]:
        """Expected responses and their variances at points of the unit cube.

        Parameters
        ----------
        points : array_like, shape (m, d)
            Points of the unit cube.

        Returns
        -------
        means, variances : ndarray, shape (m, number of targets)
            The variance is that of the expected response, not of a single run.
        """
        means, variances = self.predict_without_outliers(points)
        shifts, of_shifts = self._shifts(np.atleast_2d(points))
        return means + shifts, variances + of_shifts

    def suspects(self, point: Array) -> list[tuple[Target, int]]:
        """Targets with the seeds of outlying runs that change what is expected at a point.

        Only those that no other run has the parameters of: it would tell if they come again.
        """
        shifts, variances = (found[0] for found in self._shifts(np.atleast_2d(point)))
        matter = np.hypot(shifts, np.sqrt(variances)) > _MATTERS * self._tolerances
        return [
            (target, seed)
            for target, found, counts in zip(
                self.problem.targets, self._counted, matter, strict=True
            )
            if counts
            for seed, is_alone in zip(found.seeds, found.alone, strict=True)
            if is_alone
        ]

    def _shifts(self, points: Array) -> tuple[Array, Array]:
        """Changes by outlying runs, and their variances, shape (m, targets)."""
        found = [
            outliers.shift_at(points[:, axes])
            for outliers, axes in zip(self._counted, self._axes, strict=True)
        ]
        shifts, variances = zip(*found, strict=True)
        return np.column_stack(shifts), np.column_stack(variances)

    def predict_without_outliers(self, points: ArrayLike) -> tuple[Array, Array]:
        """Return the same by the runs that are no outliers."""
        predictions = [model.predict(np.atleast_2d(points)) for model in self.models]
        return (
            np.column_stack([prediction.mean for prediction in predictions]),
            np.column_stack([prediction.variance_of_mean for prediction in predictions]),
        )

    def gradients(self, points: ArrayLike) -> Array:
        """Slopes of the expected responses, shape (m, number of targets, d), per unit interval."""
        at = np.atleast_2d(points)
        return np.stack([model.gradients(at) for model in self.models], axis=1)

    @property
    def noise(self) -> Array:
        """Standard deviations of the responses from seed to seed, shape (number of targets,)."""
        return np.array([model.noise_standard_deviation for model in self.models])

    def noise_at(self, point: ArrayLike) -> Array:
        """Standard deviations of the responses from seed to seed at one point, shape (targets,)."""
        at = np.atleast_2d(point)
        ratios = [float(model.scatter_ratios(at)[0]) for model in self.models]
        return np.asarray(self.noise * np.sqrt(ratios))

    def scatter_at(self, points: ArrayLike) -> Array:
        """Variance that the scatter adds to a run's deviations, above zero, shape (m, targets)."""
        at = np.atleast_2d(points)
        variances = np.column_stack([model.scatter_at(at) for model in self.models])
        return np.asarray(np.maximum(variances / self._units**2, _NO_NOISE**2))

    def deviations(self, points: ArrayLike) -> tuple[Array, Array]:
        """Expected deviations and their variances, shape (m, number of targets) each."""
        means, variances = self.predict(points)
        off = (means - self._targets) / self._units
        return off, variances / self._units**2

    @property
    def precisions(self) -> Array:
        """Weights of the variances of deviations in the misfit, 1 without correlations."""
        return np.asarray(np.diagonal(self.problem.precision_matrix))

    def decorrelated(self, deviations: Array) -> Array:
        """Combine deviations, shape (..., number of targets), whose squares sum to the misfit."""
        return deviations if not self._groups else deviations @ self.problem.decorrelation.T

    def slopes(self, points: ArrayLike) -> Array:
        """Slopes of the expected deviations, shape (m, number of targets, d)."""
        return np.asarray(self.gradients(points) / self._units[:, None])

    def misfit(self, points: ArrayLike) -> Array:
        """Expected sum of squared deviations at points, shape (m,).

        Of two points with equal means, the less uncertain one has the smaller misfit. Deviations of
        correlated targets are decorrelated: the sum is that of Mahalanobis. Parameters with a
        measurement of their own add the squares of their deviations from it.
        """
        means, variances = self.deviations(points)
        own = (self.problem.standardised_residuals(points) ** 2).sum(axis=1)
        squares = self.decorrelated(means) ** 2
        return np.asarray((squares + variances * self.precisions).sum(axis=1) + own)

    def residuals(self, points: ArrayLike) -> Array:
        """Expected deviations whose squares sum to the misfit without variances, shape (m, k).

        Those of the responses, decorrelated where targets are correlated, then those of parameters
        from measurements of their own.
        """
        at = np.atleast_2d(points)
        means = np.column_stack([model.mean(at) for model in self.models]) + self._shifts(at)[0]
        responses = self.decorrelated((means - self._targets) / self._units)
        return np.hstack([responses, self.problem.standardised_residuals(points)])

    def residual_slopes(self, points: ArrayLike) -> Array:
        """Slopes of the residuals, shape (m, k, d)."""
        responses = self.decorrelated(self.slopes(points).transpose(0, 2, 1)).transpose(0, 2, 1)
        own = self.problem.standardised_residual_slopes(points)
        return np.concatenate([responses, own], axis=1)

    def shortfall(self, points: ArrayLike, standard_errors: float) -> Array:
        """Squared deviations beyond the tolerances and some standard errors, summed, shape (m,).

        It is zero where all targets may be met.
        """
        means, variances = self.predict(points)
        beyond = np.abs(means - self._targets) - self._tolerances
        beyond = np.maximum(beyond - standard_errors * np.sqrt(variances), 0.0)
        return np.asarray(((beyond / self._units) ** 2).sum(axis=1))

    def covariance_with(self, points: Array) -> Callable[[Array], tuple[Array, Array]]:
        """Prepare covariances of the deviations, see `Kriging.covariance_with`.

        Returns
        -------
        callable
            Of other points, shape (n, d): covariances, shape (number of targets, m, n), and
            variances at the others, shape (number of targets, n).
        """
        prepared = [model.covariance_with(points) for model in self.models]
        squares = self._units**2

        def covariances(others: Array) -> tuple[Array, Array]:
            parts = [covariance(others) for covariance in prepared]
            return (
                np.array([joint for joint, _ in parts]) / squares[:, None, None],
                np.array([variance for _, variance in parts]) / squares[:, None],
            )

        return covariances

    def probability_all_met(self, points: ArrayLike) -> Array:
        """Probability that every expected response is within its tolerance, shape (m,).

        The errors are Student's to their tails, and count as independent from response to response:
        with any correlation the product is a lower bound where the targets are met in the middle
        (Šidák 1967, J. Am. Stat. Assoc. 62, 626-633). Correlated targets are met together when,
        besides, the mean square of their decorrelated deviations is at most one tolerance squared:
        without correlation the tolerances imply that.
        """
        return self._probability(*self.predict(points))

    def probability_without_outliers(self, points: ArrayLike) -> Array:
        """Probability that all targets are met by runs that are no outliers, shape (m,)."""
        return self._probability(*self.predict_without_outliers(points))

    def probabilities(self, points: ArrayLike) -> Array:
        """Probability that each expected response is within its tolerance, shape (m, targets)."""
        return self._inside(*self.predict(points))

    def _probability(self, means: Array, variances: Array) -> Array:
        each = self._inside(means, variances).prod(axis=1)
        if not self._groups:
            return np.asarray(each)
        return np.asarray(each * self._share_together(means, variances))

    def _share_together(self, means: Array, variances: Array) -> Array:
        """Share of outcomes within every tolerance in which correlated targets go together."""
        off = ((means - self._targets) / self._tolerances)[:, None]
        error = np.sqrt(np.maximum(variances / self._tolerances**2, _NO_NOISE**2))[:, None]
        low, high = ndtr((-1.0 - off) / error), ndtr((1.0 - off) / error)
        outcomes = ndtri(low + _even_outcomes(len(self.models)) * (high - low))
        drawn = np.clip(off + error * outcomes, -1.0, 1.0)
        together = np.ones(drawn.shape[:2], dtype=bool)
        for group in self._groups:
            precision = self.problem.precision_matrix[np.ix_(group, group)]
            squares = np.einsum("msk,kl,msl->ms", drawn[..., group], precision, drawn[..., group])
            together &= squares <= len(group)
        return np.asarray(together.mean(axis=1))

    def _inside(self, means: Array, variances: Array) -> Array:
        off = means - self._targets
        error = np.sqrt(np.maximum(variances, (_NO_NOISE * self._tolerances) ** 2))
        upper, lower = (self._tolerances - off) / error, (-self._tolerances - off) / error
        return np.column_stack(
            [
                model.share_below(high) - model.share_below(low)
                for model, high, low in zip(self.models, upper.T, lower.T, strict=True)
            ]
        )

    def runs_needed(self, point: Array, confidence: float) -> int:
        """Estimate how many more runs at a point would confirm that it agrees, at most a million.

        Assumes that the expected responses stay as they are and their errors shrink.
        """
        means, _ = self.predict(point)
        counts = np.unique(np.geomspace(1, 1e6, 400).round())
        left = self._variances_after(point, np.tile(counts[:, None], len(self.models)))
        enough = self._probability(np.tile(means, (len(counts), 1)), left) >= confidence
        return int(counts[enough][0]) if enough.any() else int(counts[-1])

    def runs_by_worth(
        self, point: Array, confidence: float, seconds: Mapping[str, float], most: int
    ) -> tuple[str, ...]:
        """Return the tests whose runs at a point would confirm soonest that it agrees, in order.

        Each is the one that raises the probability most per second of computing, were the targets
        met in the middle.

        Parameters
        ----------
        point : ndarray, shape (d,)
            Point of the unit cube.
        confidence : float
            Probability with which no more runs follow.
        seconds : mapping of str to float
            Cost of a run by name of the test, s.
        most : int
            Largest number of runs.
        """
        scopes = self.problem.scopes
        yields = np.array([self.yielded_by([scope.name]) for scope in scopes])
        costs = np.array([seconds[scope.name] for scope in scopes])
        counts = np.zeros(len(scopes), dtype=int)
        order: list[str] = []
        while len(order) < most:
            then = [counts + one for one in np.eye(len(scopes), dtype=int)]
            chances = self._chances(point, np.array([counts, *then]) @ yields)
            if order and chances[0] >= confidence:
                break
            best = int(np.argmax(np.log(chances[1:] / chances[0]) / costs))
            counts[best] += 1
            order.append(scopes[best].name)
        return tuple(order)

    def _chances(self, point: Array, counts: NDArray[np.int_]) -> Array:
        """Probability that a point agrees after some runs per target, shape (m, targets)."""
        left = self._variances_after(point, counts)
        inside = self._probability(np.tile(self._targets, (len(counts), 1)), left)
        return np.maximum(inside, np.finfo(float).tiny)

    def _variances_after(self, point: Array, counts: NDArray[Any]) -> Array:
        """Variances at a point after some runs there per target, shape (m, targets)."""
        at = np.atleast_2d(point)
        variances = self.predict_without_outliers(at)[1][0]
        of_shifts = self._shifts(at)[1][0]
        scatter = self.scatter_at(at)[0] * self._units**2
        shrinking = [
            found.shrinking_at(at[0, axes], count)
            for found, axes, count in zip(self._counted, self._axes, counts.T, strict=True)
        ]
        left = variances / (1 + counts * variances / scatter) + of_shifts * np.array(shrinking).T
        return np.asarray(left)

    def covariance_with_relatives(self, points: Array) -> Callable[[Array], tuple[Array, Array]]:
        """Prepare covariances of the deviations with the responses of the tests' relatives.

        Returns
        -------
        callable
            As of `covariance_with`; the other points are those of runs of the relatives, and a
            target whose test has no relative has covariances and variances of 0.
        """
        prepared = [
            None if model.relative is None else model.covariance_with_relative(points)
            for model in self.models
        ]
        squares = self._units**2

        def covariances(others: Array) -> tuple[Array, Array]:
            joint = np.zeros((len(self.models), len(points), len(others)))
            variances = np.zeros((len(self.models), len(others)))
            for row, covariance in enumerate(prepared):
                if covariance is not None:
                    joint[row], variances[row] = covariance(others)
            return joint / squares[:, None, None], variances / squares[:, None]

        return covariances

    def scatter_of_relatives_at(self, points: ArrayLike) -> Array:
        """Return `scatter_at` of runs of the relatives, shape (m, targets); 1 without one."""
        at = np.atleast_2d(points)
        found = np.ones((len(at), len(self.models)))
        for column, (model, unit) in enumerate(zip(self.models, self._units, strict=True)):
            if model.relative is not None:
                scatter = model.relative.scatter_at(at) / unit**2
                found[:, column] = np.maximum(scatter, _NO_NOISE**2)
        return found

    def told_by(self, relative: str) -> NDArray[np.bool_]:
        """Whether runs of a relative tell about each target, shape (targets,)."""
        found = [self.problem.relative_of(target.name) for target in self.problem.targets]
        return np.array(
            [
                one is not None and one.name == relative and model.relative is not None
                for one, model in zip(found, self.models, strict=True)
            ]
        )

    def yielded_by(self, tests: Collection[str] | None) -> NDArray[np.bool_]:
        """Whether runs of some tests yield each target, shape (targets,); None for all tests."""
        targets = self.problem.targets
        if tests is None:
            return np.ones(len(targets), dtype=bool)
        return np.array([self.problem.scope_of(target.name).name in tests for target in targets])

    def condition_on_pending(
        self, points: Array, yields: NDArray[np.bool_] | None = None
    ) -> Metamodels:
        """Add pending runs at points: means stay the same, variances shrink.

        ``yields``, shape (m, targets), says which targets each of them yields; all by default.
        """
        if not len(points):
            return self
        chosen = np.ones((len(points), len(self.models)), dtype=bool) if yields is None else yields
        models = [
            model.condition_on_pending(points[of_target]) if of_target.any() else model
            for model, of_target in zip(self.models, chosen.T, strict=True)
        ]
        return Metamodels(self.problem, models, self.outliers, self.reduction)

    def condition_on_pending_relatives(self, points: Array, told: NDArray[np.bool_]) -> Metamodels:
        """Add pending runs of relatives; ``told``, shape (m, targets), see `told_by`."""
        if not told.any():
            return self
        models = [
            model.condition_on_pending_relative(points[of_target]) if of_target.any() else model
            for model, of_target in zip(self.models, told.T, strict=True)
        ]
        return Metamodels(self.problem, models, self.outliers, self.reduction)


@cache
def _even_outcomes(responses: int) -> Array:
    """Points spread evenly over the unit cube, shape (n, responses)."""
    # Loaded late, because it takes half a second.
    from scipy.stats import qmc

    points = qmc.Sobol(responses, rng=1967).random(_OUTCOMES)
    return np.asarray(np.clip(points, 1e-6, 1 - 1e-6))


def runs_that_yield(
    problem: Problem, evaluations: Sequence[Evaluation], name: str
) -> list[Evaluation]:
    """Evaluations that have a response; if it is a curve, at all measured coordinates."""
    for curve in problem.curves:
        if curve.name == name:
            return runs_with_curve(curve, evaluations)
    return [e for e in evaluations if name in e.responses]


def can_be_fitted(
    problem: Problem, evaluations: Sequence[Evaluation], names: Collection[str] | None = None
) -> bool:
    """Whether runs at enough different places yielded every response, or those of some names."""
    evaluations = without_blow_ups(problem, evaluations)
    return all(
        _places(scope, runs_that_yield(problem, evaluations, name))
        >= _fewest_places(problem, scope, evaluations, name)
        for name in (problem.responses if names is None else names)
        for scope in [problem.scope_of(name)]
    )


def _fewest_places(
    problem: Problem, scope: TestScope, evaluations: Sequence[Evaluation], name: str
) -> int:
    if _runs_of_relative(problem, evaluations, name):
        return _FEWEST_WITH_RELATIVE
    return len(scope.parameters) + 2


def _runs_of_relative(
    problem: Problem, evaluations: Sequence[Evaluation], name: str
) -> list[tuple[Evaluation, Response]]:
    """Return the runs of the relative of a target, if they are enough for its metamodel."""
    relative = problem.relative_of(name)
    if relative is None:
        return []
    own = relative.response_name(name)
    known = [(e, e.responses[own]) for e in evaluations if own in e.responses]
    scope = problem.scope_of(name)
    enough = _places(scope, [e for e, _ in known]) >= len(scope.parameters) + 2
    return known if enough else []


def _places(scope: TestScope, evaluations: Sequence[Evaluation]) -> int:
    return len({tuple(e.proposal.parameters[n] for n in scope.parameters) for e in evaluations})


def _require_runs(problem: Problem, evaluations: Sequence[Evaluation], name: str) -> None:
    """Raise `RunFailedError` if too few runs yielded a response to fit a metamodel."""
    known, scope = runs_that_yield(problem, evaluations, name), problem.scope_of(name)
    needed, places = _fewest_places(problem, scope, evaluations, name), _places(scope, known)
    if places >= needed:
        return
    asked = [e for e in evaluations if e.proposal.asks_for(scope.name)]
    where = counted(places, "different place")
    if len(known) < len(asked) or not known:
        runs = counted(len(asked), "run")
        few = messages.FEW_RESPONSES(known=len(known), runs=runs, name=name, places=where)
    else:
        few = messages.FEW_PLACES(runs=counted(len(known), "run"), name=name, places=where)
    failures = causes(reason for e in asked for reason in e.failures.values())
    reasons = "; ".join(reason.removesuffix(".") for reason in failures[:3])
    because = f" {messages.FAILURES(reasons=reasons)}" if failures else ""
    short = [about_short_curves(c, evaluations) for c in problem.curves if c.name == name]
    why = messages.NO_METAMODEL(few=few, needed=needed, because=because)
    kind = about_other_kind(problem, evaluations, name)
    raise RunFailedError(" ".join(filter(None, [why, kind, *short])))


def _fit(
    problem: Problem, evaluations: Sequence[Evaluation], name: str
) -> tuple[Kriging, Outliers]:
    known = [e for e in evaluations if name in e.responses]
    axes = problem.axes_of(problem.scope_of(name))
    points = np.array([problem.to_unit(e.proposal.parameters) for e in known])
    scatter = problem.scatters.get(name, 0.0)
    relative = None
    if of_relative := _runs_of_relative(problem, evaluations, name):
        theirs = np.array([problem.to_unit(e.proposal.parameters) for e, _ in of_relative])
        relative, _ = _fit_at(theirs[:, axes], [one for _, one in of_relative], scatter)
    responses = [e.responses[name] for e in known]
    model, outliers = _fit_at(points[:, axes], responses, scatter, relative)
    runs = tuple(known[index].proposal.seed for index in outliers.indices)
    if len(axes) < problem.dimension:
        model = model.embedded(axes, np.delete(points, outliers.indices, axis=0))
    return model, replace(outliers, seeds=runs)


def _fit_at(
    points: Array,
    responses: Sequence[Response],
    scatter: float,
    relative: Kriging | None = None,
) -> tuple[Kriging, Outliers]:
    """Fit the metamodel of a target, or of its relative, to responses at points."""
    values = tuple(response.value for response in responses)
    errors = tuple(response.standard_error for response in responses)
    return _fit_once(tuple(map(tuple, points.tolist())), values, errors, scatter, relative)


@lru_cache(maxsize=_KEPT_FITS)
def _fit_once(
    points: tuple[tuple[float, ...], ...],
    values: tuple[float, ...],
    standard_errors: tuple[float, ...],
    scatter: float,
    relative: Kriging | None,
) -> tuple[Kriging, Outliers]:
    """Fit a metamodel, unless it is known: a new run of one test changes nothing for the others."""
    responses, errors = np.array(values), np.array(standard_errors)
    return fit_without_outliers(np.array(points), responses, errors, scatter, relative)
