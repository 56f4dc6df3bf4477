"""Predict responses of a test that took no part in a calibration, from runs of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr
from scipy.stats import qmc

from grainfit.arrays import Array
from grainfit.evaluation import Evaluation
from grainfit.metamodels.metamodels import Metamodels
from grainfit.one_thread import one_thread
from grainfit.problem import Problem, Target
from grainfit.result import HoldoutResponse
from grainfit.verdict.holdout import judge_prediction
from grainfit.verdict.options import HOLDOUT

_POINTS_OF_PRIOR = 1024
#: Bisections of a quantile: each halves its error.
_BISECTIONS = 60
#: Smallest standard error, over the size of the responses: of a model without any scatter.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class HoldoutEvaluations:
    """Runs of a hold-out.

    Parameters
    ----------
    at_answer, over_posterior, over_prior : sequence of Evaluation
        At the answer, at parameter sets that agree with the fitted tests, and over the intervals.
    """

    at_answer: Sequence[Evaluation]
    over_posterior: Sequence[Evaluation]
    over_prior: Sequence[Evaluation]

    @property
    def all(self) -> list[Evaluation]:
        """All of them."""
        return [*self.at_answer, *self.over_posterior, *self.over_prior]


def predict_response(
    problem: Problem,
    name: str,
    runs: HoldoutEvaluations,
    sample: Array,
    target: Target | None = None,
    unit: str = "",
) -> HoldoutResponse:
    """Predict a response over a sample of parameter sets, and compare it with a measured value.

    A metamodel of the runs, which knows the scatter from run to run, gives expected response and
    standard error at every parameter set of the sample; their mixture is the prediction.

    Parameters
    ----------
    problem : Problem
        With the parameters that the test depends on, within their intervals before the calibration.
    name : str
        Name of the response.
    runs : HoldoutEvaluations
        Runs of the test.
    sample : ndarray, shape (n, d)
        Parameter sets that agree with the fitted tests, in the unit cube.
    target : Target, optional
        Measured value.
    unit : str
        Unit of the response, where there is no target.

    Raises
    ------
    RunFailedError
        Too few runs gave the response.
    """
    values = np.array([e.responses[name].value for e in runs.all if name in e.responses])
    size = float(np.abs(values).max(initial=0.0)) or 1.0
    with one_thread():
        models = Metamodels.fit(problem.with_targets([_neutral(name, values, target)]), runs.all)
        before, _ = models.predict(points_of_prior(problem.dimension))
        means, variances = (found[:, 0] for found in models.predict(sample))
    errors = np.sqrt(np.maximum(variances, (_ROUNDING * size) ** 2))
    tail = (1 - HOLDOUT.confidence) / 2
    low, high = np.quantile(before[:, 0], [tail, 1 - tail])
    found = HoldoutResponse(
        target.unit if target else unit,
        float(means.mean()),
        math.sqrt(float((errors**2).mean() + means.var())),
        _interval(means, errors),
        (float(low), float(high)),
        _values(name, runs.at_answer),
        _values(name, runs.over_posterior),
        _values(name, runs.over_prior),
    )
    return found if target is None else _compared(found, target, means, errors)


def points_of_prior(dimension: int) -> Array:
    """Return points spread over the intervals of the parameters, shape (n, d)."""
    return np.asarray(qmc.Sobol(dimension, rng=1).random(_POINTS_OF_PRIOR))


def _neutral(name: str, values: Array, target: Target | None) -> Target:
    """Return a target by the runs alone: the measured value takes no part in the prediction."""
    middle = float(values.mean()) if len(values) else 1.0
    spread = float(values.std()) if len(values) else 1.0
    width = max(spread, _ROUNDING * abs(middle)) or 1.0
    return Target(name, middle, width, statistic=target.statistic if target else "mean")


def _compared(
    found: HoldoutResponse, target: Target, means: Array, errors: Array
) -> HoldoutResponse:
    uncertainty = target.standard_uncertainty
    whole = np.hypot(errors, uncertainty)
    below = _share_below(target.value, means, whole)
    probability = 2 * min(below, 1 - below)
    interval = _interval(means, whole)
    verdict = judge_prediction(
        probability, interval[1] - interval[0], found.prior[1] - found.prior[0]
    )
    return replace(
        found,
        interval=interval,
        measured=target.value,
        uncertainty=uncertainty,
        probability=probability,
        verdict=verdict,
    )


def _interval(means: Array, errors: Array) -> tuple[float, float]:
    tail = (1 - HOLDOUT.confidence) / 2
    return _quantile(tail, means, errors), _quantile(1 - tail, means, errors)


def _quantile(share: float, means: Array, errors: Array) -> float:
    """Return a quantile of a mixture of normal distributions, by bisection."""
    low, high = float((means - 10 * errors).min()), float((means + 10 * errors).max())
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        below = _share_below(middle, means, errors) < share
        low, high = (middle, high) if below else (low, middle)
    return (low + high) / 2


def _share_below(value: float, means: Array, errors: Array) -> float:
    return float(ndtr((value - means) / errors).mean())


def _values(name: str, evaluations: Sequence[Evaluation]) -> tuple[float, ...]:
    return tuple(e.responses[name].value for e in evaluations if name in e.responses)
