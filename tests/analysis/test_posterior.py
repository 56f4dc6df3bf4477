"""The posterior sample against closed forms."""

import itertools
import math

import numpy as np
import pytest
from given_metamodels import Given, given, unit_parameters
from scipy.stats import truncnorm

from grainfit.analysis import messages
from grainfit.analysis.ensemble import sample_cube
from grainfit.analysis.posterior import Posterior, sample_posterior
from grainfit.errors import InputError
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Parameter, Problem, Target


def assert_normal(posterior: Posterior, mean: np.ndarray, covariance: np.ndarray) -> None:
    """Within five standard errors of so many independent samples."""
    count = posterior.effective_samples
    deviation = np.sqrt(np.diag(covariance))
    off = (posterior.points.mean(axis=0) - mean) / deviation
    assert np.abs(off).max() < 5.0 / math.sqrt(count)
    scaled = np.cov(posterior.points, rowvar=False) / np.outer(deviation, deviation)
    wanted = covariance / np.outer(deviation, deviation)
    assert np.abs(scaled - wanted).max() < 5.0 * math.sqrt(2.0 / count)
    for axis, name in enumerate(posterior.names):
        ends = mean[axis] + 1.96 * deviation[axis] * np.array([-1.0, 1.0])
        # The density there is 0.058 per standard deviation.
        error = math.sqrt(0.025 * 0.975 / count) / 0.058 * deviation[axis]
        assert np.abs(np.array(posterior.interval(name)) - ends).max() < 5.0 * error


def test_a_linear_problem_has_the_normal_posterior_of_least_squares() -> None:
    """The metamodel's variance counts like that of the measurement."""
    slopes = np.array([[10.0, 4.0], [-3.0, 8.0], [5.0, 5.0]])
    truth = np.array([0.4, 0.6])
    uncertainties, errors = np.array([0.6, 0.3, 0.8]), np.array([0.8, 0.4, 0.6])
    targets = [
        Target(f"y{i}", 20.0 + slopes[i] @ truth, uncertainty=uncertainties[i]) for i in range(3)
    ]
    models = [Given(lambda x, s=slopes[i]: 20.0 + x @ s, errors[i] ** 2) for i in range(3)]
    posterior = sample_posterior(given(targets, models, 2))
    weights = 1.0 / (uncertainties**2 + errors**2)
    covariance = np.linalg.inv(slopes.T @ (weights[:, None] * slopes))
    assert posterior.converged, posterior.convergence
    assert posterior.effective_samples >= 1000
    assert_normal(posterior, truth, covariance)
    np.testing.assert_allclose(posterior.responses, 20.0 + posterior.points @ slopes.T)
    assert abs(posterior.correlations[0, 1] - posterior.correlations[1, 0]) < 1e-12


def test_a_measurement_of_a_parameter_counts_like_one_of_a_response() -> None:
    """The uncertainty of a measured parameter is part of the interval of the other one."""
    measured = Parameter("x1", 0.0, 1.0, measured=0.55, uncertainty=0.08)
    slope, uncertainty = np.array([20.0, 14.0]), 0.5
    target = Target("y", 20.0 + slope @ [0.5, 0.55], uncertainty=uncertainty)
    problem = Problem([Parameter("x0", 0.0, 1.0), measured], [target])
    metamodels = Metamodels(problem, [Given(lambda x: 20.0 + x @ slope)])
    precision = np.outer(slope, slope) / uncertainty**2 + np.diag([0.0, 1 / 0.08**2])

    posterior = sample_posterior(metamodels)

    assert posterior.converged, posterior.convergence
    assert_normal(posterior, np.array([0.5, 0.55]), np.linalg.inv(precision))


def test_a_point_of_which_little_is_known_does_not_look_good_for_that() -> None:
    """The response meets its target everywhere; its variance is 3 more in one half.

    The standard deviation is twice as large there, so the density is half as large.
    """
    model = Given(lambda x: np.full(len(x), 10.0), lambda x: np.where(x[:, 0] > 0.5, 3.0, 0.0))
    posterior = sample_posterior(given([Target("y", 10.0, uncertainty=1.0)], [model], 1))
    share = float(np.mean(posterior.points < 0.5))
    assert share == pytest.approx(2 / 3, abs=5 * math.sqrt(2 / 9 / posterior.effective_samples))


@pytest.mark.parametrize("dimension", [1, 14])
def test_where_nothing_is_determined_the_sample_is_the_whole_cube(dimension: int) -> None:
    model = Given(lambda x: 10.0 + 1e-9 * x.sum(axis=1), 1.0)
    posterior = sample_posterior(given([Target("y", 10.0)], [model], dimension))
    assert posterior.converged, posterior.convergence
    error = 5.0 / math.sqrt(posterior.effective_samples)
    for name in posterior.names:
        low, high = np.quantile(posterior.points[:, posterior.names.index(name)], [0.025, 0.975])
        assert abs(low - 0.025) < 0.16 * error
        assert abs(high - 0.975) < 0.16 * error
        assert posterior.interval(name) == (0.0, 1.0)
        assert abs(posterior.median(name) - 0.5) < 0.5 * error
    off_diagonal = posterior.correlations - np.eye(dimension)
    assert np.abs(off_diagonal).max() < error


def test_a_point_of_a_ten_thousandth_of_the_intervals_is_found() -> None:
    truth, width = np.array([0.123456, 0.654321, 0.777777]), 1e-4
    targets = [Target(f"y{i}", 5.0 + truth[i], uncertainty=width) for i in range(3)]
    models = [Given(lambda x, i=i: 5.0 + x[:, i]) for i in range(3)]
    posterior = sample_posterior(given(targets, models, 3))
    assert posterior.converged, posterior.convergence
    assert_normal(posterior, truth, width**2 * np.eye(3))


def test_a_value_beyond_a_bound_gives_the_truncated_distribution() -> None:
    model = Given(lambda x: 10.0 + x[:, 0])
    posterior = sample_posterior(given([Target("y", 9.95, uncertainty=0.05)], [model], 1))
    wanted = truncnorm(1.0, math.inf, loc=-0.05, scale=0.05)
    assert posterior.median("x0") == pytest.approx(wanted.median(), rel=0.15)
    assert posterior.interval("x0", 0.8)[1] == pytest.approx(wanted.ppf(0.9), rel=0.1)
    assert posterior.points.min() >= 0.0


def test_a_curved_ridge_is_followed_to_both_its_ends() -> None:
    """x0 x1 = 0.25: the marginal density of each is 1/x from 0.25 to 1, so its median is 0.5."""
    model = Given(lambda x: x[:, 0] * x[:, 1])
    posterior = sample_posterior(given([Target("y", 0.25, uncertainty=0.004)], [model], 2))
    assert posterior.converged, posterior.convergence
    for name in posterior.names:
        assert posterior.median(name) == pytest.approx(0.5, abs=0.05)
        low, high = posterior.interval(name)
        assert low == pytest.approx(0.25 * 4**0.025, abs=0.02)
        # The ridge ends at this bound.
        assert high == 1.0
    assert posterior.correlations[0, 1] < -0.98


def test_peaks_that_are_apart_get_their_shares() -> None:
    """One of three peaks is a quarter as steep, so it holds four times as much of the sample."""

    def response(x: np.ndarray) -> np.ndarray:
        return 10.0 + np.where(x[:, 0] < 0.6, np.abs(x[:, 0] - 0.3) - 0.2, (x[:, 0] - 0.8) / 4.0)

    posterior = sample_posterior(
        given([Target("y", 10.0, uncertainty=0.002)], [Given(response)], 1)
    )
    x = posterior.points[:, 0]
    shares = [np.mean(x < 0.3), np.mean((x > 0.3) & (x < 0.6)), np.mean(x > 0.6)]
    assert posterior.converged, posterior.convergence
    assert shares == pytest.approx([1 / 6, 1 / 6, 4 / 6], abs=0.1)


def test_values_are_in_si_and_a_logarithmic_scale_is_even_in_magnitudes() -> None:
    problem = Problem(
        [Parameter("E", 1e6, 1e8, "log"), Parameter("mu", 0.2, 0.6)], [Target("y", 10.0)]
    )
    metamodels = Metamodels(problem, [Given(lambda x: np.full(len(x), 10.0))])
    posterior = sample_posterior(metamodels, samples=1000)
    assert posterior.points.shape == posterior.values.shape == (1000, 2)
    assert posterior.median("E") == pytest.approx(1e7, rel=0.3)
    assert posterior.interval("mu", 0.5) == pytest.approx((0.3, 0.5), abs=0.03)
    with pytest.raises(InputError, match=messages.NO_PARAMETER.matching(given="nu")):
        posterior.median("nu")
    with pytest.raises(InputError, match=messages.BAD_LEVEL.pattern):
        posterior.interval("mu", 95)


def test_the_same_seed_gives_the_same_sample() -> None:
    metamodels = given([Target("y", 0.5)], [Given(lambda x: x[:, 0])], 1)
    samples = []
    for seed in (1, 1, 2):
        samples.append(sample_posterior(metamodels, seed=seed, samples=200).points)
        # What others draw makes no difference.
        np.random.random()
    first, second, other = samples
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)


def test_too_few_steps_are_said_to_be_too_few() -> None:
    model = Given(lambda x: x[:, 0] * x[:, 1])
    metamodels = given([Target("y", 0.25, uncertainty=0.002)], [model], 2)
    posterior = sample_posterior(metamodels, max_steps=10)
    assert not posterior.converged
    assert "Not converged" in posterior.convergence
    assert posterior.effective_samples < 1000


def test_a_tolerance_alone_is_read_as_an_interval_of_95_percent() -> None:
    assert Target("y", 30.0, uncertainty=0.4, tolerance=2.0).standard_uncertainty == 0.4
    assert Target("y", 30.0, tolerance=0.98).standard_uncertainty == pytest.approx(0.5)
    assert Target("y", 98.0).standard_uncertainty == pytest.approx(1.0)


def test_credible_intervals_of_95_percent_hold_the_truth_as_often_as_they_say() -> None:
    """30 calibrations with 12 noisy runs and a measurement with an error each.

    Were it 95 %, fewer than 25 of them would be right once in 300 times.
    """
    inside, widths = 0, []
    for repetition in range(30):
        random = np.random.default_rng(repetition)
        truth = random.uniform(0.2, 0.8)
        points = (np.arange(12) + 0.5)[:, None] / 12

        def response(x: np.ndarray) -> np.ndarray:
            return 20.0 + 10.0 * x + 3.0 * np.sin(3.0 * x)

        values = response(points[:, 0]) + random.normal(0.0, 0.6, 12)
        target = Target("y", response(truth) + random.normal(0.0, 0.5), uncertainty=0.5)
        problem = Problem(unit_parameters(1), [target])
        metamodels = Metamodels(problem, [Kriging.fit(points, values).reduced(2)])
        low, high = sample_posterior(metamodels, samples=800, max_steps=50).interval("x0")
        inside += low <= truth <= high
        widths.append(high - low)
    assert inside >= 25
    assert np.median(widths) < 0.3


def test_an_interrupt_of_the_sampling_is_passed_on_without_a_word(
    capfd: pytest.CaptureFixture[str],
) -> None:
    calls = itertools.count()

    def log_density(points: np.ndarray) -> np.ndarray:
        if next(calls) == 20:
            raise KeyboardInterrupt
        return -0.5 * ((points[:, 0] - 0.5) / 0.1) ** 2

    with pytest.raises(KeyboardInterrupt):
        sample_cube(log_density, 1, seed=1, samples=100, max_steps=1000)
    assert capfd.readouterr() == ("", "")
