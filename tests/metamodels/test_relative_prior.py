"""Fused metamodels: a response as a ratio times that of a cheaper relative, and a difference."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.predictor import Component, Hyperparameters, Trend, matern
from grainfit.metamodels.relative_prior import RelativePrior

Array = NDArray[np.float64]

RATIO, NOISE = 0.75, 0.04
CONSTANT = Trend(())
OF_RELATIVE = Hyperparameters(np.array([1.4, 0.9]), 1.3, NOISE, 1.0)
OF_DIFFERENCE = Hyperparameters(np.array([2.0, 3.0]), 0.2, NOISE, 1.0, RATIO)
RANDOM = np.random.default_rng(4)
X_RELATIVE, X_RUNS, AT = (RANDOM.random((n, 2)) for n in (9, 5, 6))
Y_RELATIVE, Y_RUNS = RANDOM.standard_normal(9), RANDOM.standard_normal(5)


def relative_model() -> Kriging:
    one = Component(OF_RELATIVE, CONSTANT, X_RELATIVE, Y_RELATIVE, np.zeros(9))
    return Kriging([one], offset=0.0, scale=1.0, degrees_of_freedom=10**9)


def fused_model() -> Kriging:
    """Return a fused metamodel of known hyperparameters."""
    relative = RelativePrior(relative_model(), 0.0, 1.0, X_RUNS)
    one = Component(OF_DIFFERENCE, CONSTANT, X_RUNS, Y_RUNS, np.zeros(5), relative=relative)
    return Kriging([one], offset=0.0, scale=1.0, degrees_of_freedom=10**9, relative=relative)


def correlation(first: Array, second: Array, of: Hyperparameters) -> Array:
    apart = (first[:, None] - second) / of.ranges
    return np.asarray(of.signal_variance * matern(np.sqrt((apart**2).sum(axis=2))))


def jointly(
    x_relative: Array, x_runs: Array, x_relative_at: Array | None = None
) -> tuple[Array, Array, Array, Array]:
    """Predict from the joint covariance of all runs: mean, covariance, and with the relative."""
    rows = [(x_relative, 1.0, 0.0), (x_runs, RATIO, 1.0)]

    def covariance(a: tuple[Array, float, float], b: tuple[Array, float, float]) -> Array:
        of_relative = a[1] * b[1] * correlation(a[0], b[0], OF_RELATIVE)
        return of_relative + a[2] * b[2] * correlation(a[0], b[0], OF_DIFFERENCE)

    def trend(row: tuple[Array, float, float]) -> Array:
        return np.tile([row[1], row[2]], (len(row[0]), 1))

    y = np.concatenate([np.resize(Y_RELATIVE, len(x_relative)), np.resize(Y_RUNS, len(x_runs))])
    k = np.block([[covariance(a, b) for b in rows] for a in rows]) + NOISE * np.eye(len(y))
    f = np.vstack([trend(row) for row in rows])
    at = (AT, RATIO, 1.0)
    other = (AT if x_relative_at is None else x_relative_at, 1.0, 0.0)
    inverse = np.linalg.inv(k)
    beta = np.linalg.solve(f.T @ inverse @ f, f.T @ inverse @ y)
    to = {id(row): np.vstack([covariance(one, row) for one in rows]) for row in (at, other)}

    def after(a: tuple[Array, float, float], b: tuple[Array, float, float]) -> Array:
        left = trend(a).T - f.T @ inverse @ to[id(a)]
        right = trend(b).T - f.T @ inverse @ to[id(b)]
        known = to[id(a)].T @ inverse @ to[id(b)]
        unknown_trend = left.T @ np.linalg.solve(f.T @ inverse @ f, right)
        return np.asarray(covariance(a, b) - known + unknown_trend)

    mean = trend(at) @ beta + to[id(at)].T @ inverse @ (y - f @ beta)
    return mean, after(at, at), after(at, other), np.diag(after(other, other))


def test_the_fused_prediction_is_that_of_the_joint_covariance_of_all_runs() -> None:
    mean, covariance, with_relative, of_relative = jointly(X_RELATIVE, X_RUNS)
    fused = fused_model()
    found = fused.predict(AT)
    assert found.mean == pytest.approx(mean, abs=1e-9)
    assert fused.mean(AT) == pytest.approx(mean, abs=1e-9)
    assert found.variance_of_mean == pytest.approx(np.diag(covariance), rel=1e-6)
    joint, variance = fused.covariance_with(AT)(AT)
    assert joint == pytest.approx(covariance, rel=1e-6, abs=1e-8)
    assert variance == pytest.approx(np.diag(covariance), rel=1e-6)
    joint, variance = fused.covariance_with_relative(AT)(AT)
    assert joint == pytest.approx(with_relative, rel=1e-6, abs=1e-8)
    assert variance == pytest.approx(of_relative, rel=1e-6)


def test_pending_runs_of_either_model_narrow_it_as_the_joint_covariance_says() -> None:
    pending = RANDOM.random((2, 2))
    fused = fused_model()
    after_runs = fused.condition_on_pending(pending)
    covariance = jointly(X_RELATIVE, np.vstack([X_RUNS, pending]))[1]
    assert after_runs.predict(AT).variance_of_mean == pytest.approx(np.diag(covariance), rel=1e-6)
    assert after_runs.mean(AT) == pytest.approx(fused.mean(AT), abs=1e-9)
    after_relative = fused.condition_on_pending_relative(pending)
    covariance = jointly(np.vstack([X_RELATIVE, pending]), X_RUNS)[1]
    assert after_relative.predict(AT).variance_of_mean == pytest.approx(
        np.diag(covariance), rel=1e-6
    )


def test_runs_with_values_are_added_at_the_same_hyperparameters() -> None:
    joined = fused_model().condition(X_RUNS[:2] + 0.01, Y_RUNS[:2])
    mean, covariance, *_ = jointly(X_RELATIVE, np.vstack([X_RUNS, X_RUNS[:2] + 0.01]))
    assert joined.mean(AT) == pytest.approx(mean, abs=1e-8)
    assert joined.predict(AT).variance_of_mean == pytest.approx(np.diag(covariance), rel=1e-6)


def test_slopes_are_those_of_the_mean() -> None:
    fused = fitted(similar, 3)[0]
    for axis, step in enumerate(1e-5 * np.eye(2)):
        slopes = (fused.mean(AT + step) - fused.mean(AT - step)) / 2e-5
        assert fused.gradients(AT)[:, axis] == pytest.approx(slopes, rel=1e-5, abs=1e-5)


def test_it_is_the_same_as_a_part_of_a_larger_cube_and_with_all_its_hyperparameters() -> None:
    fused = fitted(similar, 3)[0]
    larger = np.insert(fused.points, 1, 0.3, axis=1)
    there = fused.embedded([0, 2], larger).predict(np.insert(AT, 1, 0.8, axis=1))
    assert there.mean == pytest.approx(fused.predict(AT).mean)
    assert there.variance_of_mean == pytest.approx(fused.predict(AT).variance_of_mean)
    few = fused.reduced(4)
    assert few.components == 4
    assert few.mean(AT) == pytest.approx(fused.mean(AT), abs=1.0)


# Relatives that are good, that tell nothing, and that are wrong on purpose ------------------------

SCATTER = 0.6


def response(x: Array) -> Array:
    return np.asarray(25 + 8 * np.sin(2.5 * x[:, 0]) * (0.5 + x[:, 1]) + 4 * x[:, 1])


def similar(x: Array) -> Array:
    return np.asarray(0.92 * response(x) + 1.5 - x[:, 0])


def unrelated(x: Array) -> Array:
    return np.asarray(25 + 8 * np.cos(9 * x[:, 0] + 4) * np.sin(7 * x[:, 1]))


def contrary(x: Array) -> Array:
    return np.asarray(60 - response(x) + 6 * np.sin(5 * x[:, 1]))


def fitted(
    relative: Callable[[Array], Array], seed: int, of_relative: int = 12, runs: int = 6
) -> tuple[Kriging, Kriging]:
    """Return metamodels of a few runs with a relative and without."""
    random = np.random.default_rng(seed)
    there = maximin_latin_hypercube(of_relative, 2, seed)
    here = maximin_latin_hypercube(runs, 2, seed + 1000)
    values = response(here) + SCATTER * random.standard_normal(runs)
    scattered = relative(there) + SCATTER * random.standard_normal(of_relative)
    model = Kriging.fit(there, scattered)
    return Kriging.fit(here, values, relative=model), Kriging.fit(here, values)


def errors_and_coverage(
    relative: Callable[[Array], Array], runs: int
) -> tuple[Array, float, float]:
    """Root mean square errors with and without it, its coverage, and its mean probability."""
    at = np.random.default_rng(9).random((100, 2))
    errors, inside, shares = [], [], []
    for seed in range(24):
        pair = fitted(relative, seed, runs=runs)
        off = [model.mean(at) - response(at) for model in pair]
        errors.append([np.sqrt(np.mean(each**2)) for each in off])
        standard_errors = pair[0].predict(at).standard_error
        inside.append(np.mean(np.abs(off[0]) < 1.96 * standard_errors))
        shares.append(pair[0].share_of_relative)
    return np.array(errors), float(np.mean(inside)), float(np.mean(shares))


def test_a_similar_relative_replaces_most_runs() -> None:
    errors, inside, share = errors_and_coverage(similar, runs=4)
    assert errors[:, 0].mean() < 0.5 * errors[:, 1].mean()
    assert inside > 0.93
    assert share > 0.9


@pytest.mark.parametrize(
    "runs", [*(pytest.param(runs, marks=pytest.mark.thorough) for runs in (4, 6)), 10]
)
@pytest.mark.parametrize("relative", [unrelated, contrary])
def test_a_relative_that_is_useless_or_wrong_costs_hardly_any_accuracy(
    relative: Callable[[Array], Array], runs: int
) -> None:
    errors, inside, share = errors_and_coverage(relative, runs)
    ratios = errors[:, 0] / errors[:, 1]
    assert ratios.mean() < 1.15
    assert inside > 0.93
    if runs == 10:
        assert share < 0.75


def test_exact_runs_need_no_relative() -> None:
    x = maximin_latin_hypercube(8, 2, 1)
    plane = 3.0 + x @ np.array([2.0, 1.0])
    fused = Kriging.fit(x, plane, relative=fitted(similar, 1)[1])
    assert fused.mean(AT) == pytest.approx(3.0 + AT @ np.array([2.0, 1.0]))
    assert fused.share_of_relative == 0
