"""Predict curves of a test that took no part in a calibration, from runs of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from grainfit.analysis.prediction import POINTS_OF_PRIOR, HoldoutEvaluations
from grainfit.arrays import Array
from grainfit.evaluation import Evaluation
from grainfit.metamodels.curve_reduction import CurveBasis, runs_with_curve, values_at
from grainfit.metamodels.metamodels import Metamodels
from grainfit.one_thread import one_thread
from grainfit.problem import CurveTarget, Problem
from grainfit.result import HoldoutCurve
from grainfit.verdict.holdout import judge_prediction
from grainfit.verdict.options import HOLDOUT

#: Measured curves that are drawn from the prediction: 5 % of them are known to ± 0.3 %.
_DRAWS = 4000
#: Smallest standard deviation, over the size of the values: of curves that are all the same.
_ROUNDING = 1e-9


def predict_curve(
    problem: Problem, target: CurveTarget, runs: HoldoutEvaluations, sample: Array
) -> HoldoutCurve:
    """Predict a curve over a sample of parameter sets, and compare it with the measured one.

    Metamodels of the principal components of the simulated curves give the expected curve at every
    parameter set; together with the errors of the measurement they make curves as they could have
    been measured. 95 % of these lie within the band wholly: it is as many standard deviations wide
    at every point. The measured curve is predicted where it does, too.

    Parameters
    ----------
    problem : Problem
        With the parameters that the test depends on, within their intervals before the calibration.
    target : CurveTarget
        The measured curve.
    runs : HoldoutEvaluations
        Runs of the test.
    sample : ndarray, shape (n, d)
        Parameter sets that agree with the fitted tests, in the unit cube.

    Raises
    ------
    RunFailedError
        Too few runs gave the curve at all measured points.
    """
    with one_thread():
        models = Metamodels.fit(problem.with_targets([], [_neutral(target, runs)]), runs.all)
        [basis] = models.reduction.bases
        before, _ = models.predict(qmc.Sobol(problem.dimension, rng=1).random(POINTS_OF_PRIOR))
        expected, measured = _drawn(basis, *models.predict(sample))
    prior = _Band.of(_curves(basis, before @ basis.components))
    band = _Band.of(measured)
    off = band.off(np.asarray(target.values))
    probability = float((1 + (band.off(measured) >= off).sum()) / (1 + _DRAWS))
    verdict = judge_prediction(probability, band.width, prior.width)
    return HoldoutCurve(
        coordinate=target.coordinate,
        coordinate_unit=target.coordinate_unit,
        unit=target.unit,
        coordinates=tuple(target.coordinates),
        predicted=_plain(expected.mean(axis=0)),
        standard_errors=_plain(expected.std(axis=0)),
        low=_plain(band.low),
        high=_plain(band.high),
        prior_low=_plain(prior.low),
        prior_high=_plain(prior.high),
        at_answer=tuple(map(_plain, _simulated(target, runs.at_answer))),
        measured=tuple(target.values),
        uncertainties=_plain(target.standard_uncertainties),
        probability=probability,
        verdict=verdict,
    )


@dataclass(frozen=True)
class _Band:
    """Band within which 95 % of some curves lie wholly, as many deviations wide everywhere."""

    mean: Array
    deviations: Array
    half: float

    @classmethod
    def of(cls, curves: Array) -> _Band:
        least = _ROUNDING * float(np.abs(curves).max()) or 1.0
        mean, deviations = curves.mean(axis=0), np.maximum(curves.std(axis=0), least)
        alone = cls(mean, deviations, 0.0)
        return replace(alone, half=float(np.quantile(alone.off(curves), HOLDOUT.confidence)))

    def off(self, curves: Array) -> Array:
        """Return the largest deviation of each curve from the mean, in standard deviations."""
        return np.asarray(np.abs((curves - self.mean) / self.deviations).max(axis=-1))

    @property
    def low(self) -> Array:
        return np.asarray(self.mean - self.half * self.deviations)

    @property
    def high(self) -> Array:
        return np.asarray(self.mean + self.half * self.deviations)

    @property
    def width(self) -> float:
        return float((self.high - self.low).mean())


def _neutral(target: CurveTarget, runs: HoldoutEvaluations) -> CurveTarget:
    """Return a target by the runs alone: the measured curve takes no part in the prediction.

    Its errors are those of the measurement, of which percentages are shares of what is simulated.
    """
    near = _simulated(target, [*runs.at_answer, *runs.over_posterior]) or _simulated(
        target, runs.all
    )
    if not near:
        # The metamodels say why there is none.
        return target
    mean = np.mean(near, axis=0)
    return CurveTarget(
        target.name, target.coordinates, mean.tolist(), covariance=target.covariance_about(mean)
    )


def _simulated(target: CurveTarget, evaluations: Sequence[Evaluation]) -> list[Array]:
    """Return the curves of runs at the measured points, shape (n,) each."""
    found = (
        values_at(e.curves[target.name], target.coordinates)
        for e in runs_with_curve(target, evaluations)
    )
    return [values for values in found if values is not None]


def _drawn(basis: CurveBasis, scores: Array, variances: Array) -> tuple[Array, Array]:
    """Return expected curves, and some as they could have been measured, shape (draws, n)."""
    random = np.random.default_rng(1)
    # Every parameter set as often as the others.
    chosen = np.resize(np.arange(len(scores)), _DRAWS)
    errors = np.sqrt(variances[chosen]) * random.standard_normal((_DRAWS, scores.shape[1]))
    left_out = random.standard_normal((_DRAWS, len(basis.left_out))) @ basis.left_out
    whitened = (scores[chosen] + errors) @ basis.components + left_out
    noise = random.standard_normal(whitened.shape)
    return _curves(basis, whitened), _curves(basis, whitened + noise)


def _curves(basis: CurveBasis, whitened: Array) -> Array:
    """Return curves of deviations from the mean in the space of independent errors."""
    return np.asarray(np.asarray(basis.target.values) + (basis.mean + whitened) @ basis.root.T)


def _plain(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())
