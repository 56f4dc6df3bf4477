"""Sobol' indices against closed forms."""

import warnings

import numpy as np
import pytest
from given_metamodels import Function, Given, given, unit_parameters
from scipy.stats import qmc

from grainfit.analysis import messages
from grainfit.analysis.response_surfaces import draw_surfaces
from grainfit.analysis.sensitivity import Sensitivity, estimate_sensitivity
from grainfit.errors import InputError
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Problem, Target


@pytest.fixture
def exact(monkeypatch: pytest.MonkeyPatch) -> None:
    """Metamodels that are sure of their mean."""

    def draw(model: Given, points: np.ndarray, count: int, random: object) -> np.ndarray:
        return np.tile(model.predict(points).mean, (count, 1))

    monkeypatch.setattr("grainfit.analysis.sensitivity.draw_surfaces", draw)


def ishigami(x: np.ndarray) -> np.ndarray:
    first, second, third = (np.pi * (2.0 * x - 1.0)).T
    return 10.0 + np.sin(first) + 7.0 * np.sin(second) ** 2 + 0.1 * third**4 * np.sin(first)


def linear(x: np.ndarray) -> np.ndarray:
    return 100.0 + 3.0 * x[:, 0] - 1.0 * x[:, 1]


def constant(x: np.ndarray) -> np.ndarray:
    return 5.0 + 1e-13 * x[:, 0]


@pytest.mark.usefixtures("exact")
def test_indices_are_those_in_closed_form() -> None:
    targets = [Target("ishigami", 10.0), Target("constant", 5.0), Target("linear", 100.0)]
    models = [Given(ishigami), Given(constant), Given(linear)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = estimate_sensitivity(given(targets, models, 3))
    first = np.array([[0.3139, 0.4424, 0.0], [0.0, 0.0, 0.0], [0.9, 0.1, 0.0]])
    total = np.array([[0.5576, 0.4424, 0.2437], [0.0, 0.0, 0.0], [0.9, 0.1, 0.0]])
    np.testing.assert_allclose(found.first, first, atol=0.05)
    np.testing.assert_allclose(found.total, total, atol=0.03)
    for low, estimate, high, truth in (
        (found.first_low, found.first, found.first_high, first),
        (found.total_low, found.total, found.total_high, total),
    ):
        assert (low <= estimate + 1e-9).all()
        assert (estimate <= high + 1e-9).all()
        # A few rounding errors beside the interval of an index of next to nothing.
        assert ((low - 1e-3 <= truth) & (truth <= high + 1e-3)).mean() > 0.9
        assert (high - low).max() < 0.4
    ishigamis, constants, linears = found.in_words()
    assert ishigamis == (
        f"ishigami depends on x0 ({100 * found.total[0, 0]:.0f} % of its variance, partly "
        f"together with others), x1 ({100 * found.total[0, 1]:.0f} % of its variance) and x2 "
        f"({100 * found.total[0, 2]:.0f} % of its variance, partly together with others)."
    )
    assert constants.startswith("constant depends on none of the free parameters")
    assert linears.endswith(", hardly on x2.")


@pytest.mark.usefixtures("exact")
def test_the_same_seed_gives_the_same_indices_and_intervals() -> None:
    metamodels = given([Target("y", 10.0)], [Given(ishigami)], 3)
    first, second = (estimate_sensitivity(metamodels, seed=3, points=128) for _ in range(2))
    np.testing.assert_array_equal(first.total, second.total)
    np.testing.assert_array_equal(first.first_high, second.first_high)


def test_one_parameter_alone_is_answerable_for_everything() -> None:
    targets = [Target("y", 10.0), Target("constant", 5.0)]
    found = estimate_sensitivity(
        given(targets, [Given(lambda x: x[:, 0] ** 2), Given(constant)], 1)
    )
    np.testing.assert_array_equal(found.first, [[1.0], [0.0]])
    np.testing.assert_array_equal(found.total_low, [[1.0], [0.0]])


def test_a_number_of_points_that_is_no_power_of_two_is_refused() -> None:
    with pytest.raises(
        InputError, match=f"points: {messages.NO_POWER_OF_TWO.matching(given=1000)}"
    ):
        estimate_sensitivity(given([Target("y", 10.0)], [Given(linear)], 3), points=1000)


# --- The metamodel's error ------------------------------------------------------------------------

LINEAR = np.array([9.0, 4.0, 1.0]) / 14.0
ISHIGAMI_FIRST = np.array([0.3139, 0.4424, 0.0])
ISHIGAMI_TOTAL = np.array([0.5576, 0.4424, 0.2437])


def three_slopes(x: np.ndarray) -> np.ndarray:
    return 10.0 + x @ np.array([3.0, 2.0, 1.0])


def fitted(function: Function, runs: int, scatter: float, seed: int) -> Metamodels:
    random = np.random.default_rng(seed)
    points = qmc.LatinHypercube(3, rng=random).random(runs)
    model = Kriging.fit(points, function(points) + random.normal(0.0, scatter, runs))
    return Metamodels(Problem(unit_parameters(3), [Target("y", 10.0)]), [model])


@pytest.mark.parametrize(
    ("function", "runs", "scatter", "first", "total"),
    [
        (three_slopes, 10, 0.5, LINEAR, LINEAR),
        pytest.param(three_slopes, 20, 1.0, LINEAR, LINEAR, marks=pytest.mark.thorough),
        pytest.param(ishigami, 40, 0.0, ISHIGAMI_FIRST, ISHIGAMI_TOTAL, marks=pytest.mark.thorough),
        (ishigami, 70, 1.0, ISHIGAMI_FIRST, ISHIGAMI_TOTAL),
    ],
)
def test_intervals_hold_the_truth_however_poor_the_metamodel_is(
    function: Function, runs: int, scatter: float, first: np.ndarray, total: np.ndarray
) -> None:
    """With the bootstrap alone, intervals of 40 runs of Ishigami's function held a quarter."""
    held, largest = [], 0.0
    for seed in range(12):
        found = estimate_sensitivity(fitted(function, runs, scatter, seed), points=256)
        held.append((found.first_low[0] <= first) & (first <= found.first_high[0]))
        held.append((found.total_low[0] <= total) & (total <= found.total_high[0]))
        largest = max(largest, np.abs(found.total[0] - total).max())
    assert np.mean(held) >= 0.9
    assert largest > 0.1


def test_what_is_not_known_is_said_instead_of_a_ranking() -> None:
    """All metamodels with a Q2 below 0.5 are refused, and hardly any with one above 0.8."""
    refused = []
    for runs, scatter in ((10, 0.1), (10, 2.0), (20, 0.5), (20, 2.0), (40, 0.5)):
        for seed in range(3):
            metamodels = fitted(three_slopes, runs, scatter, seed)
            found = estimate_sensitivity(metamodels, points=128)
            (sentence,) = found.in_words()
            refused.append((metamodels.models[0].leave_one_out().q2, not found.is_known(0)))
            assert found.is_known(0) == sentence.startswith("y depends on x0")
    assert all(is_refused for q2, is_refused in refused if q2 < 0.5)
    assert np.mean([is_refused for q2, is_refused in refused if q2 > 0.8]) < 0.2
    found = estimate_sensitivity(fitted(ishigami, 20, 0.0, 1), points=128)
    assert found.in_words()[0].startswith("On which parameters y depends is not known: its meta")
    uncertainty = 100 * found.uncertainty(0)
    assert messages.SENSITIVITY_NOT_KNOWN.is_in(found.in_words()[0], uncertainty=uncertainty)


def test_a_parameter_whose_interval_reaches_far_is_not_called_hardly_important() -> None:
    shares = np.array([[0.95, 0.03, 0.02]])
    found = Sensitivity(
        ("x0", "x1", "x2"),
        ("y",),
        *(shares, 0.9 * shares, shares, shares, 0.9 * shares, np.array([[0.97, 0.3, 0.05]])),
    )
    assert found.in_words() == (
        "y depends on x0 (95 % of its variance), perhaps on x1, hardly on x2.",
    )


def test_surfaces_have_the_mean_and_the_error_of_the_metamodel() -> None:
    metamodels = fitted(three_slopes, 15, 0.5, 1)
    points = np.random.default_rng(2).random((50, 3))
    drawn = draw_surfaces(metamodels.models[0], points, 4000, np.random.default_rng(3))
    expected = metamodels.models[0].predict(points)
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    error = expected.standard_error
    np.testing.assert_allclose((drawn.mean(axis=0) - expected.mean) / error, 0.0, atol=0.15)
    np.testing.assert_allclose((high - low) / (2 * 1.96 * error), 1.0, atol=0.2)
    smooth = fitted(lambda x: np.sin(3.0 * x[:, 0]) + x[:, 1] * x[:, 2], 30, 0.0, 1).models[0]
    at_runs = np.array(smooth.to_plain()["points"])
    at, between = (
        draw_surfaces(smooth, where, 100, np.random.default_rng(3)) for where in (at_runs, points)
    )
    assert np.median(at.std(axis=0)) < 0.8 * np.median(between.std(axis=0))
