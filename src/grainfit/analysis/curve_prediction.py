"""Predict curves of a test that took no part in a calibration, from runs of it."""

from __future__ import annotations

import numpy as np

from grainfit.analysis.prediction import HoldoutEvaluations, points_of_prior
from grainfit.arrays import Array
from grainfit.metamodels.curve_reduction import CurveBasis, simulated_curves
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
        before, _ = models.predict(points_of_prior(problem.dimension))
        expected, measured = _drawn(basis, *models.predict(sample))
    prior, band = _Band(basis.curves(before @ basis.components)), _Band(measured)
    probability = band.probability(np.asarray(target.values))
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
        at_answer=tuple(map(_plain, simulated_curves(target, runs.at_answer))),
        measured=tuple(target.values),
        uncertainties=_plain(target.standard_uncertainties),
        probability=probability,
        verdict=verdict,
    )


class _Band:
    """Band within which 95 % of some curves lie wholly, as many deviations wide everywhere."""

    def __init__(self, curves: Array) -> None:
        least = _ROUNDING * float(np.abs(curves).max()) or 1.0
        self._mean, self._deviations = curves.mean(axis=0), np.maximum(curves.std(axis=0), least)
        self._off = self.off(curves)
        half = float(np.quantile(self._off, HOLDOUT.confidence)) * self._deviations
        self.low, self.high = self._mean - half, self._mean + half
        self.width = float((self.high - self.low).mean())

    def off(self, curves: Array) -> Array:
        """Return the largest deviation of each curve from the mean, in standard deviations."""
        return np.asarray(np.abs((curves - self._mean) / self._deviations).max(axis=-1))

    def probability(self, curve: Array) -> float:
        """Return the share of the curves that are as far off as another one, itself included."""
        farther = int((self._off >= self.off(curve)).sum())
        return (1 + farther) / (1 + len(self._off))


def _neutral(target: CurveTarget, runs: HoldoutEvaluations) -> CurveTarget:
    """Return a target by the runs alone: the measured curve takes no part in the prediction.

    Its errors are those of the measurement, of which percentages are shares of what is simulated.
    """
    near = simulated_curves(target, [*runs.at_answer, *runs.over_posterior])
    near = near or simulated_curves(target, runs.all)
    if not near:
        # The metamodels say why there is none.
        return target
    mean = np.mean(near, axis=0)
    return CurveTarget(
        target.name, target.coordinates, mean.tolist(), covariance=target.covariance_about(mean)
    )


def _drawn(basis: CurveBasis, scores: Array, variances: Array) -> tuple[Array, Array]:
    """Return expected curves, and some as they could have been measured, shape (draws, n)."""
    random = np.random.default_rng(1)
    # Every parameter set as often as the others.
    chosen = np.resize(np.arange(len(scores)), _DRAWS)
    errors = np.sqrt(variances[chosen]) * random.standard_normal((_DRAWS, scores.shape[1]))
    left_out = random.standard_normal((_DRAWS, len(basis.left_out))) @ basis.left_out
    whitened = (scores[chosen] + errors) @ basis.components + left_out
    noise = random.standard_normal(whitened.shape)
    return basis.curves(whitened), basis.curves(whitened + noise)


def _plain(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())
