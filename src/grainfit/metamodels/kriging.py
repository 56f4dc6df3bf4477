"""Kriging: one metamodel of one response over the free parameters, fitted to few noisy runs.

The response is a linear trend, plus a Gaussian process with an anisotropic Matérn 5/2
covariance, plus the scatter from run to run. The common variance is integrated out (Student's t).
Ranges and share of noise are averaged over their posterior distribution (restricted likelihood
times weak priors): fixed at its maximum, they would make the intervals of few noisy runs far too
narrow.

Likelihood and predictor are implemented here and compared with gpmp in the tests: its NumPy back
end differentiates the likelihood numerically and factorises again with every prediction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtr, stdtrit

from grainfit.arrays import Array
from grainfit.errors import InputError
from grainfit.metamodels import messages
from grainfit.metamodels.checked_arrays import (
    checked,
    checked_noise,
    checked_points,
    checked_values,
)
from grainfit.metamodels.growing_scatter import GrowingScatter, find_growing_scatter
from grainfit.metamodels.hyperparameters import RANGE_MEDIAN, HyperparameterPosterior
from grainfit.metamodels.noise_ratios import most_probable, noise_ratios
from grainfit.metamodels.prediction import NORMAL_QUANTILE, LeaveOneOut, Prediction
from grainfit.metamodels.predictor import (
    Component,
    Contrasts,
    Hyperparameters,
    LeavingOut,
    Trend,
    runs_for_trend,
)
from grainfit.metamodels.relative_prior import RATIOS, RelativeModel, RelativePrior
from grainfit.metamodels.stacked_components import StackedComponents
from grainfit.one_line import OneLine
from grainfit.one_thread import one_thread

_MINIMUM_RUNS = 3
_LARGEST_BLOCK = 4096
#: Fits of a scatter that changes over the cube, each to the residuals of the one before.
_ROUNDS = 2
#: Ratios to a relative that are less likely than the most probable one by this factor are left out.
_SMALLEST_SHARE = 1e-3
#: Scatter is not told where less than a half of it has at least this probability.
_SMALL_NOISE, _DOUBT = 2.0, 0.1
#: With a smaller Q2, a metamodel predicts a run hardly better than the mean of all runs does.
POOR_Q2 = 0.5


class _Standardised(NamedTuple):
    """Responses less their mean, over the standard deviation of their residuals from the trend.

    Values that the trend explains but for rounding are exact: nothing can be estimated of them.
    """

    values: Array
    offset: float
    scale: float
    are_exact: bool

    @classmethod
    def of(cls, values: Array, contrasts: Contrasts) -> _Standardised:
        """Standardise responses."""
        offset = float(values.mean())
        left_over = contrasts.complement.T @ (values - offset)
        scale = math.sqrt(float(left_over @ left_over) / contrasts.degrees_of_freedom)
        # Residuals from the trend below this are rounding errors of the values.
        rounding = 1e-10 * float(np.ptp(values)) + 1e-13 * float(np.abs(values).max())
        are_exact = scale <= rounding
        if are_exact:
            # Tiny, so that all variances stay above zero.
            scale = rounding or 1e-12
        return cls((values - offset) / scale, offset, scale, are_exact)


class Kriging(OneLine):
    """Kriging metamodel of one response over the unit cube of the free parameters.

    Use `fit` to make one. It never changes: `condition` returns a new one.

    References
    ----------
    Stein (1999), *Interpolation of Spatial Data*: Matérn covariance, restricted likelihood.
    Rue, Martino & Chopin (2009), J. R. Stat. Soc. B 71, 319-392: averaging over hyperparameters
    on a small design around the maximum of their posterior distribution.
    Dubrule (1983), Math. Geol. 15, 687-699: leave-one-out without fitting again.

    Examples
    --------
    >>> x = np.linspace(0, 1, 12)[:, None]
    >>> metamodel = Kriging.fit(x, np.sin(3 * x[:, 0]))
    >>> bool(abs(metamodel.predict([[0.33]]).mean[0] - math.sin(0.99)) < 1e-3)
    True
    """

    def __init__(
        self,
        components: list[Component],
        *,
        offset: float,
        scale: float,
        degrees_of_freedom: int,
        judged_by: Kriging | None = None,
        scatter: GrowingScatter | None = None,
        relative: RelativePrior | None = None,
    ) -> None:
        self._components = components
        self._relative = relative
        #: Change of the scatter over the cube; None when it is the same everywhere.
        self.scatter = scatter
        self._weights = np.array([c.hyperparameters.weight for c in components])
        self._offset = offset
        self._scale = scale
        self._degrees_of_freedom = degrees_of_freedom
        # Pending runs have no value, so the metamodel is judged by the runs before them.
        self._judged_by = judged_by

    @classmethod
    def fit(
        cls,
        points: ArrayLike,
        values: ArrayLike,
        noise_variance: ArrayLike | None = None,
        *,
        standard_errors: ArrayLike | None = None,
        linear_trend: bool = True,
        scatter_may_vary: bool = False,
        known_scatter: float = 0.0,
        relative: Kriging | None = None,
    ) -> Kriging:
        """Fit a metamodel to runs.

        Parameters
        ----------
        points : array_like, shape (n, d)
            Points of the runs in the unit cube; points may be repeated.
        values : array_like, shape (n,)
            Their responses.
        noise_variance : array_like, shape (n,), optional
            Known part of each response's variance (for example its measurement's squared
            standard error). The scatter from run to run is estimated and added.
        standard_errors : array_like, shape (n,), optional
            Stated standard error of each response; 0 where none is stated. The size of the
            scatter is always estimated from the runs. The stated errors only give its ratios
            between runs, and only if the runs support them. Equal ones change nothing.
        linear_trend : bool
            Whether the trend is linear; if not, or with too few runs, it is constant.
        scatter_may_vary : bool
            Whether the scatter may change over the cube, which it does if the runs support it.
        known_scatter : float
            Standard deviation from run to run that is known before the runs; 0 for none. It counts
            as the estimate of five more runs, unless the runs contradict it.
        relative : Kriging, optional
            Metamodel of the same response of a cheaper model. The response is a ratio times that of
            the relative, and a difference. Predictions are averaged over ratios, of which 0, a
            relative that tells nothing, is one.

        Raises
        ------
        InputError
            If there are fewer than 3 runs, a value is not finite or of no physical magnitude, the
            shapes do not agree or the points are far outside the unit cube.
        """
        points = checked_points(points, None)
        n, d = points.shape
        values = checked_values(values, n)
        if n < _MINIMUM_RUNS or d < 1:
            fault = messages.TOO_FEW_RUNS.fault("points", runs=n, parameters=d, least=_MINIMUM_RUNS)
            raise InputError(fault)
        known_noise = checked_noise(noise_variance, n)
        candidates = noise_ratios(checked_noise(standard_errors, n, "standard_errors"))
        trend = Trend.choose(points, linear_trend)
        contrasts = Contrasts.of(trend.matrix(points))
        standardised = _Standardised.of(values, contrasts)
        known_noise = known_noise / standardised.scale**2
        if standardised.are_exact:
            median = np.full(d, RANGE_MEDIAN * math.sqrt(d))
            sets = [Hyperparameters(median, 0.5, 0.5, 1.0)]
            fit = _Fit(sets, contrasts.degrees_of_freedom, None, None, 0.0)
        else:
            data = _Data(trend, points, standardised.values, known_noise, contrasts)
            known_variance = (known_scatter / standardised.scale) ** 2
            fit = _most_probable_fit(candidates, data, scatter_may_vary, known_variance)
        given = (trend, points, standardised.values, known_noise, contrasts, fit.ratios)
        related, components = None, [Component(one, *given) for one in fit.sets]
        if relative is not None and not standardised.are_exact:
            related = RelativePrior(relative, standardised.offset, standardised.scale, points)
            components = _with_relative(components, fit, data, related)
        return cls(
            components,
            offset=standardised.offset,
            scale=standardised.scale,
            degrees_of_freedom=fit.degrees_of_freedom,
            scatter=fit.scatter,
            relative=related,
        )

    @property
    def relative(self) -> RelativeModel | None:
        """Metamodel of the relative; None without one."""
        return None if self._relative is None else self._relative.model

    @property
    def share_of_relative(self) -> float:
        """Probability that the relative tells about the response; 0 without one."""
        return float(self._weights @ [component.ratio != 0 for component in self._components])

    @property
    def d(self) -> int:
        """Number of free parameters."""
        return int(self._components[0].points.shape[1])

    @property
    def n(self) -> int:
        """Number of runs that have a value."""
        if self._judged_by is not None:
            return self._judged_by.n
        return len(self._components[0].points)

    @property
    def points(self) -> Array:
        """Points of the runs in the unit cube, shape (n, d)."""
        return (self._judged_by or self)._components[0].points

    @property
    def values(self) -> Array:
        """Responses of the runs, shape (n,)."""
        return np.asarray(
            self._offset + self._scale * (self._judged_by or self)._components[0].values
        )

    def standardised_residuals(self) -> Array:
        """Deviations of the runs from what the others predict, in standard deviations, shape (n,).

        They are exactly 0 where all runs are equal.
        """
        check = self.leave_one_out()
        off = self.values - check.predicted
        return np.asarray(off / np.maximum(check.standard_deviation, np.finfo(float).tiny))

    def leaving_out(self) -> LeavingOut:
        """Start to leave runs out one by one, at the most probable hyperparameters."""
        return self._components[int(np.argmax(self._weights))].leaving_out()

    def quantile(self, share: float) -> float:
        """Number of standard deviations that a share of predictions misses the truth by.

        Standard deviations are such that 1.96 of them miss it in 5 %; the tails are Student's.
        """
        freedom = self._degrees_of_freedom
        return -float(stdtrit(freedom, share / 2)) / math.sqrt(self._inflation)

    def share_below(self, deviations: Array) -> Array:
        """Probability that the truth is below so many standard deviations, the same shape.

        The distribution function that `quantile` inverts.
        """
        return np.asarray(stdtr(self._degrees_of_freedom, deviations * math.sqrt(self._inflation)))

    @property
    def components(self) -> int:
        """Number of sets of hyperparameters that predictions are averaged over."""
        return len(self._components)

    @property
    def ranges(self) -> Array:
        """Range of each parameter in the unit cube, shape (d,); short means strong curvature.

        Geometric mean over the posterior distribution; the scale of the Matérn 5/2 correlation
        with ``t = sqrt(10) distance / range``.
        """
        logarithms = np.array([np.log(c.hyperparameters.ranges) for c in self._components])
        return np.asarray(np.exp(self._weights @ logarithms))

    @property
    def tells_trend(self) -> bool:
        """Whether the runs are enough to tell a trend from chance, and so the scatter from both."""
        return self.n >= self._runs_for_trend

    @property
    def tells_scatter(self) -> bool:
        """Whether the runs tell the scatter: from a trend, and from what bends it.

        With few runs, hyperparameters of much and of little scatter may be about as probable.
        """
        noise = np.sqrt([c.hyperparameters.noise_variance for c in self._components])
        is_small = self._scale * noise < self.noise_standard_deviation / _SMALL_NOISE
        return self.tells_trend and float(self._weights @ is_small) < _DOUBT

    @property
    def _runs_for_trend(self) -> int:
        return runs_for_trend(self._components[0].effective_dimension)

    @property
    def noise_standard_deviation(self) -> float:
        """Estimated scatter of the response from run to run, in the response's unit."""
        variances = np.array([c.hyperparameters.noise_variance for c in self._components])
        return float(self._scale * math.sqrt(self._weights @ variances))

    @property
    def variance_of_scatter(self) -> float:
        """Variance that the scatter from run to run adds to that of a new run.

        More than the square of `noise_standard_deviation`, because the scatter is uncertain.
        """
        noise = np.array([c.hyperparameters.noise_variance for c in self._components])
        known = float(self._components[0].known_noise.mean())
        return self._scale**2 * (self._inflation * float(self._weights @ noise) + known)

    def scatter_at(self, points: Array) -> Array:
        """`variance_of_scatter` at points of the unit cube, shape (m,)."""
        return self.variance_of_scatter * self.scatter_ratios(points)

    def scatter_ratios(self, points: Array) -> Array:
        """Variances of the scatter at points over their mean at the runs, shape (m,)."""
        return np.ones(len(points)) if self.scatter is None else self.scatter.ratios(points)

    @cached_property
    def _inflation(self) -> float:
        """Factor that makes 1.96 standard deviations a 95 % interval with an estimated variance."""
        quantile = float(stdtrit(self._degrees_of_freedom, 0.975))
        return (quantile / NORMAL_QUANTILE) ** 2

    def _combine(self, means: Array, variances: Array) -> tuple[Array, Array]:
        """Mean and variance of the weighted mixture of the components."""
        mean = self._weights @ means
        within = self._inflation * (self._weights @ variances)
        return mean, within + self._weights @ (means - mean) ** 2

    def predict(self, points: ArrayLike) -> Prediction:
        """Predict the response at points; nothing is fitted again.

        Parameters
        ----------
        points : array_like, shape (m, d)
            Points in the unit cube.

        Raises
        ------
        InputError
            If the points have another shape or are not finite.
        """
        points = checked("points", points, (None, self.d))
        blocks = [
            self._predict_block(points[start : start + _LARGEST_BLOCK])
            for start in range(0, max(len(points), 1), _LARGEST_BLOCK)
        ]
        mean, variance = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
        variance = self._scale**2 * variance
        return Prediction(
            self._offset + self._scale * mean, variance, variance + self.scatter_at(points)
        )

    def mean(self, points: ArrayLike) -> Array:
        """Return the mean of `predict`, shape (m,), for a fraction of its operations.

        Raises
        ------
        InputError
            As `predict`.
        """
        points = checked("points", points, (None, self.d))
        if self._is_stacked(points):
            means = self._stacked.means(points)
        else:
            means = np.array([component.mean(points) for component in self._components])
        return np.asarray(self._offset + self._scale * (self._weights @ means))

    def _predict_block(self, points: Array) -> tuple[Array, Array]:
        if self._is_stacked(points):
            return self._combine(*self._stacked.predict(points))
        parts = [component.predict(points) for component in self._components]
        means, variances = (np.array(part) for part in zip(*parts, strict=True))
        return self._combine(means, variances)

    def _is_stacked(self, points: Array) -> bool:
        return self._relative is None and StackedComponents.pays(self._components, len(points))

    @cached_property
    def _stacked(self) -> StackedComponents:
        return StackedComponents(self._components)

    def gradients(self, points: ArrayLike) -> Array:
        """Gradients of the mean of `predict`, shape (m, d), per unit of each coordinate."""
        points = checked("points", points, (None, self.d))
        if self._is_stacked(points):
            gradients = self._stacked.gradients(points)
        else:
            gradients = np.array([component.gradients(points) for component in self._components])
        return np.asarray(self._scale * np.tensordot(self._weights, gradients, axes=1))

    def covariance_with(self, points: ArrayLike) -> Callable[[Array], tuple[Array, Array]]:
        """Prepare covariances of the expected response between these points and any others.

        Points are those of `predict`.

        Returns
        -------
        callable
            Of other points, shape (n, d): the covariances, shape (m, n), and the variances of the
            mean at the others, shape (n,). They account for the uncertainty of the
            hyperparameters, as the variances of `predict` do.
        """
        points = checked("points", points, (None, self.d))
        here = [component.project(points) for component in self._components]
        of_relative = None if self.relative is None else self.relative.covariance_with(points)
        means = np.array([c.predict_at(p)[0] for c, p in zip(self._components, here, strict=True)])
        off = means - self._weights @ means

        def covariances(others: Array) -> tuple[Array, Array]:
            is_same = others is points
            there = here if is_same else [c.project(others) for c in self._components]
            parts = [c.predict_at(p) for c, p in zip(self._components, there, strict=True)]
            other_means, variances = (np.array(part) for part in zip(*parts, strict=True))
            mean, variance = self._combine(other_means, variances)
            joint = sum(
                self._inflation * weight * c.joint(p, q)
                for weight, c, p, q in zip(
                    self._weights, self._components, here, there, strict=True
                )
            )
            shared = (self._weights[:, None] * off).T @ (other_means - mean)
            found = self._scale**2 * (joint + shared)
            if of_relative is not None:
                squares = self._weights @ [c.ratio**2 for c in self._components]
                found += self._inflation * squares * of_relative(others)[0]
            return found, self._scale**2 * variance

        return covariances

    def covariance_with_relative(self, points: ArrayLike) -> Callable[[Array], tuple[Array, Array]]:
        """Prepare covariances of the response at these points with that of the relative at others.

        Points are those of `predict`.

        Returns
        -------
        callable
            Of other points, shape (n, d): the covariances, shape (m, n), and the variances of the
            relative's mean at the others, shape (n,).
        """
        points = checked("points", points, (None, self.d))
        assert self._relative is not None, "only a response with a relative has these"
        relative = self._relative
        here = [component.project(points) for component in self._components]
        of_relative = relative.model.covariance_with(points)

        def covariances(others: Array) -> tuple[Array, Array]:
            there = relative.at(others)
            among = of_relative(others)[0] / self._scale**2
            parts = [
                c.covariance_of_relative(p, among, there.covariance)
                for c, p in zip(self._components, here, strict=True)
            ]
            joint, known = (np.array(part) for part in zip(*parts, strict=True))
            variance = np.maximum(there.variance - self._weights @ known, 0.0)
            # A known relative takes its part from the variance of the mean, which is inflated.
            covariance = math.sqrt(self._inflation) * np.tensordot(self._weights, joint, axes=1)
            return self._scale**2 * covariance, self._scale**2 * variance

        return covariances

    def leave_one_out(self) -> LeaveOneOut:
        """Prediction of each run from the others, without fitting again.

        Hyperparameters and their weights stay those of all runs. Pending runs do not count.
        """
        return self._judged_by.leave_one_out() if self._judged_by else self._leave_one_out

    @cached_property
    def _leave_one_out(self) -> LeaveOneOut:
        parts = [component.leave_one_out() for component in self._components]
        means, variances = (np.array(part) for part in zip(*parts, strict=True))
        mean, variance = self._combine(means, variances)
        values = self._components[0].values
        deviation = np.sqrt(variance)
        spread = float(((values - values.mean()) ** 2).sum())
        constant = float(np.ptp(values)) == 0.0
        return LeaveOneOut(
            predicted=self._offset + self._scale * mean,
            standard_deviation=self._scale * deviation,
            q2=math.nan if constant else 1.0 - float(((values - mean) ** 2).sum()) / spread,
            coverage=float(np.mean(np.abs(values - mean) <= NORMAL_QUANTILE * deviation)),
        )

    def condition(self, points: ArrayLike, values: ArrayLike) -> Kriging:
        """Add runs at the same hyperparameters.

        Parameters
        ----------
        points : array_like, shape (m, d)
            Points of the added runs.
        values : array_like, shape (m,)
            Their responses.

        Raises
        ------
        InputError
            As `fit`.
        """
        points = checked_points(points, self.d)
        added = (checked_values(values, len(points)) - self._offset) / self._scale
        noise = self._usual_known_noise(len(points))
        relative = self._relative_with(points)
        components = [
            c.condition(points, added, noise, self.scatter_ratios(points), relative)
            for c in self._components
        ]
        return self._with(components, None, relative)

    def condition_on_pending(self, points: ArrayLike) -> Kriging:
        """Add pending runs: the mean stays the same, the variance shrinks to its later value.

        Points and what is raised are those of `condition`.
        """
        points = checked_points(points, self.d)
        noise = self._usual_known_noise(len(points))
        ratios = self.scatter_ratios(points)
        relative = self._relative_with(points)
        components = [
            c.condition_on_pending(points, noise, ratios, relative) for c in self._components
        ]
        return self._with(components, self._judged_by or self, relative)

    def condition_on_pending_relative(self, points: ArrayLike) -> Kriging:
        """Add pending runs of the relative, of which the relative's own mean is expected.

        Points and what is raised are those of `condition`.
        """
        assert self._relative is not None, "only a response with a relative has its runs"
        relative = self._relative.with_model(self._relative.model.condition_on_pending(points))
        components = [component.related_to(relative) for component in self._components]
        return self._with(components, self._judged_by or self, relative)

    def _relative_with(self, points: Array) -> RelativePrior | None:
        """Return the relative for the runs so far and some more."""
        if self._relative is None:
            return None
        return self._relative.with_runs(np.vstack([self._relative.points, points]))

    def _usual_known_noise(self, runs: int) -> Array:
        return np.full(runs, float(self._components[0].known_noise.mean()))

    def _with(
        self,
        components: list[Component],
        judged_by: Kriging | None,
        relative: RelativePrior | None,
    ) -> Kriging:
        return Kriging(
            components,
            offset=self._offset,
            scale=self._scale,
            degrees_of_freedom=self._degrees_of_freedom,
            judged_by=judged_by,
            scatter=self.scatter,
            relative=relative,
        )

    def embedded(self, axes: Sequence[int], points: Array) -> Kriging:
        """Return the metamodel as one of more parameters, on the others of which nothing depends.

        Parameters
        ----------
        axes : sequence of int
            Axes of the larger unit cube that are those of this metamodel, in their order.
        points : ndarray, shape (n, dimension)
            Points of the runs in the larger unit cube.
        """
        dimension = points.shape[1]
        relative = None if self._relative is None else self._relative.embedded(axes, points)
        return Kriging(
            [component.embedded(axes, points, relative) for component in self._components],
            offset=self._offset,
            scale=self._scale,
            degrees_of_freedom=self._degrees_of_freedom,
            scatter=None if self.scatter is None else self.scatter.embedded(axes, dimension),
            relative=relative,
        )

    def reduced(self, components: int) -> Kriging:
        """Keep only the most probable sets of hyperparameters, for cheaper predictions.

        Parameters
        ----------
        components : int
            Number of sets to keep; their weights are raised to sum to one.

        Raises
        ------
        InputError
            If none is to be kept.
        """
        if components < 1:
            raise InputError(messages.NO_COMPONENTS.fault("components", given=components))
        if components >= self.components:
            return self
        kept = np.sort(np.argsort(-self._weights, kind="stable")[:components])
        weights = self._weights[kept] / self._weights[kept].sum()
        chosen = [self._components[i] for i in kept]
        relative = self._relative
        if relative is not None:
            relative = relative.with_model(relative.model.reduced(components))
            chosen = [component.related_to(relative) for component in chosen]
        return Kriging(
            [one.weighing(float(weight)) for one, weight in zip(chosen, weights, strict=True)],
            offset=self._offset,
            scale=self._scale,
            degrees_of_freedom=self._degrees_of_freedom,
            judged_by=self._judged_by.reduced(components) if self._judged_by else None,
            scatter=self.scatter,
            relative=relative,
        )

    def to_plain(self, *, factors: bool = True) -> dict[str, Any]:
        """Return as plain lists all that another program needs for the predictions of `predict`.

        Parameters
        ----------
        factors : bool
            Whether to include the factors that all predictions share: about n^2 numbers per
            component. Without them, the other program has to factorise by itself.

        Returns
        -------
        dict
            ``offset``, ``scale``, ``inflation``, ``degrees_of_freedom`` (numbers); ``points`` (n
            lists of d numbers), ``values`` and ``known_noise`` of the runs (n), in units of the
            scale;
            ``noise_ratios`` of the runs (n), unless all are 1; and ``components``, one
            dictionary for each set of hyperparameters: ``weight``, ``signal_variance``,
            ``noise_variance`` (numbers); ``ranges`` (d); ``trend_columns`` (q - 1 indices of
            parameters, from 0). With factors also ``coefficients`` (n); ``trend_coefficients``
            (q); ``least_squares`` (q lists of n); ``trend_covariance`` (q lists of q);
            ``triangle``, one flat list: n - q rows of an upper triangular matrix T of n + q
            columns, one after the other, each from its diagonal on, so row i has n + q - i
            numbers.

        Notes
        -----
        At a point x of the unit cube, for every component:

        - k, n numbers: ``k_i = signal_variance (1 + t + t^2 / 3) exp(-t)`` with
          ``t = sqrt(10) |(x - points_i) / ranges|`` (Matérn 5/2; Euclidean
          norm, divided parameter by parameter);
        - f, q numbers: 1, then ``x_j - 0.5`` for every j of ``trend_columns``;
        - ``mean = trend_coefficients . f + coefficients . k``;
        - ``variance = signal_variance - 2 f . (least_squares k) + f . (trend_covariance f)
          - |T v|^2``, v the n numbers of k and then the q of f; 0 if that is below.

        Then, sums over the components with their weights w:

        - ``m = sum w mean`` and ``s = inflation sum w variance + sum w (mean - m)^2``;
        - the expected response is ``offset + scale m``, its variance ``scale^2 s``, and its error
          over ``sqrt(scale^2 s / inflation)`` is Student's with these degrees of freedom.

        The factors are those of universal Kriging: of the k of all points among themselves, with
        ``noise_variance`` times ``noise_ratios`` and ``known_noise`` added on the diagonal, and of
        the f of all points.
        """
        ratios = self._components[0].noise_ratios
        return {
            "offset": self._offset,
            "scale": self._scale,
            "inflation": self._inflation,
            "degrees_of_freedom": self._degrees_of_freedom,
            "points": self._components[0].points.tolist(),
            "values": self._components[0].values.tolist(),
            "known_noise": self._components[0].known_noise.tolist(),
            **({} if ratios is None else {"noise_ratios": ratios.tolist()}),
            "components": [component.to_plain(factors) for component in self._components],
        }

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any], points: ArrayLike, values: ArrayLike) -> Kriging:
        """Return a metamodel from the hyperparameters of `to_plain` and the runs, without a fit.

        Parameters
        ----------
        plain : mapping
            As of `to_plain`; ``points``, ``values`` and ``known_noise`` are not read, and known
            parts of the variances are 0.
        points : array_like, shape (n, d)
            Points of the runs in the unit cube.
        values : array_like, shape (n,)
            Their responses.

        Raises
        ------
        KeyError, TypeError, ValueError
            The data is no metamodel, or one of other runs.
        """
        points, offset, scale = np.asarray(points), float(plain["offset"]), float(plain["scale"])
        standardised = (np.asarray(values) - offset) / scale
        ratios = plain.get("noise_ratios")
        noise = None if ratios is None else np.array(ratios, dtype=float)
        components = []
        contrasts: dict[Trend, Contrasts] = {}
        for one in plain["components"]:
            trend = Trend(tuple(one["trend_columns"]))
            if trend not in contrasts:
                contrasts[trend] = Contrasts.of(trend.matrix(points))
            numbers = (one[key] for key in ("signal_variance", "noise_variance", "weight"))
            sets = Hyperparameters(np.array(one["ranges"], dtype=float), *map(float, numbers))
            given = (points, standardised, np.zeros(len(points)), contrasts[trend], noise)
            components.append(Component(sets, trend, *given))
        return cls(
            components,
            offset=offset,
            scale=scale,
            degrees_of_freedom=int(plain["degrees_of_freedom"]),
        )

    def warnings(self, *, spread: bool = True) -> list[str]:
        """Reasons not to trust the metamodel, in plain language; empty if there are none.

        Parameters
        ----------
        spread : bool
            Whether the runs are spread by a design. Runs that a search has placed close together
            differ by little more than their noise, so their Q2 has no meaning.
        """
        quality = self.leave_one_out()
        if math.isnan(quality.q2):
            return [messages.SAME_VALUE(runs=self.n)]
        found = [
            self._warning_of_few_runs(),
            self._warning_of_q2() if spread else "",
            self._warning_of_coverage(),
        ]
        return [text for text in found if text]

    def _warning_of_few_runs(self) -> str:
        if self.tells_trend:
            return ""
        d = self._components[0].effective_dimension
        return messages.FEW_RUNS(runs=self.n, parameters=d, needed=self._runs_for_trend)

    def _warning_of_q2(self) -> str:
        quality = self.leave_one_out()
        if quality.q2 >= POOR_Q2:
            return ""
        values = (self._judged_by or self)._components[0].values
        spread = self._scale * float(values.std())
        noise = self.noise_standard_deviation
        if noise**2 >= (1.0 - POOR_Q2) * spread**2:
            return messages.SCATTERS(q2=quality.q2, spread=spread, noise=noise)
        return messages.UNEXPLAINED(q2=quality.q2, spread=spread, noise=noise)

    def _warning_of_coverage(self) -> str:
        # Loaded late, because it takes half a second.
        from scipy.stats import binom

        quality = self.leave_one_out()
        inside = round(quality.coverage * self.n)
        if float(binom.cdf(inside, self.n, 0.95)) >= 0.01:
            return ""
        return messages.TOO_CERTAIN(coverage=100 * quality.coverage)


class _Data(NamedTuple):
    """Runs that hyperparameters are fitted to, with their trend; values are standardised."""

    trend: Trend
    points: Array
    values: Array
    known_noise: Array
    contrasts: Contrasts

    def posterior(
        self, ratios: Array | None, known_variance: float = 0.0
    ) -> HyperparameterPosterior:
        """Return the posterior of the hyperparameters with ratios of the noise variances."""
        return HyperparameterPosterior(
            self.points, self.values, self.contrasts, self.known_noise, ratios, known_variance
        )


class _Fit(NamedTuple):
    """Weighted hyperparameters, with the ratios of noise variances that the runs support most."""

    sets: list[Hyperparameters]
    degrees_of_freedom: int
    ratios: Array | None
    scatter: GrowingScatter | None
    known_variance: float


def _most_probable_fit(
    candidates: Sequence[Array | None],
    data: _Data,
    scatter_may_vary: bool,
    known_variance: float,
) -> _Fit:
    with one_thread():
        fits = [(data.posterior(ratios), ratios, None) for ratios in candidates]
        varying = _varying(data, fits[0][0]) if scatter_may_vary else None
        every = [*fits, *([varying] if varying else [])]
        slopes = data.points.shape[1] if varying else 0
        best, ratios, scatter = every[most_probable([fit.log_density for fit, *_ in every], slopes)]
        # What is known is no scatter that changes over the cube.
        if scatter is None and known_variance > 0 and best.supports(known_variance):
            best = data.posterior(ratios, known_variance)
        else:
            known_variance = 0.0
        return _Fit(
            best.hyperparameters(), best.degrees_of_freedom, ratios, scatter, known_variance
        )


def _with_relative(
    alone: Sequence[Component], fit: _Fit, data: _Data, relative: RelativePrior
) -> list[Component]:
    """Average components without a relative with those at several ratios to it, by their evidence.

    The trend beside a relative is constant, and so it is where the evidence is compared: a linear
    one leaves no evidence for a relation of few runs near each other.
    """
    trend = Trend(())
    data = data._replace(trend=trend, contrasts=Contrasts.of(trend.matrix(data.points)))
    at_runs = relative.at(data.points)
    posteriors: dict[float, HyperparameterPosterior] = {}
    with one_thread():
        for ratio in RATIOS:
            known = np.diag(data.known_noise) + ratio**2 * at_runs.covariance
            posteriors[ratio] = HyperparameterPosterior(
                data.points,
                data.values - ratio * at_runs.mean,
                data.contrasts,
                known,
                fit.ratios,
                fit.known_variance,
            )
        evidence = [
            posterior.log_density + math.log(RATIOS[ratio])
            for ratio, posterior in posteriors.items()
        ]
        shares = np.exp(np.array(evidence) - max(evidence))
        shares[shares < _SMALLEST_SHARE] = 0.0
        shares /= shares.sum()
        # The first ratio is 0.
        components = [
            one.related_to(relative).weighing(float(shares[0] * one.hyperparameters.weight))
            for one in alone
            if shares[0]
        ]
        for share, (ratio, posterior) in zip(shares, posteriors.items(), strict=True):
            if share and ratio:
                components += [
                    Component(
                        replace(one, ratio=ratio, weight=float(share * one.weight)),
                        *data,
                        fit.ratios,
                        relative,
                    )
                    for one in posterior.hyperparameters()
                ]
    return components


def _varying(
    data: _Data, posterior: HyperparameterPosterior
) -> tuple[HyperparameterPosterior, Array, GrowingScatter] | None:
    """Fit a scatter that changes over the cube; None when there is no sign of one.

    A second round finds more: with the same scatter everywhere, the predictions of calm runs follow
    their wild neighbours.
    """
    varying, ratios = None, None
    for _ in range(_ROUNDS):
        component = Component(posterior.most_probable, *data, ratios)
        expected, variances = component.leave_one_out()
        # In units of the scatter where the variance ratio is one.
        variances = variances if ratios is None else variances / ratios
        scatter = find_growing_scatter(data.points, (data.values - expected) / np.sqrt(variances))
        if scatter is None:
            break
        ratios = scatter.ratios(data.points)
        posterior = data.posterior(ratios)
        varying = posterior, ratios, scatter
    return varying
