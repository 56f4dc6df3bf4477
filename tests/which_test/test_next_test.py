"""Further tests ranked by what they would leave: on linear responses with a closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.problem import Parameter
from grainfit.which_test import messages
from grainfit.which_test.candidate import Candidate, CandidateResponse
from grainfit.which_test.determination import interval_of
from grainfit.which_test.next_test import Advice, OpenParameters, rank_tests
from grainfit.which_test.slopes import Cloud, Run, corners, simulated_response

SLIDING, ROLLING, RESTITUTION = (
    f"particle_particle.{name}" for name in ("sliding_friction", "rolling_friction", "restitution")
)
PARAMETERS = (
    Parameter(SLIDING, 0.05, 2.0, "log"),
    Parameter(ROLLING, 0.05, 2.0, "log"),
    Parameter(RESTITUTION, 0.2, 1.0, "log"),
)
#: Standard deviations of ln p, and the ridge between both frictions that a heap leaves.
DEVIATIONS, RIDGE = (0.5, 0.6, 0.3), -0.95
ACCURACY = Accuracy(0.02, is_share=True)


def covariance() -> np.ndarray:
    correlations = np.eye(3)
    correlations[0, 1] = correlations[1, 0] = RIDGE
    return np.outer(DEVIATIONS, DEVIATIONS) * correlations


def posterior(size: int = 4000) -> Cloud:
    random = np.random.default_rng(1)
    middle = np.log([0.4, 0.4, 0.6])
    return Cloud(PARAMETERS, random.multivariate_normal(middle, covariance(), size))


CLOUD = posterior()
POINTS = CLOUD.points[CLOUD.spread()]


def measured(
    slopes: Sequence[float],
    *,
    noise: float = 0.0,
    seeds: int = 2,
    random_seed: int = 0,
    of_seed: float = 0.0,
) -> CandidateResponse:
    """Fit a response whose logarithm is linear, with noise of runs and an offset of each seed."""
    random = np.random.default_rng(random_seed)
    runs = [
        Run(i, s, 10 * float(np.exp(p @ slopes + noise * random.normal() + of_seed * s)))
        for s in range(seeds)
        for i, p in enumerate(POINTS)
    ]
    found = simulated_response("test.response", ACCURACY, CLOUD, POINTS, runs)
    assert found is not None
    return found


def today(*names: str) -> OpenParameters:
    free = tuple(p for p in PARAMETERS if p.name in names)
    values = {p.name: 0.4 for p in free}
    intervals = {p.name: interval_of(p, 0.2, 0.8) for p in free}
    return OpenParameters(free, intervals, values, CLOUD.knowledge, 5.0)


def test_points_spread_to_both_ends_of_every_direction() -> None:
    assert len(POINTS) == 7
    whitened = np.linalg.solve(
        np.linalg.cholesky(covariance()), (POINTS - CLOUD.points.mean(axis=0)).T
    )
    # As well placed as ends of directions can be: each tells a slope over four deviations.
    assert np.linalg.svd(whitened, compute_uv=False).min() > 2.0


def test_corners_tell_every_slope_from_all_runs() -> None:
    for dimension, size in ((1, 2), (2, 4), (3, 8), (4, 8), (7, 16), (8, 16)):
        found = corners(dimension)
        assert found.shape == (size, dimension)
        assert found.T @ found == pytest.approx(size * np.eye(dimension))
        assert found.sum(axis=0) == pytest.approx(0.0)


def test_slopes_of_a_response_without_noise_are_exact() -> None:
    found = measured((0.3, -0.2, 0.1))
    assert found.slopes == pytest.approx({SLIDING: 0.3, ROLLING: -0.2, RESTITUTION: 0.1})
    assert found.scatter == pytest.approx(0.0, abs=1e-9)


def test_what_a_test_leaves_is_the_closed_form() -> None:
    slopes = np.array([0.5, -0.1, 0.0])
    test = Candidate("slide", 5.0, (measured(slopes.tolist()),))
    left = today(SLIDING, ROLLING).after([test])
    precision = np.linalg.inv(CLOUD.knowledge.covariance) + np.outer(slopes, slopes) / 0.02**2
    expected = np.sqrt(np.diag(np.linalg.inv(precision)) / np.diag(CLOUD.knowledge.covariance))
    assert left.shares == pytest.approx(dict(zip((SLIDING, ROLLING), expected[:2], strict=True)))
    interval = left.intervals[SLIDING]
    deviation = float(np.sqrt(np.linalg.inv(precision)[0, 0]))
    assert interval.low == pytest.approx(0.4 * np.exp(-1.96 * deviation))
    assert interval.high == pytest.approx(0.4 * np.exp(1.96 * deviation))


def test_an_interval_that_is_left_lies_within_that_of_today() -> None:
    now = today(SLIDING, ROLLING)
    assert now.after([]).intervals == now.intervals
    at_an_end = replace(now, values={SLIDING: 0.201, ROLLING: 0.4})
    test = Candidate("slide", 5.0, (measured((1.0, 0.0, 0.0)),))
    middle, end = (known.after([test]).intervals[SLIDING] for known in (now, at_an_end))
    assert end.low == pytest.approx(0.2)
    assert end.high / end.low == pytest.approx(middle.high / middle.low)


def test_a_response_along_the_ridge_is_recommended_and_one_across_it_is_not() -> None:
    # Across it, the heap has measured already; along it, sliding and rolling friction part.
    across = Candidate("across", 1.0, (measured((0.6, 0.5, 0.0), noise=0.01),))
    along = Candidate("along", 10.0, (measured((0.6, -0.5, 0.0), noise=0.01),))
    found = rank_tests(today(SLIDING, ROLLING), [across, along], [], 7, 2)
    assert [prospect.name for prospect in found.prospects] == ["along", "across"]
    assert found.best is found.prospects[0]
    assert found.best.settled == (SLIDING, ROLLING)
    assert found.unsettled == ()
    assert min(found.prospects[1].shares.values()) > 0.9
    assert messages.DO_NEXT.is_in(str(found), test="along")


def test_noise_is_not_taken_for_information() -> None:
    # Five responses of a test that depend on nothing, and scatter as angles do.
    shares = []
    for number in range(60):
        responses = tuple(
            measured((0, 0, 0), noise=0.05, random_seed=5 * number + i) for i in range(5)
        )
        found = today(SLIDING, ROLLING, RESTITUTION).after([Candidate("none", 1.0, responses)])
        shares += list(found.shares.values())
    assert np.mean(shares) > 0.97
    assert np.quantile(shares, 0.05) > 0.8


def test_uncertain_slopes_promise_less_and_more_seeds_more() -> None:
    slopes = (0.3, -0.3, 0.0)

    def left_by(response: CandidateResponse) -> float:
        return today(SLIDING).after([Candidate("t", 1.0, (response,))]).shares[SLIDING]

    left = {
        seeds: np.mean(
            [left_by(measured(slopes, noise=0.1, seeds=seeds, random_seed=n)) for n in range(40)]
        )
        for seeds in (1, 2, 8)
    }
    assert left[1] > left[2] > left[8]
    exact = left_by(CandidateResponse("t", 10.0, ACCURACY, {SLIDING: 0.3, ROLLING: -0.3}, 0.1))
    assert exact < left[8] < 1.2 * exact


def test_what_a_seed_does_at_all_points_is_no_scatter_of_slopes() -> None:
    found = measured((0.3, -0.2, 0.0), of_seed=0.2)
    assert found.slopes[SLIDING] == pytest.approx(0.3)
    assert found.slope_variance == pytest.approx(0.0, abs=1e-9)
    # But it is scatter from run to run.
    assert found.scatter == pytest.approx(0.2 / 2**0.5)


def test_a_response_that_changes_its_sign_is_fitted_as_it_is() -> None:
    values = 1.0 + 4 * (POINTS[:, 0] - np.log(0.4))
    runs = [Run(i, 1, float(value)) for i, value in enumerate(values)]
    found = simulated_response("y", Accuracy(0.1), CLOUD, POINTS, runs)
    assert found is not None
    assert (values < 0).any()
    assert found.slopes[SLIDING] == pytest.approx(4 / abs(values.mean()))


def test_too_few_runs_tell_nothing() -> None:
    few = [Run(i, 1, 10.0 + i) for i in range(4)]
    assert simulated_response("y", ACCURACY, CLOUD, POINTS, few) is None
    assert simulated_response("y", ACCURACY, CLOUD, POINTS, []) is None
    zeros = [Run(i, s, 0.0) for i in range(7) for s in range(2)]
    assert simulated_response("y", ACCURACY, CLOUD, POINTS, zeros) is None


def test_two_tests_that_settle_more_together_are_named() -> None:
    slide = Candidate("slide", 5.0, (measured((0.0, 0.0, 1.0)),))
    roll = Candidate("roll", 5.0, (measured((1.0, 0.0, 0.0)),))
    found = rank_tests(today(SLIDING, RESTITUTION), [slide, roll], [], 7, 2)
    assert found.best_pair is not None
    assert set(found.best_pair.settled) == {SLIDING, RESTITUTION}
    assert "leave" in str(found)


def test_what_no_test_settles_is_said_with_another_way() -> None:
    test = Candidate("draw_down", 5.0, (measured((0.6, -0.5, 0.0)),))
    found = rank_tests(
        today(SLIDING, RESTITUTION), [test], ["Not compared: compression. Too soft."], 7, 2
    )
    assert found.unsettled == (RESTITUTION,)
    text = str(found)
    assert messages.NOT_SETTLED_BY_ANY.is_in(text, name=RESTITUTION)
    assert "drop test" in text
    assert "Not compared: compression. Too soft." in text
    assert "Do next: draw_down (" in text


def test_nothing_is_recommended_where_no_test_tells_more() -> None:
    useless = Candidate("packing", 1.0, (measured((0, 0, 0), noise=0.01),))
    found = rank_tests(today(SLIDING), [useless], [], 7, 2)
    assert found.best is None
    assert messages.NOTHING_WORTH_DOING.is_in(str(found))
    assert str(Advice(today())) == "Every parameter is determined: no further test is needed."
