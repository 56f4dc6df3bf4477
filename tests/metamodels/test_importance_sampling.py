"""Weighted points stand for a density over the unit cube, whatever its shape."""

from collections.abc import Callable

import numpy as np
import pytest

from grainfit.metamodels.importance_sampling import (
    importance_sample,
    representatives,
    weighted_quantiles,
)

TAILS = (0.025, 0.5, 0.975)


def quantiles(log_density: Callable[[np.ndarray], np.ndarray], dimension: int) -> np.ndarray:
    sample = importance_sample(log_density, dimension, np.random.default_rng(1))
    weights = sample.weights(log_density(sample.points))
    return np.array([weighted_quantiles(x, weights, TAILS) for x in sample.points.T])


@pytest.mark.parametrize("dimension", [1, 2, 6])
def test_a_narrow_peak_is_found_with_its_width(dimension: int) -> None:
    def peak(points: np.ndarray) -> np.ndarray:
        return -0.5 * (((points - 0.4) / 0.02) ** 2).sum(axis=1)

    expected = 0.4 + 0.02 * np.array([-1.96, 0.0, 1.96])
    assert quantiles(peak, dimension) == pytest.approx(
        np.tile(expected, (dimension, 1)), abs=0.1 * 0.04
    )


def test_a_density_that_says_nothing_fills_the_cube() -> None:
    found = quantiles(lambda points: np.zeros(len(points)), 3)
    assert found == pytest.approx(np.tile(TAILS, (3, 1)), abs=0.03)


def test_a_curved_ridge_is_followed_to_its_ends() -> None:
    def circle(points: np.ndarray) -> np.ndarray:
        return -0.5 * ((np.hypot(*(points - 0.5).T) - 0.35) / 0.01) ** 2

    # Of points spread evenly over a circle, x is 0.5 + 0.35 cos of even angles.
    end = 0.35 * np.cos(np.pi * 0.025)
    for found in quantiles(circle, 2):
        assert found == pytest.approx([0.5 - end, 0.5, 0.5 + end], abs=0.03)


def test_both_of_two_peaks_are_found() -> None:
    def two(points: np.ndarray) -> np.ndarray:
        first, second = (-0.5 * (((points - c) / 0.02) ** 2).sum(axis=1) for c in (0.2, 0.8))
        return np.logaddexp(first, second)

    sample = importance_sample(two, 2, np.random.default_rng(1))
    weights = sample.weights(two(sample.points))
    assert weights[sample.points[:, 0] < 0.5].sum() == pytest.approx(0.5, abs=0.08)


def test_a_narrower_density_has_other_weights_at_the_same_points() -> None:
    def peak(points: np.ndarray, width: float) -> np.ndarray:
        return -0.5 * (((points - 0.5) / width) ** 2).sum(axis=1)

    sample = importance_sample(lambda points: peak(points, 0.1), 2, np.random.default_rng(1))
    weights = sample.weights(peak(sample.points, 0.06))
    assert weights.sum() == pytest.approx(1.0)
    low, _, high = weighted_quantiles(sample.points[:, 0], weights, TAILS)
    assert high - low == pytest.approx(2 * 1.96 * 0.06, rel=0.1)


def test_representatives_stand_for_equal_shares() -> None:
    points = np.array([[0.1], [0.2], [0.9]])
    found = representatives(points, np.array([0.5, 0.0, 0.5]), 10, np.random.default_rng(1))
    assert sorted(found[:, 0]) == [0.1] * 5 + [0.9] * 5


def test_the_same_seed_gives_the_same_points() -> None:
    first, second = (
        importance_sample(lambda points: -points.sum(axis=1), 2, np.random.default_rng(7))
        for _ in range(2)
    )
    assert np.array_equal(first.points, second.points)
