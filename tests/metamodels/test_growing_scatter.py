"""Scatter that changes over the intervals."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from grainfit.metamodels.growing_scatter import GrowingScatter, find_growing_scatter
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.outliers import fit_without_outliers


@cache
def fitted(seed: int, low: float, high: float, n: int = 30):
    random = np.random.default_rng(seed)
    points = random.random((n, 2))
    scatter = low + (high - low) * points[:, 0]
    values = 50 + 6 * points[:, 0] + 3 * points[:, 1] + scatter * random.standard_normal(n)
    return fit_without_outliers(points, values, np.zeros(n))[0]


def test_ratios_are_those_of_the_variances() -> None:
    known = GrowingScatter(np.array([2.0, 0.0]), 0.5)
    assert known.ratios(np.array([[0.5, 0.1], [1.0, 0.9]])) == pytest.approx(np.exp([0.5, 1.5]))


def test_scatter_that_grows_tenfold_is_found_and_its_size_follows() -> None:
    models = [fitted(seed, 0.15, 1.5) for seed in range(12)]
    growing = [model for model in models if model.scatter is not None]
    assert len(growing) >= 8
    ends = np.array([[0.1, 0.5], [0.9, 0.5]])
    ratios = [np.sqrt(np.divide(*model.scatter_at(ends)[::-1])) for model in growing]
    # In truth 1.365 / 0.285 = 4.8.
    assert 2.5 < np.median(ratios) < 8


def test_scatter_that_is_the_same_everywhere_stays_so() -> None:
    # 2 to 4 % of the responses: 7 or more of 60 have a chance below 1 %.
    assert sum(fitted(seed, 0.5, 0.5, 20).scatter is not None for seed in range(60)) <= 6


def test_intervals_are_narrow_where_the_scatter_is_small() -> None:
    model = next(m for m in (fitted(seed, 0.15, 1.5) for seed in range(12)) if m.scatter)
    calm, wild = model.predict([[0.15, 0.5], [0.85, 0.5]]).standard_error
    assert calm < 0.85 * wild


def test_equal_residuals_and_few_runs_say_nothing() -> None:
    points = np.random.default_rng(1).random((20, 2))
    assert find_growing_scatter(points, np.zeros(20)) is None
    assert find_growing_scatter(points[:6], np.arange(6.0)) is None


def test_scatter_of_many_parameters_is_not_said_to_change_by_chance() -> None:
    # Eight slopes that are fitted to the scatter gain much by chance.
    found = 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        points = random.random((40, 8))
        values = points @ random.standard_normal(8) + random.standard_normal(40)
        found += fit_without_outliers(points, values, np.zeros(40))[0].scatter is not None
    assert found <= 3


def test_half_of_the_intervals_without_scatter_is_found() -> None:
    # A third of the runs at one place, as a search puts them there.
    answer = np.array([0.3, 0.5])
    ends = np.array([[0.9, 0.5], [0.1, 0.5]])
    ratios = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        points = random.random((24, 2))
        points[:8] = answer + 0.01 * random.standard_normal((8, 2))
        scatter = (points[:, 0] > 0.5) * random.standard_normal(24)
        values = 50 + 6 * points[:, 0] + 3 * points[:, 1] + 4 * (points[:, 1] - 0.5) ** 2 + scatter
        model = Kriging.fit(points, values, scatter_may_vary=True)
        if model.scatter is not None:
            ratios.append(np.sqrt(np.divide(*model.scatter_at(ends))))
    assert len(ratios) >= 10
    # With one round of fits 8.
    assert np.median(ratios) > 12
