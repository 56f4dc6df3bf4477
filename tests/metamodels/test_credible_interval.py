"""Credible intervals hold true values inside the unit cube and on its bounds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import truncnorm

from grainfit.metamodels.credible_interval import extended_to_bounds
from grainfit.metamodels.importance_sampling import importance_sample, weighted_quantiles

TAILS = (0.025, 0.975)
Array = np.ndarray


def share_inside(truth: Array, low: Array, high: Array) -> float:
    return float(np.mean((low <= truth) & (truth <= high)))


def ends_of_truncated(measured: Array, error: float) -> tuple[Array, Array]:
    """Equal-tailed intervals of a parameter that was measured with a normal error."""
    cut = (-measured / error, (1.0 - measured) / error)
    low, high = (truncnorm.ppf(tail, *cut, loc=measured, scale=error) for tail in TAILS)
    return low, high


@pytest.mark.parametrize("error", [0.01, 0.1, 0.3, 1.0])
@pytest.mark.parametrize("distance", [0.0, 0.2, 0.5, 1.0, 2.0, 3.0])
def test_a_true_value_at_any_distance_from_a_bound_is_held(error: float, distance: float) -> None:
    """10,000 measurements: a share of 0.95 is known to 0.007 at three standard errors."""
    truth = np.full(10_000, min(distance * error, 0.5))
    measured = truth + error * np.random.default_rng(1).standard_normal(len(truth))
    equal_tailed = ends_of_truncated(measured, error)
    held = share_inside(truth, *extended_to_bounds(*equal_tailed))
    assert held >= share_inside(truth, *equal_tailed)
    assert held >= 0.943
    if distance == 0.0:
        # A measurement as rough as the whole interval excludes next to nothing.
        assert held <= (0.99 if error < 1.0 else 1.0)
        assert share_inside(truth, *equal_tailed) == 0.0
        # On the other bound just as well.
        low, high = extended_to_bounds(1.0 - equal_tailed[1], 1.0 - equal_tailed[0])
        assert share_inside(1.0 - truth, low, high) == held


@pytest.mark.parametrize(
    ("on_bounds", "least", "most"),
    [(0, 0.93, 0.98), pytest.param(1, 0.9, 1, marks=pytest.mark.thorough), (2, 0.9, 1)],
)
def test_parameters_of_linear_and_curved_responses_are_held(
    on_bounds: int, least: float, most: float
) -> None:
    """120 posteriors of one to four parameters, with ridges: 120 to 300 intervals.

    Were the share on bounds 0.95, fewer than 0.9 would be held once in 100 times. Equal-tailed
    intervals hold none of them.
    """
    held = []
    for seed in range(120):
        random = np.random.default_rng([seed, on_bounds])
        dimension = int(random.integers(max(on_bounds, 1), 5))
        responses = max(dimension - int(random.random() < 0.3), 1)
        slopes, bends = random.normal(size=(2, dimension, responses)) * [[[1.0]], [[0.5]]]
        error = 10 ** random.uniform(-1.7, -0.2)
        truth = random.random(dimension)
        chosen = random.permutation(dimension)[: on_bounds or dimension]
        truth[chosen[:on_bounds]] = random.integers(2, size=on_bounds)

        def expected(points: Array, slopes: Array = slopes, bends: Array = bends) -> Array:
            return points @ slopes + points**2 @ bends

        measured = expected(truth) + error * random.standard_normal(responses)

        def log_density(points: Array, at: Array = measured, error: float = error) -> Array:
            return -0.5 * (((expected(points) - at) / error) ** 2).sum(axis=1)

        sample = importance_sample(log_density, dimension, random)
        weights = sample.weights(log_density(sample.points))
        ends = [weighted_quantiles(x, weights, TAILS) for x in sample.points.T]
        low, high = extended_to_bounds(*np.transpose(ends))
        held += [low[axis] <= truth[axis] <= high[axis] for axis in chosen]
    assert least <= np.mean(held) <= most
