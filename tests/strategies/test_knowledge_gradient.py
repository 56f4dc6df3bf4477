"""The knowledge gradient is never negative and agrees with repeated simulation of a run."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.metamodels.unit_cube import points_about, spread_points
from grainfit.problem import Parameter, Problem, Target
from grainfit.strategies.sequential import knowledge_gradient as expected_improvement
from grainfit.strategies.sequential.knowledge_gradient import KnowledgeGradient

PROBLEM = Problem(
    [Parameter("x", 0.0, 1.0), Parameter("y", 0.0, 1.0)],
    [Target("first", 1.0, tolerance=0.1), Target("second", 2.0, tolerance=0.2, weight=0.7)],
)


def responses(points: np.ndarray) -> list[np.ndarray]:
    x, y = points.T
    return [np.sin(3.0 * x) + 0.5 * y, 1.5 + x * y + 0.4 * y**2]


def metamodels(noise: float, runs: int = 10, seed: int = 1) -> Metamodels:
    """Of noisy runs spread over the unit square."""
    random = np.random.default_rng(seed)
    points = spread_points(runs, 2, random)
    values = [v + noise * random.standard_normal(runs) for v in responses(points)]
    return Metamodels(PROBLEM, [Kriging.fit(points, v) for v in values])


def improvement(
    known: Metamodels, possible: np.ndarray, handicaps: np.ndarray | None = None
) -> KnowledgeGradient:
    nothing = np.zeros(len(possible))
    return KnowledgeGradient(known, possible, nothing if handicaps is None else handicaps)


@pytest.fixture
def possible() -> np.ndarray:
    return spread_points(16, 2, np.random.default_rng(8))


@pytest.fixture
def trials() -> np.ndarray:
    return spread_points(32, 2, np.random.default_rng(9))


@pytest.fixture
def no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Possible answers stay where they are, so that improvements have a closed meaning."""
    monkeypatch.setattr(expected_improvement, "_STEP", 1e-9)


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.5])
def test_it_is_never_negative(noise: float, possible: np.ndarray, trials: np.ndarray) -> None:
    found = improvement(metamodels(noise), possible)(trials)
    assert found.shape == (32,)
    assert np.isfinite(found).all()
    assert found.min() >= 0.0
    assert found.max() > 0.0


def test_many_points_are_the_same_as_one_at_a_time(
    possible: np.ndarray, trials: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    worth = improvement(metamodels(0.1), possible)
    together = worth(trials)
    monkeypatch.setattr(expected_improvement, "_LARGEST_BLOCK", 1)
    assert np.allclose(together, worth(trials), rtol=1e-9, atol=1e-12)


def test_the_smallest_misfit_is_that_of_the_best_possible_answer(
    possible: np.ndarray, no_step: None
) -> None:
    known = metamodels(0.1)
    assert improvement(known, possible).smallest_misfit == pytest.approx(
        known.misfit(possible).min(), rel=1e-6
    )


def test_a_step_of_the_answers_lowers_their_misfit(possible: np.ndarray) -> None:
    known = metamodels(0.1)
    assert improvement(known, possible).smallest_misfit < known.misfit(possible).min()


def test_handicaps_are_added_to_the_misfits(possible: np.ndarray, trials: np.ndarray) -> None:
    known = metamodels(0.1)
    free = improvement(known, possible)
    alike = improvement(known, possible, np.full(len(possible), 3.0))
    assert alike.smallest_misfit == pytest.approx(free.smallest_misfit + 3.0)
    assert np.allclose(alike(trials), free(trials), atol=1e-9)


def test_runs_serve_the_answer_that_has_no_handicap(no_step: None) -> None:
    # Two answers that are as good by symmetry; a run at one tells hardly anything of the other.
    random = np.random.default_rng(3)
    points = np.repeat([[0.0], [0.25], [0.5], [0.75], [1.0]], 2, axis=0)
    values = 1.0 + (points[:, 0] - 0.5) ** 2 + 0.05 * random.standard_normal(len(points))
    problem = Problem([Parameter("x", 0.0, 1.0)], [Target("first", 1.14, tolerance=0.02)])
    known = Metamodels(problem, [Kriging.fit(points, values)])
    answers = np.array([[0.1], [0.15], [0.85], [0.9]])
    on_left = np.array([1.0, 1.0, 0.0, 0.0])
    right_is_better = improvement(known, answers, 50.0 * on_left)(answers)
    left_is_better = improvement(known, answers, 50.0 * (1.0 - on_left))(answers)
    assert left_is_better[:2].min() > left_is_better[2:].max()
    assert right_is_better[2:].min() > right_is_better[:2].max()


def test_a_run_where_everything_is_known_is_worth_less_than_at_an_uncertain_answer() -> None:
    # The response is known precisely below 0.5, and there it misses the target by far.
    points = np.repeat(np.linspace(0.0, 0.5, 6), 5)[:, None]
    values = np.sin(2.0 * points[:, 0])
    problem = Problem([Parameter("x", 0.0, 1.0)], [Target("first", 1.2, tolerance=0.02)])
    known = Metamodels(problem, [Kriging.fit(points, values)])
    worth = improvement(known, np.linspace(0.0, 1.0, 41)[:, None])
    precise, uncertain = worth(np.array([[0.25], [0.9]]))
    assert precise < 0.1 * uncertain


def test_where_a_run_is_under_way_another_one_is_worth_less(possible: np.ndarray) -> None:
    known = metamodels(0.1)
    best = known.misfit(possible).argmin()
    point = possible[best][None]
    alone = improvement(known, possible)(point)[0]
    beside = improvement(known.condition_on_pending(point), possible)(point)[0]
    third = improvement(known.condition_on_pending(np.repeat(point, 2, axis=0)), possible)(point)[0]
    assert alone > beside > third > 0.0


def test_runs_under_way_change_no_expected_response(trials: np.ndarray) -> None:
    known = metamodels(0.1)
    later = known.condition_on_pending(trials[:3])
    means, variances = known.predict(trials)
    later_means, later_variances = later.predict(trials)
    assert np.allclose(means, later_means, rtol=1e-6)
    assert (later_variances <= variances * (1 + 1e-9)).all()
    assert known.condition_on_pending(np.empty((0, 2))) is known


# Brute force ---------------------------------------------------------------------------------


def simulated(known: Metamodels, possible: np.ndarray, point: np.ndarray) -> float:
    """Improvement by a run, averaged over 16384 outcomes of it spread over their distribution.

    With the outcome of the run, means change linearly and variances quadratically, so that three
    outcomes tell of all others.
    """
    outcomes = norm.ppf(spread_points(2**14, len(known.models), np.random.default_rng(12)))
    after = np.zeros((len(outcomes), len(possible)))
    for index, model in enumerate(known.models):
        there = model.predict(point[None])
        misfits = []
        for z in (-1.0, 0.0, 1.0):
            value = there.mean + z * np.sqrt(there.variance_of_new_run)
            models = list(known.models)
            models[index] = model.condition(point[None], value)
            means, variances = Metamodels(PROBLEM, models).deviations(possible)
            misfits.append(means[:, index] ** 2 + variances[:, index])
        low, middle, high = misfits
        z = outcomes[:, index, None]
        after += middle + 0.5 * (high - low) * z + (0.5 * (high + low) - middle) * z**2
    return float(known.misfit(possible).min() - after.min(axis=1).mean())


def of_one_component(known: Metamodels) -> Metamodels:
    """The same with the likeliest hyperparameters alone.

    With several, a run would also teach which of them are right, and the inflation of variances
    is no part of the Kriging equations: then improvements are approximations.
    """
    models = []
    for model in known.models:
        best = max(model._components, key=lambda c: c.hyperparameters.weight)
        only = object.__new__(type(best))
        only.__dict__.update(best.__dict__)
        only.hyperparameters = best.hyperparameters.__class__(
            best.hyperparameters.ranges,
            best.hyperparameters.signal_variance,
            best.hyperparameters.noise_variance,
            1.0,
        )
        models.append(
            Kriging(
                [only],
                offset=model._offset,
                scale=model._scale,
                degrees_of_freedom=10**9,
            )
        )
    return Metamodels(known.problem, models)


def about_the_best(known: Metamodels) -> np.ndarray:
    """Possible answers among which a run is likely to decide."""
    best = everywhere(256)[known.misfit(everywhere(256)).argmin()]
    return points_about(best[None], 96, 0.15, np.random.default_rng(10))


def everywhere(count: int) -> np.ndarray:
    return spread_points(count, 2, np.random.default_rng(11))


@pytest.mark.parametrize("noise", [0.01, 0.1, 0.5])
def test_it_is_what_simulating_the_run_many_times_shows(noise: float, no_step: None) -> None:
    known = of_one_component(metamodels(noise))
    possible = about_the_best(known)
    trials = np.vstack([everywhere(8), possible[:4]])
    found = improvement(known, possible)(trials)
    drawn = np.array([simulated(known, possible, point) for point in trials])
    # 32 outcomes stand for all of them: a third of the largest improvement is left for that.
    assert drawn.max() > 0.02 * known.misfit(possible).min()
    assert np.abs(found - drawn).max() < 0.33 * drawn.max()


@pytest.mark.parametrize("noise", [0.1, 0.5])
def test_with_uncertain_hyperparameters_it_prefers_the_same_runs(
    noise: float, no_step: None
) -> None:
    known = metamodels(noise)
    possible = about_the_best(known)
    trials = np.vstack([everywhere(8), possible[:4]])
    found = improvement(known, possible)(trials)
    drawn = np.array([simulated(known, possible, point) for point in trials])
    # Conditioning does not ask which hyperparameters a run speaks for, the improvement does: their
    # sizes differ by half as much again.
    assert np.corrcoef(found, drawn)[0, 1] > 0.95
    assert drawn[found.argmax()] > 0.9 * drawn.max()


def test_a_noisy_run_teaches_less_than_a_precise_one(no_step: None) -> None:
    """The same knowledge of the expected responses; only the next run is noisier."""
    known = of_one_component(metamodels(0.1))
    possible = about_the_best(known)
    worth = improvement(known, possible)
    precise = worth(possible)
    quiet = known.scatter_at
    worth._scatter_at = lambda points: 4.0 * quiet(points)
    assert (worth(possible) <= precise).all()
    assert worth(possible).max() < 0.7 * precise.max()


def test_the_improvement_of_correlated_targets_is_that_of_their_misfit(
    possible: np.ndarray, trials: np.ndarray, no_step: None
) -> None:
    correlated = replace(PROBLEM, correlations=[("first", "second", -0.8)])
    known = Metamodels(correlated, metamodels(0.1).models)
    worth = improvement(known, possible)
    means, variances = known.deviations(possible)
    covariance, variance = known.covariance_with(possible)(trials)
    learnt = covariance / np.sqrt(variance + known.scatter_at(trials).T)[:, None, :]
    precision = np.linalg.inv([[1.0, -0.8], [-0.8, 1.0]])
    smallest = []
    for outcome in expected_improvement._normal_outcomes(2):
        then = means.T[:, :, None] + learnt * outcome[:, None, None]
        left = variances.T[:, :, None] - learnt**2
        misfits = np.einsum("kmt,kl,lmt->mt", then, precision, then)
        misfits += np.einsum("kk,kmt->mt", precision, left)
        smallest.append(misfits.min(axis=0))
    now = known.misfit(possible).min()
    wanted = np.maximum(now - np.mean(smallest, axis=0), 0.0)
    assert worth(trials) == pytest.approx(wanted, rel=1e-6, abs=1e-9 * now)
    alone = improvement(Metamodels(PROBLEM, known.models), possible)(trials)
    assert not np.allclose(alone, wanted, rtol=0.05)
