"""Curves reduced to principal components: the coordinates of a measured curve are plain targets."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.evaluation import Curve, Evaluation, Proposal
from grainfit.metamodels.curve_reduction import (
    CurveBasis,
    Reduction,
    about_short_curves,
    runs_with_curve,
    values_at,
)
from grainfit.metamodels.metamodels import Metamodels, can_be_fitted
from grainfit.metamodels.predictor import Component, Hyperparameters, Trend
from grainfit.problem import CurveTarget, Parameter, Problem, Target

Array = NDArray[np.float64]

PLACES = np.linspace(0.1, 1.0, 12)


def bent(rise: float, bend: float) -> Array:
    """Curves of two parameters."""
    return np.asarray(rise * PLACES + bend * PLACES**2)


def target(values: Array, common: float = 0.05) -> CurveTarget:
    """A measured curve with absolute errors."""
    return CurveTarget("curve", PLACES.tolist(), values.tolist(), 0.02, common)


def simulated(runs: int = 30, noise: float = 0.0) -> Array:
    """Curves of random parameters."""
    random = np.random.default_rng(1)
    curves = [bent(*random.uniform(0.5, 1.5, 2)) for _ in range(runs)]
    return np.array(curves) + noise * random.standard_normal((runs, len(PLACES)))


def problem_with(curve: CurveTarget, *targets: Target) -> Problem:
    return Problem([Parameter("rise", 0.5, 1.5)], list(targets), curves=[curve])


def evaluation(rise: float, curve: Curve | None, seed: int = 1) -> Evaluation:
    outcome = {"number": rise} | ({} if curve is None else {"curve": curve})
    return Evaluation.of(Proposal({"rise": rise}, seed, "design"), outcome)


def test_curve_of_two_shapes_has_two_components() -> None:
    basis = CurveBasis.of(target(bent(1.0, 1.0)), simulated(), 2)

    assert basis.names == ["curve, component 1", "curve, component 2"]


def test_tolerance_of_a_curve_is_kept_at_every_point_along_each_component() -> None:
    measured = CurveTarget(
        "curve", PLACES.tolist(), bent(1.0, 1.0).tolist(), 0.02, 0.05, tolerance="8 %"
    )
    basis = CurveBasis.of(measured, simulated(), 2)

    for component, along in zip(basis.targets, np.eye(2), strict=True):
        at_limit, _ = basis.expected(component.value * np.ones(2) * along, np.zeros(2))
        moved, _ = basis.expected(
            (component.value + component.tolerance) * np.ones(2) * along, np.zeros(2)
        )
        shares = np.abs(moved - at_limit) / measured.tolerances
        assert shares.max() == pytest.approx(1.0)
        assert component.uncertainty == 1.0


def test_curve_of_another_shape_within_its_tolerance_is_accepted() -> None:
    wave = bent(1.0, 1.0) * (1 + 0.1 * np.sin(3 * np.arange(len(PLACES))))

    def about(**tolerance: str) -> CurveBasis:
        errors: dict[str, float | str] = {"uncertainty": 0.01, **tolerance}
        return CurveBasis.of(
            CurveTarget("curve", PLACES.tolist(), wave.tolist(), **errors),  # type: ignore[arg-type]
            simulated(),
            2,
        )

    assert about().has_other_shape
    assert about(tolerance="5 %").has_other_shape
    assert not about(tolerance="15 %").has_other_shape


def test_a_component_is_said_to_be_the_part_of_the_curve_that_it_moves_most() -> None:
    curve = CurveTarget(
        "stress",
        PLACES.tolist(),
        bent(1.0, 1.0).tolist(),
        0.02,
        coordinate="travel",
        coordinate_unit="m",
    )
    places = np.arange(len(PLACES)) == 4
    runs = bent(1.0, 1.0) + np.array([[-0.3], [0.1], [0.2]]) * places
    basis = CurveBasis.of(curve, runs, 1)

    assert basis.parts == {
        "stress, component 1": f"stress, as it varies most at travel = {PLACES[4]:.4g} m"
    }


def test_curve_is_the_sum_of_its_components() -> None:
    basis = CurveBasis.of(target(bent(1.0, 1.0)), simulated(), 2)
    wanted = bent(0.7, 1.2)
    scores = basis.scores(wanted)
    found, errors = basis.expected(np.array([s.value for s in scores.values()]), np.zeros(2))

    assert found == pytest.approx(wanted, abs=1e-9)
    assert errors == pytest.approx(0.0, abs=1e-9)


def test_errors_along_components_are_independent_and_of_size_one() -> None:
    random = np.random.default_rng(7)
    truth = bent(1.0, 1.0)
    covariance = target(truth).covariance_about(truth)
    curves, off = simulated(), []
    for errors in random.multivariate_normal(np.zeros(len(PLACES)), covariance, 2000):
        basis = CurveBasis.of(target(truth + errors), curves, 2)
        true = basis.scores(truth)
        sign = np.sign(basis.components[:, -1])
        found = np.array([t.value - true[t.name].value for t in basis.targets])
        off.append(found * sign)

    # The standard error of a variance of 2000 samples is 0.03.
    assert np.cov(np.array(off).T) == pytest.approx(np.eye(2), abs=0.12)


def test_percentages_do_not_drag_a_curve_down() -> None:
    random = np.random.default_rng(3)
    truth, found = bent(1.0, 0.0), []
    for _ in range(300):
        measured = truth * (1 + 0.05 * random.normal()) * (1 + 0.05 * random.normal(size=12))
        curve = CurveTarget("curve", PLACES.tolist(), measured.tolist(), "5 %", "5 %")
        curves = np.array([bent(rise, 0.0) for rise in np.linspace(0.5, 1.5, 9)])
        basis = CurveBasis.of(curve, curves, 1)
        nearest, _ = basis.expected(np.array([t.value for t in basis.targets]), np.zeros(1))
        found.append(nearest[-1])

    # Shares of the measured values give 0.97; the standard error of the mean is 0.003.
    assert np.mean(found) == pytest.approx(1.0, abs=0.01)


def test_shape_that_no_run_has_is_improbable() -> None:
    wave = bent(1.0, 1.0) + 0.1 * np.sin(20 * PLACES)
    shaped = CurveBasis.of(target(wave), simulated(), 2)
    usual = CurveBasis.of(target(bent(1.0, 1.0)), simulated(), 2)

    assert shaped.shape_probability < 1e-6
    assert usual.shape_probability > 0.5


def test_shape_of_a_noisy_curve_is_as_probable_as_its_errors_say() -> None:
    random, chances = np.random.default_rng(4), []
    truth = bent(1.0, 1.0)
    covariance = target(truth).covariance_about(truth)
    for errors in random.multivariate_normal(np.zeros(len(PLACES)), covariance, 400):
        chances.append(CurveBasis.of(target(truth + errors), simulated(), 2).shape_probability)

    assert np.mean(chances) == pytest.approx(0.5, abs=0.05)
    assert np.mean(np.array(chances) < 0.1) == pytest.approx(0.1, abs=0.05)


def test_large_errors_in_percent_are_seldom_taken_for_another_shape() -> None:
    random, places = np.random.default_rng(6), np.linspace(0.04, 1.0, 25)
    rises = random.uniform(0.5, 1.5, 12)
    curves = np.array([rise * places + 0.5 * rise**2 * places**2 for rise in rises])
    truth = places + 0.5 * places**2
    refused = 0
    for _ in range(100):
        errors = (1 + 0.08 * random.normal()) * (1 + 0.06 * random.normal(size=25))
        measured = CurveTarget("curve", places.tolist(), (truth * errors).tolist(), "6 %", "8 %")
        refused += CurveBasis.of(measured, curves, 1).shape_probability < 1e-3

    # One in a thousand; shares of the measured values refuse eight of a hundred.
    assert refused <= 1


def test_scatter_of_few_runs_is_seldom_taken_for_another_shape() -> None:
    random, refused = np.random.default_rng(8), 0
    truth = bent(1.0, 1.0)
    for _ in range(60):
        noise = 0.05 * random.standard_normal((8, len(PLACES)))
        curves = np.array([bent(*random.uniform(0.5, 1.5, 2)) for _ in range(8)]) + noise
        measured = target(truth + 0.02 * random.normal(size=12) + 0.05 * random.normal())
        refused += CurveBasis.of(measured, curves, 2).shape_probability < 1e-3

    assert refused <= 2


def test_curve_of_zeros_can_be_measured() -> None:
    curve = CurveTarget("curve", PLACES.tolist(), [0.0] * len(PLACES), 0.02)
    run = evaluation(1.0, Curve([0.0, *PLACES], [0.0, *bent(1.0, 0.0)]))

    assert runs_with_curve(curve, [run]) == [run]
    assert about_short_curves(curve, [run]) == ""


def test_components_left_out_widen_the_expected_curve() -> None:
    basis = CurveBasis.of(target(bent(1.0, 1.0)), simulated(noise=0.005), 2)
    _, errors = basis.expected(np.zeros(len(basis.components)), np.zeros(len(basis.components)))

    assert len(basis.left_out) > 0
    # The noise of the runs, but for its share in the components.
    assert float(errors.mean()) == pytest.approx(0.005, rel=0.3)


def test_curve_that_ends_early_has_no_value() -> None:
    curve = Curve([0.0, 0.5], [0.0, 1.0])

    assert values_at(curve, [0.1, 0.6]) is None
    assert values_at(curve, [-0.1, 0.3]) is None
    assert values_at(Curve([0.0, 0.5], [0.0, 1.0], stays=True), [0.25, 2.0]) == pytest.approx(
        [0.5, 1.0]
    )


def test_runs_with_short_curves_do_not_count_for_a_metamodel() -> None:
    problem = problem_with(target(bent(1.0, 0.0)))
    whole = [
        evaluation(rise, Curve([0.0, *PLACES], [0.0, *bent(rise, 0.0)]), seed)
        for seed, rise in enumerate([0.6, 0.9, 1.3])
    ]
    short = evaluation(0.7, Curve([0.0, 0.5], [0.0, 1.0]), 9)

    assert can_be_fitted(problem, [*whole, short])
    assert not can_be_fitted(problem, [*whole[:2], short])


def test_curve_that_has_blown_up_bends_no_metamodel() -> None:
    problem = problem_with(target(bent(1.0, 0.0)))
    runs = [
        evaluation(rise, Curve([0.0, *PLACES], [0.0, *bent(rise, 0.0)]), seed)
        for seed, rise in enumerate(np.linspace(0.5, 1.5, 7).tolist())
    ]
    blown = evaluation(1.1, Curve([0.0, *PLACES], [0.0, *np.full(12, 1e200)]), 9)
    usual = Metamodels.fit(problem, runs).predict([[0.3]])

    assert Metamodels.fit(problem, [*runs, blown]).predict([[0.3]])[0] == pytest.approx(usual[0])


def test_metamodels_of_a_curve_and_a_number_predict_both() -> None:
    problem = problem_with(target(bent(1.0, 0.0)), Target("number", 1.0, tolerance=0.1))
    runs = [
        evaluation(rise, Curve([0.0, *PLACES], [0.0, *bent(rise, 0.0)]), seed)
        for seed, rise in enumerate(np.linspace(0.5, 1.5, 7).tolist())
    ]
    metamodels = Metamodels.fit(problem, runs)
    means, _ = metamodels.predict(problem.to_unit({"rise": 1.23}))
    [basis] = metamodels.reduction.bases
    curve, _ = basis.expected(means[0, 1:], np.zeros(len(basis.components)))

    assert [t.name for t in metamodels.problem.targets] == ["number", *basis.names]
    assert means[0, 0] == pytest.approx(1.23, rel=1e-3)
    assert curve == pytest.approx(bent(1.23, 0.0), rel=2e-3)


def test_curve_that_no_run_has_is_left_out_where_possible() -> None:
    problem = problem_with(target(bent(1.0, 0.0)), Target("number", 1.0, tolerance=0.1))
    reduction = Reduction.where_possible(problem, [evaluation(0.8, None)])

    assert [t.name for t in reduction.problem.targets] == ["number"]


def test_runs_without_scatter_that_are_all_but_equal_have_a_metamodel() -> None:
    points = np.array([[0.1], [0.1], [0.5], [0.5 + 1e-13], [0.9], [0.9 + 1e-11]])
    exact = Hyperparameters(np.array([5.0]), 1.0, 0.0, 1.0)
    values = np.array([1.0, 1.0, 2.0, 2.0, 3.0, 3.0])
    mean, _ = Component(exact, Trend(()), points, values, np.zeros(6)).predict(np.array([[0.5]]))

    assert mean == pytest.approx([2.0], abs=1e-3)


def test_the_shortest_of_curves_that_end_too_early_is_named_with_the_unit() -> None:
    measured = CurveTarget("mass", [3.0, 4.0], [1.0, 2.0], 0.1, coordinate_unit="s")
    curves = [Curve(times, [1.0, 2.0]) for times in ([0.0, 3.5], [0.0, 1.0], [5.0, 6.0])]
    proposal = Proposal({}, 1, "design")
    said = about_short_curves(
        measured, [Evaluation(proposal, {}, curves={"mass": c}) for c in curves]
    )

    assert "0 to 1 s," in said
    assert "3 to 4 s." in said
