"""Kriging metamodel: what its predictions, intervals and warnings are worth."""

from __future__ import annotations

import json
import math
import re

import gpmp
import numpy as np
import pytest
from gpmp.kernel import maternp_covariance
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from scipy.stats import binom, chi2, qmc

from grainfit.errors import InputError
from grainfit.metamodels import messages
from grainfit.metamodels.hyperparameters import HyperparameterPosterior
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.noise_ratios import noise_ratios
from grainfit.metamodels.predictor import Contrasts, Trend, matern


def design(n: int, d: int, seed: int) -> np.ndarray:
    return qmc.LatinHypercube(d, rng=seed).random(n)


def response(points: np.ndarray) -> np.ndarray:
    """Smooth, curved, with an interaction; spread about 1."""
    first, second = points[:, 0], points[:, 1]
    return np.sin(3.0 * first) * (1.0 + second) + 0.5 * second


def noisy_runs(n: int, noise: float, seed: int, d: int = 2) -> tuple[np.ndarray, np.ndarray]:
    points = design(n, d, seed)
    scatter = np.random.default_rng(seed).normal(0.0, noise, n)
    return points, response(points) + scatter


def test_scatter_is_told_from_curvature_by_many_runs_alone() -> None:
    def told(runs: int, noise: float) -> int:
        fits = (Kriging.fit(*noisy_runs(runs, noise, seed)) for seed in range(10))
        return sum(fit.tells_scatter for fit in fits)

    # Six runs are enough for a linear trend, whose residuals may be curvature.
    assert told(6, 0.05) <= 3
    assert told(24, 0.05) >= 9
    assert told(24, 0.0) == 0


@pytest.fixture(scope="module")
def good() -> Kriging:
    return Kriging.fit(*noisy_runs(26, 0.1, 3))


# Prediction ---------------------------------------------------------------------------------


def test_without_noise_it_interpolates_and_predicts_between() -> None:
    points, values = noisy_runs(30, 0.0, 1)
    metamodel = Kriging.fit(points, values)
    at_runs = metamodel.predict(points)
    assert np.abs(at_runs.mean - values).max() < 1e-3
    between = design(500, 2, 2)
    assert np.abs(metamodel.predict(between).mean - response(between)).max() < 0.02
    assert metamodel.noise_standard_deviation < 0.005


def test_a_noisy_response_is_smoothed_not_interpolated() -> None:
    points, values = noisy_runs(60, 0.3, 4)
    at_runs = Kriging.fit(points, values).predict(points).mean
    error = math.sqrt(np.mean((at_runs - response(points)) ** 2))
    assert error < 0.5 * 0.3


def test_noise_is_recovered_within_its_confidence_interval() -> None:
    """40 points, each run twice: the differences alone fix the noise within chi-square bounds."""
    noise = 0.2
    points = np.repeat(design(40, 2, 5), 2, axis=0)
    values = response(points) + np.random.default_rng(5).normal(0.0, noise, 80)
    estimate = Kriging.fit(points, values).noise_standard_deviation
    low, high = np.sqrt(chi2.ppf([0.005, 0.995], 40) / 40)
    assert low * noise < estimate < high * noise


def test_mean_and_variance_agree_with_gpmp_at_the_same_hyperparameters() -> None:
    points, values = noisy_runs(20, 0.1, 6)
    metamodel = Kriging.fit(points, values)
    targets = design(7, 2, 7)
    component = metamodel._components[0]
    sets = component.hyperparameters

    def covariance(x, y, parameters, pairwise=False):  # type: ignore[no-untyped-def]
        own = maternp_covariance(x, y, 2, parameters, pairwise)
        return own + sets.noise_variance * np.eye(len(x)) if y is x else own

    reference = gpmp.Model(
        lambda x, _: np.column_stack([np.ones(len(x)), x]),
        covariance,
        covparam=np.append(np.log(sets.signal_variance), -np.log(sets.ranges)),
    )
    mean, variance = reference.predict(points, component.values, targets)
    own_mean, own_variance = component.predict(targets)
    np.testing.assert_allclose(own_mean, mean, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(own_variance, variance, rtol=1e-5, atol=1e-8)


def test_coverage_of_new_runs_and_of_the_expected_response() -> None:
    """30 small data sets of 12 runs; 95 % intervals, at least 90 % inside for each.

    The tests within one data set are not independent, so the bound is on the average only.
    """
    inside_run, inside_mean = [], []
    for seed in range(30):
        metamodel = Kriging.fit(*noisy_runs(12, 0.2, seed))
        targets = design(100, 2, 1000 + seed)
        truth = response(targets)
        runs = truth + np.random.default_rng(2000 + seed).normal(0.0, 0.2, 100)
        predicted = metamodel.predict(targets)
        off = np.abs(predicted.mean - runs)
        inside_run.append(np.mean(off < 1.96 * np.sqrt(predicted.variance_of_new_run)))
        off = np.abs(predicted.mean - truth)
        inside_mean.append(np.mean(off < 1.96 * predicted.standard_error))
    assert 0.90 < np.mean(inside_run) < 0.995
    assert 0.90 < np.mean(inside_mean) < 0.995


def test_variance_of_a_new_run_is_larger_by_the_scatter(good: Kriging) -> None:
    predicted = good.predict(design(50, 2, 8))
    scatter = predicted.variance_of_new_run - predicted.variance_of_mean
    np.testing.assert_allclose(scatter, scatter[0])
    assert scatter[0] >= good.noise_standard_deviation**2
    assert scatter[0] < 1.5 * good.noise_standard_deviation**2


def test_many_points_are_predicted_as_one_by_one(good: Kriging) -> None:
    points = design(9001, 2, 9)
    together = good.predict(points)
    chosen = [0, 4095, 4096, 9000]
    alone = [good.predict(points[i : i + 1]) for i in chosen]
    np.testing.assert_allclose(together.mean[chosen], [p.mean[0] for p in alone])
    np.testing.assert_allclose(
        together.variance_of_mean[chosen], [p.variance_of_mean[0] for p in alone], rtol=1e-6
    )
    assert good.predict(np.empty((0, 2))).mean.shape == (0,)


def test_the_same_runs_give_the_same_metamodel() -> None:
    runs, targets = noisy_runs(15, 0.1, 10), design(20, 2, 11)
    first, second = (Kriging.fit(*runs).predict(targets) for _ in range(2))
    np.testing.assert_array_equal(first.mean, second.mean)
    np.testing.assert_array_equal(first.variance_of_mean, second.variance_of_mean)


@pytest.mark.parametrize(
    ("scale", "shift"), [(1e-12, 0.0), (1e12, 0.0), (1e-99, 0.0), (1e99, 0.0), (-3.0, 500.0)]
)
def test_units_of_the_response_do_not_matter(good: Kriging, scale: float, shift: float) -> None:
    points, values = noisy_runs(26, 0.1, 3)
    other = Kriging.fit(points, scale * values + shift)
    targets = design(50, 2, 12)
    expected, found = good.predict(targets), other.predict(targets)
    tolerance = 1e-4 * abs(scale)
    np.testing.assert_allclose(found.mean, scale * expected.mean + shift, atol=tolerance, rtol=0)
    np.testing.assert_allclose(
        found.standard_error, abs(scale) * expected.standard_error, rtol=1e-3
    )
    assert other.noise_standard_deviation == pytest.approx(
        abs(scale) * good.noise_standard_deviation, rel=1e-3
    )


def test_the_mean_alone_is_that_of_the_prediction(good: Kriging) -> None:
    points = design(40, 2, 8)
    np.testing.assert_allclose(good.mean(points), good.predict(points).mean, rtol=1e-12)


def test_gradient_is_that_of_the_mean(good: Kriging) -> None:
    step = 1e-5
    for point in design(5, 2, 13):
        ahead = good.predict(point + step * np.eye(2)).mean
        behind = good.predict(point - step * np.eye(2)).mean
        np.testing.assert_allclose(
            good.gradients([point])[0], (ahead - behind) / (2 * step), rtol=1e-5, atol=1e-6
        )


def test_ranges_tell_the_curved_parameter_from_the_idle_one() -> None:
    points = design(40, 3, 14)
    values = np.sin(6.0 * points[:, 0]) + 0.02 * np.random.default_rng(14).normal(size=40)
    ranges = Kriging.fit(points, values).ranges
    assert ranges.shape == (3,)
    assert ranges[0] < 0.5 * ranges[1:].min()


def test_a_strongly_curved_response_is_not_taken_for_noise() -> None:
    """A search from long ranges only ends where everything is noise."""
    points = design(40, 1, 3)
    values = np.sin(40.0 * points[:, 0]) + 0.05 * np.random.default_rng(0).normal(size=40)
    metamodel = Kriging.fit(points, values)
    assert metamodel.leave_one_out().q2 > 0.8
    assert metamodel.noise_standard_deviation < 0.2


def test_variances_count_that_ranges_and_noise_are_uncertain() -> None:
    """Moments of predictions drawn from all sets of hyperparameters; 0.03 is six sigma."""
    metamodel = Kriging.fit(*noisy_runs(10, 0.3, 41))
    here = np.array([[0.9, 0.95]])
    random = np.random.default_rng(41)
    count = 100_000
    chosen = random.choice(len(metamodel._components), count, p=metamodel._weights)
    parts = [component.predict(here) for component in metamodel._components]
    means, variances = (np.array(part)[:, 0] for part in zip(*parts, strict=True))
    inflated = variances * metamodel._inflation
    drawn = random.normal(means[chosen], np.sqrt(inflated[chosen])) * metamodel._scale
    predicted = metamodel.predict(here)
    assert predicted.mean[0] - metamodel._offset == pytest.approx(drawn.mean(), abs=0.03)
    assert predicted.variance_of_mean[0] == pytest.approx(drawn.var(), rel=0.03)


# Runs at the same point ---------------------------------------------------------------------


def test_replicates_make_the_mean_surer_there() -> None:
    points, values = noisy_runs(15, 0.3, 15)
    here = np.array([[0.5, 0.5]])
    metamodel = Kriging.fit(points, values)
    replicates = response(here) + np.random.default_rng(16).normal(0.0, 0.3, 10)
    with_replicates = metamodel.condition(np.repeat(here, 10, axis=0), replicates)
    before = metamodel.predict(here).variance_of_mean[0]
    after = with_replicates.predict(here).variance_of_mean[0]
    assert after < 0.5 * before
    # Ten runs and what was known before can only be surer than the ten alone.
    new_run = metamodel.predict(here).variance_of_new_run[0]
    assert after < (new_run - before) / 10


def test_exact_duplicates_are_no_trouble() -> None:
    points = np.repeat(design(8, 2, 17), 3, axis=0)
    metamodel = Kriging.fit(points, response(points))
    assert np.abs(metamodel.predict(points).mean - response(points)).max() < 0.02


# Leave-one-out ------------------------------------------------------------------------------


@pytest.mark.parametrize("linear_trend", [True, False])
def test_leave_one_out_is_what_leaving_out_gives(linear_trend: bool) -> None:
    points, values = noisy_runs(14, 0.15, 18)
    known = np.linspace(0.0, 0.02, 14)
    whole = Kriging.fit(points, values, known, linear_trend=linear_trend)
    for component in whole._components[:3]:
        predicted, variance = component.leave_one_out()
        sets = component.hyperparameters
        for i in (0, 6, 13):
            rest = np.delete(np.arange(14), i)
            without = type(component)(
                sets,
                component.trend,
                points[rest],
                component.values[rest],
                component.known_noise[rest],
            )
            mean, of_mean = without.predict(points[i : i + 1])
            assert predicted[i] == pytest.approx(mean[0], abs=1e-7)
            own_noise = sets.noise_variance + component.known_noise[i]
            assert variance[i] == pytest.approx(of_mean[0] + own_noise, rel=1e-6)


def test_runs_left_out_one_by_one_deviate_as_from_the_others_alone() -> None:
    points, values = noisy_runs(26, 0.1, 3)
    values[[4, 9]] += 2.0
    model = Kriging.fit(points, values).reduced(1)
    others = model.leaving_out()
    others.leave_out_worst()
    others.leave_out_worst()
    [kept] = model.to_plain(factors=False)["components"]
    values = np.array(model.to_plain()["values"])
    distances = cdist(points / kept["ranges"], points / kept["ranges"])
    covariance = kept["signal_variance"] * matern(distances) + kept["noise_variance"] * np.eye(26)
    rest = np.setdiff1d(np.arange(26), [4, 9])
    trend = np.column_stack([np.ones(26), points - 0.5])
    inverse = np.linalg.inv(covariance[np.ix_(rest, rest)])
    normal = trend[rest].T @ inverse @ trend[rest]
    coefficients = np.linalg.solve(normal, trend[rest].T @ inverse @ values[rest])
    residuals = values[rest] - trend[rest] @ coefficients
    across = covariance[np.ix_([4, 9], rest)] @ inverse
    expected = trend[[4, 9]] @ coefficients + across @ residuals
    unexplained = trend[[4, 9]] - across @ trend[rest]
    variances = (
        np.diag(covariance)[[4, 9]]
        - np.einsum("ij,ij->i", across, covariance[np.ix_([4, 9], rest)])
        + np.einsum("ij,ij->i", unexplained, unexplained @ np.linalg.inv(normal))
    )
    variances *= residuals @ inverse @ residuals / (24 - 3)
    deviations = np.abs(values[[4, 9]] - expected) / np.sqrt(variances)
    assert sorted(others.deviations_of_left_out()) == pytest.approx(sorted(deviations))


def test_contrasts_turn_covariances_as_their_matrix_does() -> None:
    random = np.random.default_rng(6)
    contrasts = Contrasts.of(np.column_stack([np.ones(12), random.random((12, 3))]))
    matrix, smaller = (half + half.T for half in (random.random((12, 12)), random.random((8, 8))))
    complement = contrasts.complement
    np.testing.assert_allclose(complement.T @ complement, np.eye(8), atol=1e-12)
    np.testing.assert_allclose(
        contrasts.covariance(matrix), complement.T @ matrix @ complement, atol=1e-12
    )
    np.testing.assert_allclose(
        contrasts.spread(smaller), complement @ smaller @ complement.T, atol=1e-12
    )


def test_quality_of_a_good_metamodel(good: Kriging) -> None:
    quality = good.leave_one_out()
    _, values = noisy_runs(26, 0.1, 3)
    explained = 1 - np.sum((values - quality.predicted) ** 2) / np.sum(
        (values - values.mean()) ** 2
    )
    assert quality.q2 == pytest.approx(explained)
    assert quality.q2 > 0.9
    inside = np.abs(values - quality.predicted) <= 1.96 * quality.standard_deviation
    assert quality.coverage == pytest.approx(inside.mean())
    # 26 runs, 95 % intervals: fewer than this happens once in a thousand.
    assert quality.coverage >= binom.ppf(0.001, 26, 0.95) / 26


# More runs ----------------------------------------------------------------------------------


def test_condition_is_the_same_metamodel_with_all_runs_at_once() -> None:
    points, values = noisy_runs(20, 0.1, 19)
    first = Kriging.fit(points[:15], values[:15])
    at_once = first.condition(points[15:], values[15:])
    one_by_one = first
    for i in range(15, 20):
        one_by_one = one_by_one.condition(points[i : i + 1], values[i : i + 1])
    targets = design(30, 2, 20)
    a, b = at_once.predict(targets), one_by_one.predict(targets)
    np.testing.assert_allclose(a.mean, b.mean, atol=1e-8)
    np.testing.assert_allclose(a.variance_of_mean, b.variance_of_mean, atol=1e-8)
    assert (at_once.n, first.n) == (20, 15)
    assert at_once.noise_standard_deviation == first.noise_standard_deviation
    np.testing.assert_array_equal(at_once.ranges, first.ranges)
    for whole, part in zip(at_once._components, first._components, strict=True):
        direct = type(part)(
            part.hyperparameters,
            part.trend,
            points,
            (values - first._offset) / first._scale,
            np.zeros(20),
        )
        np.testing.assert_allclose(whole.predict(targets)[0], direct.predict(targets)[0], atol=1e-8)


def test_new_values_move_the_mean_towards_them(good: Kriging) -> None:
    here = np.array([[0.4, 0.6]])
    before = good.predict(here).mean[0]
    after = good.condition(here, [before + 1.0]).predict(here).mean[0]
    assert before + 0.02 < after < before + 1.0


def test_runs_under_way_keep_the_mean_and_shrink_the_variance(good: Kriging) -> None:
    under_way = np.array([[0.2, 0.9], [0.8, 0.1]])
    pending = good.condition_on_pending(under_way)
    targets = np.vstack([under_way, design(30, 2, 21)])
    before, after = good.predict(targets), pending.predict(targets)
    np.testing.assert_allclose(after.mean, before.mean, atol=1e-7)
    assert (after.variance_of_mean <= before.variance_of_mean * (1 + 1e-9)).all()
    assert (after.variance_of_mean[:2] < 0.9 * before.variance_of_mean[:2]).all()
    assert pending.n == good.n
    assert pending.leave_one_out() is good.leave_one_out()
    assert pending.warnings() == good.warnings()


# Known noise --------------------------------------------------------------------------------


def test_runs_known_to_be_noisy_count_less() -> None:
    points, values = noisy_runs(24, 0.05, 22)
    spoilt = values.copy()
    spoilt[::4] += np.random.default_rng(22).normal(0.0, 1.0, 6)
    known = np.zeros(24)
    known[::4] = 1.0
    targets = design(200, 2, 23)

    def error(metamodel: Kriging) -> float:
        return float(np.sqrt(np.mean((metamodel.predict(targets).mean - response(targets)) ** 2)))

    assert error(Kriging.fit(points, spoilt, known)) < 0.5 * error(Kriging.fit(points, spoilt))


def test_known_noise_is_part_of_a_new_run() -> None:
    points, values = noisy_runs(30, 0.2, 24)
    told = Kriging.fit(points, values, np.full(30, 0.04))
    not_told = Kriging.fit(points, values)
    predicted = told.predict([[0.5, 0.5]])
    assert told.noise_standard_deviation < not_told.noise_standard_deviation
    assert predicted.variance_of_new_run[0] - predicted.variance_of_mean[0] > 0.04
    other = not_told.predict([[0.5, 0.5]])
    assert np.sqrt(predicted.variance_of_new_run[0] / other.variance_of_new_run[0]) == (
        pytest.approx(1.0, rel=0.3)
    )


# Stated standard errors ---------------------------------------------------------------------


def runs_of_two_kinds(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Every other run scatters ten times as much as its neighbour."""
    points = design(40, 2, seed)
    errors = np.tile([0.05, 0.5], 20)
    scatter = errors * np.random.default_rng(seed).standard_normal(40)
    return points, response(points) + scatter, errors


def test_stated_errors_that_the_runs_bear_out_give_the_better_runs_more_weight() -> None:
    targets = design(50, 2, 100)

    def error(metamodel: Kriging) -> float:
        return float(np.sqrt(np.mean((metamodel.predict(targets).mean - response(targets)) ** 2)))

    told, not_told = [], []
    for seed in range(8):
        points, values, errors = runs_of_two_kinds(seed)
        told.append(error(Kriging.fit(points, values, standard_errors=errors)))
        not_told.append(error(Kriging.fit(points, values)))
    assert np.mean(told) < 0.6 * np.mean(not_told)


@pytest.mark.parametrize("factor", [0.01, 0.5, 2.0, 1e6])
def test_only_the_ratios_of_stated_errors_count(factor: float) -> None:
    points, values, errors = runs_of_two_kinds(1)
    right = Kriging.fit(points, values, standard_errors=errors)
    wrong = Kriging.fit(points, values, standard_errors=factor * errors)
    predicted, expected = (fitted.predict([[0.3, 0.6]]) for fitted in (wrong, right))
    assert predicted.mean == pytest.approx(expected.mean, rel=1e-9)
    assert predicted.variance_of_mean == pytest.approx(expected.variance_of_mean, rel=1e-6)


@pytest.mark.parametrize("stated", [0.0, 0.1, 7.0])
def test_stated_errors_that_are_equal_change_no_digit(stated: float) -> None:
    points, values = noisy_runs(20, 0.2, 5)
    with_errors = Kriging.fit(points, values, standard_errors=np.full(20, stated))
    assert with_errors.to_plain() == Kriging.fit(points, values).to_plain()


def test_stated_errors_that_the_runs_contradict_change_no_digit() -> None:
    points, values, errors = runs_of_two_kinds(2)
    contrary = Kriging.fit(points, values, standard_errors=errors[::-1])
    assert contrary.to_plain() == Kriging.fit(points, values).to_plain()


def test_a_run_that_states_no_error_counts_as_an_average_one() -> None:
    points, values, errors = runs_of_two_kinds(3)
    average = float(np.sqrt(np.mean(errors[2:] ** 2)))
    silent, explicit = errors.copy(), errors.copy()
    silent[:2], explicit[:2] = 0.0, average
    plain = [
        Kriging.fit(points, values, standard_errors=stated).to_plain()
        for stated in (silent, explicit)
    ]
    np.testing.assert_allclose(plain[0]["noise_ratios"], plain[1]["noise_ratios"])


def test_pending_runs_and_another_program_know_the_ratios_too() -> None:
    points, values, errors = runs_of_two_kinds(4)
    metamodel = Kriging.fit(points, values, standard_errors=errors)
    targets = design(30, 2, 7)
    mean, variance = evaluated(json.loads(json.dumps(metamodel.to_plain())), targets)
    predicted = metamodel.predict(targets)
    np.testing.assert_allclose(mean, predicted.mean, rtol=1e-9)
    np.testing.assert_allclose(variance, predicted.variance_of_mean, rtol=1e-6)
    pending = metamodel.condition_on_pending(targets[:3])
    np.testing.assert_allclose(pending.predict(targets).mean, predicted.mean, rtol=1e-6)
    assert (pending.predict(targets).variance_of_mean < predicted.variance_of_mean).all()
    assert pending.to_plain()["noise_ratios"][-3:] == [1.0, 1.0, 1.0]


def test_the_posterior_with_ratios_has_the_slope_that_it_states() -> None:
    points, values, errors = runs_of_two_kinds(5)
    contrasts = Contrasts.of(Trend.choose(points, True).matrix(points))
    ratios = noise_ratios(errors)[-1]
    posterior = HyperparameterPosterior(points, values, contrasts, np.full(40, 0.01), ratios)
    at = np.array([0.5, 1.0, -0.5])
    slope = [
        (posterior(at + step)[0] - posterior(at - step)[0]) / 2e-5 for step in 1e-5 * np.eye(3)
    ]
    np.testing.assert_allclose(posterior(at)[1], slope, rtol=1e-5)


# Few runs, many parameters, odd designs -----------------------------------------------------


@settings(max_examples=25, deadline=None)
@given(d=st.integers(1, 14), extra=st.integers(-10, 6), seed=st.integers(0, 99))
def test_few_runs_of_many_parameters_give_finite_intervals(d: int, extra: int, seed: int) -> None:
    n = max(3, d + 1 + extra)
    points = np.random.default_rng(seed).random((n, d))
    values = np.random.default_rng(seed + 1).normal(size=n)
    metamodel = Kriging.fit(points, values)
    predicted = metamodel.predict(points)
    quality = metamodel.leave_one_out()
    for array in (predicted.mean, predicted.standard_error, quality.standard_deviation):
        assert np.isfinite(array).all()
    assert (predicted.variance_of_new_run > predicted.variance_of_mean).all()


def test_a_parameter_that_never_changes_is_no_trouble() -> None:
    points, values = noisy_runs(20, 0.05, 25)
    fixed = np.column_stack([points, np.full(20, 0.5)])
    targets = design(50, 2, 26)
    found = Kriging.fit(fixed, values).predict(np.column_stack([targets, np.full(50, 0.5)])).mean
    assert np.sqrt(np.mean((found - response(targets)) ** 2)) < 0.1


def test_parameters_that_change_together_are_no_trouble() -> None:
    points, values = noisy_runs(20, 0.05, 27)
    doubled = np.column_stack([points, points[:, 0]])
    targets = design(50, 2, 28)
    found = Kriging.fit(doubled, values).predict(np.column_stack([targets, targets[:, 0]])).mean
    assert np.sqrt(np.mean((found - response(targets)) ** 2)) < 0.1


def test_a_parameter_that_only_one_run_changes_is_no_trouble() -> None:
    points, values = noisy_runs(20, 0.05, 29)
    lonely = np.column_stack([points, np.full(20, 0.5)])
    lonely[7, 2] = 1.0
    quality = Kriging.fit(lonely, values).leave_one_out()
    assert np.isfinite(quality.predicted).all()
    assert quality.q2 > 0.8


def test_an_exactly_linear_response_is_met_exactly() -> None:
    points = design(15, 3, 30)
    metamodel = Kriging.fit(points, 1500.0 + points @ [300.0, -20.0, 0.0])
    np.testing.assert_allclose(metamodel.predict([[0.9, 0.1, 0.5]]).mean, [1768.0], rtol=1e-8)
    np.testing.assert_allclose(metamodel.gradients([[0.5] * 3])[0], [300.0, -20.0, 0.0], atol=1e-4)
    assert metamodel.warnings() == []


@pytest.mark.parametrize("value", [0.0, 1500.0, -1e-12])
def test_a_constant_response_is_constant_and_said(value: float) -> None:
    metamodel = Kriging.fit(design(10, 2, 31), np.full(10, value))
    predicted = metamodel.predict(design(5, 2, 32))
    np.testing.assert_allclose(predicted.mean, value, rtol=1e-9, atol=1e-12)
    assert (predicted.variance_of_mean > 0).all()
    assert np.sqrt(predicted.variance_of_new_run).max() <= 1e-9 * max(abs(value), 1e-2)
    assert math.isnan(metamodel.leave_one_out().q2)
    assert messages.SAME_VALUE.is_in(metamodel.warnings()[0])


# Warnings -----------------------------------------------------------------------------------


def test_a_good_metamodel_has_no_warnings(good: Kriging) -> None:
    assert good.warnings() == []


def test_pure_noise_is_said() -> None:
    for seed in range(5):
        noise = np.random.default_rng(seed).normal(22.0, 0.8, 26)
        said = " ".join(Kriging.fit(design(26, 2, seed), noise).warnings())
        assert "Q2" in said
        assert messages.SCATTERS.is_in(said)


def test_a_response_too_rough_for_the_runs_is_said() -> None:
    """Replicates show that there is little noise, so roughness is what spoils the prediction."""
    points = np.vstack([design(26, 2, 33), np.full((14, 2), 0.5)])
    rough = np.sin(40.0 * points[:, 0]) * np.cos(50.0 * points[:, 1])
    rough += 0.02 * np.random.default_rng(33).normal(size=40)
    said = " ".join(Kriging.fit(points, rough).warnings())
    assert messages.UNEXPLAINED.is_in(said)


def test_too_few_runs_are_said() -> None:
    said = " ".join(Kriging.fit(*noisy_runs(5, 0.01, 34)).warnings())
    assert "Only 5 runs for 2 free parameters" in said


def test_intervals_that_miss_many_runs_are_said() -> None:
    """The response jumps after the fit: the hyperparameters no longer hold."""
    points, values = noisy_runs(20, 0.02, 35)
    more = design(10, 2, 36)
    jumped = response(more) + np.where(np.arange(10) % 2, 1.0, -1.0)
    said = " ".join(Kriging.fit(points, values).condition(more, jumped).warnings())
    assert re.search(r"Only \d+ % of the runs lie inside", said)


# Input --------------------------------------------------------------------------------------

_POINTS = design(6, 2, 40)
_VALUES = response(_POINTS)


@pytest.mark.parametrize(
    ("points", "values", "noise", "named"),
    [
        (_POINTS, [*_VALUES[:5], math.nan], None, "values"),
        (_POINTS, [*_VALUES[:5], math.inf], None, "values"),
        (_POINTS, _VALUES[:5], None, "values"),
        (_POINTS, 1e300 * _VALUES, None, "values"),
        (_POINTS, 1e-300 * _VALUES, None, "values"),
        (_POINTS, np.full(6, 1e-300), None, "values"),
        (_POINTS, ["high"] * 6, None, "values"),
        (np.where(_POINTS < 0.2, math.nan, _POINTS), _VALUES, None, "points"),
        (_POINTS[:, 0], _VALUES, None, "points"),
        (_POINTS * 2000.0, _VALUES, None, "points"),
        (_POINTS[:2], _VALUES[:2], None, "points"),
        (np.empty((6, 0)), _VALUES, None, "points"),
        ([[0.1], [0.2, 0.3]], _VALUES, None, "points"),
        (_POINTS, _VALUES, [-0.1] * 6, "noise_variance"),
        (_POINTS, _VALUES, [0.1] * 5, "noise_variance"),
        (_POINTS, _VALUES, [math.inf] * 6, "noise_variance"),
    ],
)
def test_unusable_runs_are_refused_by_name(points, values, noise, named) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError) as caught:
        Kriging.fit(points, values, noise)
    assert caught.value.faults[0].key == named


def test_unusable_points_are_refused_after_the_fit(good: Kriging) -> None:
    for call in (
        lambda: good.predict([[0.5, math.nan]]),
        lambda: good.predict([[0.5, 0.5, 0.5]]),
        lambda: good.predict([0.5, 0.5]),
        lambda: good.gradients([[0.5]]),
        lambda: good.gradients([[0.5, math.inf]]),
        lambda: good.condition([[0.5, 0.5]], [math.nan]),
        lambda: good.condition([[0.5, 0.5]], [1.0, 2.0]),
        lambda: good.condition([[0.5, 0.5]], [1e300]),
        lambda: good.condition_on_pending([[0.5]]),
    ):
        with pytest.raises(InputError):
            call()


def test_covariances_have_the_variances_on_their_diagonal_and_say_what_a_run_teaches() -> None:
    points = design(14, 2, 21)
    values = np.sin(3 * points[:, 0]) + 0.1 * np.random.default_rng(21).normal(size=14)
    metamodel = Kriging.fit(points, values)
    here, there = design(6, 2, 22), design(4, 2, 23)
    own, variances = metamodel.covariance_with(here)(here)
    np.testing.assert_allclose(np.diag(own), metamodel.predict(here).variance_of_mean)
    np.testing.assert_allclose(variances, metamodel.predict(here).variance_of_mean)
    np.testing.assert_allclose(own, own.T, rtol=1e-9, atol=1e-12)
    assert np.linalg.eigvalsh(own).min() > 0
    joint, _ = metamodel.covariance_with(here)(there)
    assert joint.shape == (6, 4)
    # For one set of hyperparameters, a run takes covariance^2 / (variance + noise) off.
    component = metamodel._components[0]
    before, at = component.predict(here)[1], there[:1]
    covariance = component.joint(component.project(here), component.project(at))[:, 0]
    added = component.condition_on_pending(at, np.zeros(1), np.ones(1))
    noise = component.hyperparameters.noise_variance
    expected = before - covariance**2 / (component.predict(at)[1] + noise)
    np.testing.assert_allclose(added.predict(here)[1], expected, rtol=1e-6, atol=1e-9)


# Fewer sets of hyperparameters, and other programs ------------------------------------------


def test_reduced_keeps_the_most_probable_sets_with_weights_that_sum_to_one(good: Kriging) -> None:
    reduced = good.reduced(3)
    assert (reduced.components, good.reduced(1).components) == (3, 1)
    assert good.reduced(good.components) is good
    assert reduced._weights.sum() == pytest.approx(1.0, abs=1e-14)
    largest = np.sort(good._weights)[::-1][:3]
    np.testing.assert_allclose(np.sort(reduced._weights)[::-1], largest / largest.sum())
    points = design(50, 2, 31)
    change = reduced.predict(points).mean - good.predict(points).mean
    assert 0.0 < np.abs(change).max() < 0.5 * good.predict(points).standard_error.max()
    added = good.condition_on_pending([[0.5, 0.5]]).reduced(3)
    assert (added.components, added.n) == (3, 26)
    assert added.leave_one_out().q2 == reduced.leave_one_out().q2
    with pytest.raises(InputError, match=f"components: {messages.NO_COMPONENTS.matching(given=0)}"):
        good.reduced(0)


def evaluated(plain: dict[str, object], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and variance by the formulas of `Kriging.to_plain`, as another program has them."""
    runs, means, variances, weights = np.array(plain["points"]), [], [], []
    for c in plain["components"]:
        n, q = len(c["coefficients"]), len(c["trend_coefficients"])
        triangle, read = np.zeros((n - q, n + q)), 0
        for row in range(n - q):
            length = n + q - row
            triangle[row, row:] = c["triangle"][read : read + length]
            read += length
        assert read == len(c["triangle"])
        off = (points[:, None] - runs) / np.array(c["ranges"])
        t = math.sqrt(10.0) * np.sqrt((off**2).sum(axis=2))
        k = c["signal_variance"] * (1.0 + t + t**2 / 3.0) * np.exp(-t)
        f = np.column_stack([np.ones(len(points)), points[:, c["trend_columns"]] - 0.5])
        means.append(f @ c["trend_coefficients"] + k @ c["coefficients"])
        variance = c["signal_variance"] - 2.0 * (f * (k @ np.array(c["least_squares"]).T)).sum(1)
        variance += (f * (f @ np.array(c["trend_covariance"]))).sum(axis=1)
        variance -= ((np.hstack([k, f]) @ triangle.T) ** 2).sum(axis=1)
        variances.append(np.maximum(variance, 0.0))
        weights.append(c["weight"])
    mean = weights @ np.array(means)
    spread = weights @ (np.array(means) - mean) ** 2
    variance = plain["inflation"] * (weights @ np.array(variances)) + spread
    return plain["offset"] + plain["scale"] * mean, plain["scale"] ** 2 * variance


@pytest.mark.parametrize("noise", [0.0, 0.2])
@pytest.mark.parametrize("d", [1, 5])
@pytest.mark.parametrize("linear_trend", [True, False])
def test_another_program_predicts_the_same_from_what_is_written_out(
    d: int, noise: float, linear_trend: bool
) -> None:
    points = design(30, d, 32)
    values = 20.0 + np.sin(3.0 * points[:, 0]) + points[:, -1]
    values += np.random.default_rng(32).normal(0.0, noise, 30)
    metamodel = Kriging.fit(points, values, linear_trend=linear_trend)
    targets = np.vstack([design(40, d, 33), points[:3], np.zeros((1, d)), np.ones((1, d))])
    plain = json.loads(json.dumps(metamodel.to_plain()))
    mean, variance = evaluated(plain, targets)
    predicted = metamodel.predict(targets)
    np.testing.assert_allclose(mean, predicted.mean, rtol=1e-9)
    rounding = max(rounding_of_the_variance(plain, component) for component in plain["components"])
    np.testing.assert_allclose(variance, predicted.variance_of_mean, rtol=1e-9, atol=rounding)


def rounding_of_the_variance(plain: dict, component: dict) -> float:
    """Rounding error of the signal less what the runs explain, solved by a Cholesky factor.

    Higham, Accuracy and Stability of Numerical Algorithms (2002), theorem 8.5: in units of the
    signal, machine precision times the condition number of the factor.
    """
    scaled = np.array(plain["points"]) / np.array(component["ranges"])
    runs = component["signal_variance"] * matern(cdist(scaled, scaled))
    runs += np.diag(np.broadcast_to(component["noise_variance"], len(scaled)))
    factor = np.sqrt(np.linalg.cond(runs))
    signal = component["signal_variance"] * plain["scale"] ** 2
    return float(np.finfo(float).eps * factor * signal)
