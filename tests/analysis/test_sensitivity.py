"""Sobol' indices against closed forms."""

import warnings

import numpy as np
import pytest
from given_metamodels import Given, given

from grainfit.analysis import estimate_sensitivity
from grainfit.errors import InputError
from grainfit.problem import Target


def ishigami(x: np.ndarray) -> np.ndarray:
    first, second, third = (np.pi * (2.0 * x - 1.0)).T
    return 10.0 + np.sin(first) + 7.0 * np.sin(second) ** 2 + 0.1 * third**4 * np.sin(first)


def linear(x: np.ndarray) -> np.ndarray:
    return 100.0 + 3.0 * x[:, 0] - 1.0 * x[:, 1]


def constant(x: np.ndarray) -> np.ndarray:
    return 5.0 + 1e-13 * x[:, 0]


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
    with pytest.raises(InputError, match=r"points: is 1000\. Give a power of two"):
        estimate_sensitivity(given([Target("y", 10.0)], [Given(linear)], 3), points=1000)
