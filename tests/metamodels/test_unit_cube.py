"""Searches of the unit cube: they find the best point, and never leave the cube."""

import numpy as np
import pytest

from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import (
    gauss_newton,
    points_about,
    shrinking_search,
    smallest,
    spread_points,
)
from grainfit.problem import Parameter, Problem, Target


def smooth(points: np.ndarray) -> np.ndarray:
    """Two responses that take each pair of values once."""
    x, y = points.T
    return np.column_stack([2.0 + np.sin(1.2 * x) + 0.3 * y, 3.0 + np.exp(0.8 * y) - 0.2 * x])


def metamodels(targets: np.ndarray) -> Metamodels:
    points = spread_points(24, 2, np.random.default_rng(1))
    problem = Problem(
        [Parameter("x", 0.0, 1.0), Parameter("y", 0.0, 1.0)],
        [Target(f"response {i}", value, tolerance=0.05) for i, value in enumerate(targets)],
    )
    return Metamodels(problem, [Kriging.fit(points, values) for values in smooth(points).T])


STARTS = spread_points(8, 2, np.random.default_rng(2))


@pytest.mark.parametrize("root", [(0.5, 0.5), (0.2, 0.7), (0.9, 0.15)])
def test_gauss_newton_finds_the_point_that_meets_all_targets(root: tuple[float, float]) -> None:
    point = np.array(root)
    known = metamodels(smooth(point[None])[0])
    found = gauss_newton(known, STARTS)
    deviations = known.deviations(found)[0]
    # From most starts it comes to the point, and none gets worse.
    squares, before = ((d**2).sum(axis=1) for d in (deviations, known.deviations(STARTS)[0]))
    assert (squares <= before).all()
    assert np.median(squares) < 1e-8
    # The metamodels themselves are not exact.
    assert found[squares.argmin()] == pytest.approx(point, abs=0.01)


def test_gauss_newton_stays_in_the_cube_where_the_target_lies_beyond() -> None:
    known = metamodels(smooth(np.array([[1.3, 0.5]]))[0])
    found = gauss_newton(known, STARTS)
    assert ((found >= 0.0) & (found <= 1.0)).all()
    best = found[known.misfit(found).argmin()]
    assert best[0] == 1.0
    grid = np.column_stack([np.ones(201), np.linspace(0.0, 1.0, 201)])
    squares = [(known.deviations(p)[0] ** 2).sum(axis=1) for p in (best, grid)]
    assert squares[0][0] <= squares[1].min() + 1e-6


def test_gauss_newton_leaves_its_starts_alone() -> None:
    starts = STARTS.copy()
    gauss_newton(metamodels(smooth(np.array([[0.5, 0.5]]))[0]), starts)
    assert (starts == STARTS).all()


@pytest.mark.parametrize("dimension", [1, 2, 5])
def test_a_shrinking_search_comes_close_to_the_minimum(dimension: int) -> None:
    minimum = np.linspace(0.2, 0.8, dimension)

    def distance(points: np.ndarray) -> np.ndarray:
        # A kink, as derivatives are not needed.
        return np.abs(points - minimum).sum(axis=1)

    random = np.random.default_rng(3)
    starts = spread_points(32, dimension, random)
    points, values = shrinking_search(distance, starts, random, rounds=6)
    assert points.shape == (4, dimension)
    assert values == pytest.approx(distance(points))
    assert (np.diff(values) >= 0).all()
    assert values[0] < 0.25 * distance(starts).min()


def test_a_shrinking_search_finds_a_corner_and_stays_in_the_cube() -> None:
    random = np.random.default_rng(4)
    points, _ = shrinking_search(
        lambda p: -p.sum(axis=1), spread_points(16, 3, random), random, width=0.3
    )
    assert ((points >= 0.0) & (points <= 1.0)).all()
    assert points[0].sum() == 3.0


def test_a_shrinking_search_loses_no_good_start() -> None:
    def needle(points: np.ndarray) -> np.ndarray:
        return -(np.abs(points - 0.123456).max(axis=1) < 1e-9).astype(float)

    starts = np.vstack([spread_points(16, 2, np.random.default_rng(5)), [[0.123456] * 2]])
    points, values = shrinking_search(needle, starts, np.random.default_rng(5))
    assert values[0] == -1.0
    assert (points[0] == 0.123456).all()


def test_spread_points_leave_no_large_gap() -> None:
    points = spread_points(64, 2, np.random.default_rng(6))
    counts, _, _ = np.histogram2d(*points.T, bins=4, range=[[0, 1], [0, 1]])
    assert points.shape == (64, 2)
    assert (counts == 4).all()


def test_points_about_a_centre_stay_in_the_cube_and_move_some_axes_only() -> None:
    centres = np.full((2, 12), 0.95)
    points = points_about(centres, 200, 0.2, np.random.default_rng(7))
    assert points.shape == (400, 12)
    assert ((points >= 0.0) & (points <= 1.0)).all()
    unmoved = (points == 0.95).mean()
    assert 0.4 < unmoved < 0.6


def test_smallest_sorts_by_value() -> None:
    points, values = smallest(lambda p: p[:, 0], np.array([[3.0], [1.0], [2.0]]), 2)
    assert points.tolist() == [[1.0], [2.0]]
    assert values.tolist() == [1.0, 2.0]
