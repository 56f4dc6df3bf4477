"""Information of measurements about parameters, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from grainfit.bulk_tests.accuracy import Accuracy, usual_accuracy
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.problem import Parameter
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.knowledge import Knowledge

NAMES = ("a", "b", "c")


def test_the_covariance_after_measurements_is_that_of_bayes() -> None:
    random = np.random.default_rng(1)
    root = random.normal(size=(3, 3))
    covariance, slopes = root @ root.T, random.normal(size=(4, 3))
    named = [dict(zip(NAMES, row, strict=True)) for row in slopes.tolist()]
    root = random.normal(size=(4, 4))
    independent = np.diag(random.uniform(0.01, 1.0, 4))
    for errors in (independent, root @ root.T + independent):
        after = Knowledge(NAMES, covariance).after(named, errors).covariance
        precision = np.linalg.inv(covariance) + slopes.T @ np.linalg.solve(errors, slopes)
        assert after == pytest.approx(np.linalg.inv(precision))


def test_a_response_tells_nothing_of_a_parameter_that_it_does_not_name() -> None:
    before = Knowledge(("a", "b"), np.diag([0.04, 0.09]))
    after = before.after([{"a": 1.0}], [[1e-4]])
    assert after.deviation("b") == before.deviation("b") == pytest.approx(0.3)
    assert after.deviation("a") == pytest.approx(0.01, rel=1e-2)
    assert before.without(["a"]).names == ("b",)


def test_an_even_spread_over_an_interval_is_counted_in_shares_of_the_value() -> None:
    parameters = [Parameter("a", 1.0, 3.0), Parameter("b", 1.0, 100.0, "log")]
    known = Knowledge.of_intervals(parameters)
    assert known.deviation("a") == pytest.approx(1.0 / 12**0.5)
    assert known.deviation("b") == pytest.approx(np.log(100) / 12**0.5)


def test_a_parameter_that_was_measured_directly_is_known_that_well() -> None:
    parameter = Parameter("a", 0.1, 0.9, measured=0.5, uncertainty=0.015)
    assert Knowledge.of_intervals([parameter]).deviation("a") == pytest.approx(0.03)


def test_a_measurement_has_the_error_of_laboratory_runs_and_slopes() -> None:
    response = CandidateResponse("heap.angle", 20.0, Accuracy(0.5), {"a": 2.0}, 0.05, 1e-4)
    assert response.variance() == pytest.approx(0.025**2 + 0.05**2 / 5 + 1e-4)
    assert response.variance(2.0) == pytest.approx(0.05**2 + 0.05**2 / 5 + 1e-4)
    before = Knowledge(("a",), np.array([[0.01]]))
    assert response.signal_to_noise(before) == pytest.approx(0.2 / response.variance() ** 0.5)


def test_every_response_of_the_bulk_tests_has_a_usual_accuracy() -> None:
    for test in BUILT_IN.values():
        for name, info in test.responses.items():
            assert 0 < usual_accuracy(name, info.unit).value <= 1.0
    assert usual_accuracy("angle", "deg").in_words("deg") == "1°"
    assert usual_accuracy("energy", "J").in_words("J") == "5 %"
