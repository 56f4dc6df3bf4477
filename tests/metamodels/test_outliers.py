"""Outlying runs: found, kept out of the surface, and counted in the expectation."""

from __future__ import annotations

import numpy as np
import pytest

from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.outliers import Outliers, fit_without_outliers
from grainfit.problem import Parameter, Problem, Target

RUNS = 24


def runs(seed: int, scatter: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    points = random.random((RUNS, 2))
    values = 50 + 6 * points[:, 0] + 3 * points[:, 1] + scatter * random.standard_normal(RUNS)
    return points, values


def found_in(points: np.ndarray, values: np.ndarray) -> tuple[int, ...]:
    return fit_without_outliers(points, values, np.zeros(len(values)))[1].indices


def test_a_jammed_run_is_found_and_leaves_the_surface_as_it_is() -> None:
    found = 0
    for seed in range(12):
        points, values = runs(seed)
        jammed = values.copy()
        jammed[5] -= 8.0
        model, outliers = fit_without_outliers(points, jammed, np.zeros(RUNS))
        if outliers.indices == (5,):
            found += 1
            clean = fit_without_outliers(
                np.delete(points, 5, 0), np.delete(values, 5), np.zeros(23)
            )
            assert model.predict(points).mean == pytest.approx(clean[0].predict(points).mean)
            assert outliers.residuals == pytest.approx([-8.0], abs=2.5)
    assert found >= 10


def test_normal_scatter_has_hardly_ever_an_outlier() -> None:
    # 0.5 % of the responses: 3 or more of 25 have a chance below 0.001.
    assert sum(bool(found_in(*runs(seed))) for seed in range(25)) <= 2


def test_runs_that_agree_at_one_place_are_no_outliers() -> None:
    points, values = runs(3, scatter=0.1)
    points[:3] = 0.5
    values[:3] = 59.0 + np.array([-0.05, 0.0, 0.05])
    assert found_in(points, values) == ()


def test_a_share_that_is_the_same_everywhere_shifts_by_the_mean_over_all_runs() -> None:
    points = np.random.default_rng(2).random((200, 2))
    jams = tuple(range(0, 200, 5))
    found = Outliers(jams, (-10.0,) * 40, tuple(map(tuple, points.tolist())))
    shift, variance = found.shift_at(np.array([[0.3, 0.6], [0.8, 0.2]]))
    # A fifth of the runs. The error is at least that of a counted share: that it is the same
    # everywhere is not known.
    assert shift == pytest.approx([-2.0, -2.0], abs=0.4)
    least = 10 * np.sqrt(0.2 * 0.8 / 200)
    assert (np.sqrt(variance) > least).all()
    assert (np.sqrt(variance) < 3 * least).all()


def test_jams_of_one_region_shift_nothing_elsewhere() -> None:
    points = np.random.default_rng(3).random((40, 2))
    in_corner = np.flatnonzero(points.min(axis=1) > 0.6)
    found = Outliers(
        tuple(in_corner.tolist()), (-10.0,) * len(in_corner), tuple(map(tuple, points.tolist()))
    )
    (there, elsewhere), (_, variance) = found.shift_at(np.array([[0.8, 0.8], [0.2, 0.3]]))
    assert there < -6
    assert abs(elsewhere) < 0.6
    assert np.sqrt(variance) < 1.0


def test_runs_at_a_point_shrink_what_is_unknown_of_jams_there() -> None:
    points = np.random.default_rng(5).random((20, 1))
    found = Outliers((3,), (-8.0,), tuple(map(tuple, points.tolist())))
    one, many = found.shrinking_at(np.array([0.5]), np.array([1.0, 100.0]))
    assert 0.5 < one < 1
    assert many < 0.2


def test_a_jam_does_not_come_again_and_a_regime_does() -> None:
    random = np.random.default_rng(8)
    points = np.vstack([0.7 * random.random((22, 1)), [[0.9], [0.9]]])
    points[0] = 0.2
    values = 50 + 6 * points[:, 0] + 0.1 * random.standard_normal(24)
    jammed = values.copy()
    jammed[23] -= 9.0
    found = fit_without_outliers(points, jammed, np.zeros(24))[1]
    assert found.indices == (23,)
    assert (found.repeated, found.came_again, found.alone.any()) == (1, 0, False)
    # Both runs there: so it is the response of that place, and a jam elsewhere stays one.
    jammed[22] -= 9.0
    jammed[0] -= 9.0
    model, found = fit_without_outliers(points, jammed, np.zeros(24))
    assert found.indices == (0,)
    assert model.predict([[0.9]]).mean[0] == pytest.approx(values[23] - 9.0, abs=1.0)


def jamming(statistic: str) -> Metamodels:
    points, values = runs(1)
    values[[4, 9, 15]] -= 8.0
    problem = Problem(
        [Parameter("x", 0, 1), Parameter("y", 0, 1)],
        [Target("flow", 54.0, tolerance=0.8, statistic=statistic)],
    )
    evaluations = [
        Evaluation(Proposal({"x": x, "y": y}, i, "design"), {"flow": Response(v)}, {})
        for i, ((x, y), v) in enumerate(zip(points, values, strict=True))
    ]
    return Metamodels.fit(problem, evaluations)


def test_an_expected_response_has_the_jams_of_the_laboratory_in_it() -> None:
    mean, median = jamming("mean"), jamming("median")
    assert mean.outliers[0].seeds == (4, 9, 15)
    at = [[0.5, 0.5]]
    assert mean.predict(at)[0] == pytest.approx(median.predict(at)[0] - 1.0, abs=0.4)
    assert mean.predict(at)[1] > median.predict(at)[1]


def test_without_outliers_the_probability_is_that_of_the_median() -> None:
    mean, median = jamming("mean"), jamming("median")
    at = [[0.5, 0.5]]
    assert mean.probability_without_outliers(at) == pytest.approx(median.probability_all_met(at))
    assert mean.probability_all_met(at) != pytest.approx(median.probability_all_met(at), abs=0.1)


def test_many_runs_lose_only_their_jams() -> None:
    # Beyond 60 runs, metamodels are fitted only without runs that look suspicious.
    random = np.random.default_rng(4)
    points = random.random((90, 3))
    values = 50 + points @ [6, 3, 0] + np.sin(3 * points[:, 2]) + 0.5 * random.standard_normal(90)
    assert found_in(points, values) == ()
    jams = (3, 11, 40, 66, 89)
    values[list(jams)] -= random.uniform(4.0, 9.0, len(jams))
    assert found_in(points, values) == jams
