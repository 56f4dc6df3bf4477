"""Measured curves: points, errors, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from grainfit.errors import InputError
from grainfit.evaluation import Curve
from grainfit.problem import CurveTarget

POINTS: dict[str, Any] = {"coordinates": [0.1, 0.2, 0.3], "values": [1.0, 2.0, 4.0]}


def test_common_errors_are_the_same_at_all_points() -> None:
    curve = CurveTarget("stress", **POINTS, uncertainty=0.1, systematic=0.2)

    assert curve.covariance_about(curve.values) == pytest.approx(0.01 * np.eye(3) + 0.04)


def test_percentage_is_a_share_of_the_true_values() -> None:
    curve = CurveTarget("stress", **POINTS, uncertainty="10 %")

    assert np.sqrt(np.diagonal(curve.covariance_about([2.0, 2.0, 2.0]))) == pytest.approx(0.2)
    assert curve.standard_uncertainties == pytest.approx([0.1, 0.2, 0.4])


@pytest.mark.parametrize(
    "errors",
    [
        {"uncertainty": "2 %", "systematic": "1 %"},
        {"uncertainty": [0.1, 0.2, 0.3], "tolerance": "5 %"},
        {"covariance": np.diag([1.0, 2.0, 3.0]) + 0.5},
    ],
)
def test_curve_target_survives_json(errors: dict[str, Any]) -> None:
    curve = CurveTarget("stress", **POINTS, **errors, unit="Pa", coordinate="strain")

    assert CurveTarget.from_json(curve.to_json()) == curve


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"coordinates": [0.1, 0.2]}, "has 2 coordinates and 3 values"),
        ({"coordinates": [0.1, 0.3, 0.2]}, "do not increase"),
        ({"coordinates": [0.1, 0.2, 0.2]}, "do not increase"),
        ({"values": [1.0, float("nan"), 2.0]}, "not all finite"),
        ({"values": "abc"}, "not all finite"),
        ({"coordinates": [0.1], "values": [1.0]}, "has 1 points"),
        ({"coordinates": range(500), "values": range(500)}, "has 500 points"),
        ({"uncertainty": None}, "is missing"),
        ({"uncertainty": 0.0}, "not above 0"),
        ({"values": [0.0, 1.0, 2.0]}, "not above 0"),
        ({"uncertainty": "much"}, "is 'much'"),
        ({"uncertainty": [0.1, 0.2]}, "does not fit"),
        ({"systematic": -1.0}, "does not fit"),
        ({"covariance": np.eye(3)}, "beside uncertainties"),
        ({"uncertainty": None, "covariance": np.eye(2)}, "has the shape"),
        ({"uncertainty": None, "covariance": np.ones((3, 3))}, "not positive definite"),
        ({"uncertainty": None, "covariance": np.triu(np.ones((3, 3)))}, "not symmetric"),
        ({"uncertainty": None, "covariance": "abc"}, "has the shape"),
        ({"uncertainty": None, "covariance": np.full((3, 3), np.nan)}, "is nan for"),
        ({"uncertainty": 1e-9, "systematic": 1.0}, "not positive definite"),
        ({"values": [1e-170, 2e-170, 3e-170]}, "stress.values: has 1e-170 at position 1"),
        ({"values": [1.0, 2.0, 3e170]}, "stress.values: has 3e[+]170 at position 3"),
        ({"coordinates": [5e-324, 0.1, 0.2]}, "stress.coordinates: has 5e-324 at position 1"),
        ({"uncertainty": 1e-80}, "uncertainty: has 1e-80 at position 1"),
        ({"uncertainty": [1e50, 1.0, 1.0]}, "uncertainty: has 1e[+]50 at position 1"),
        ({"uncertainty": 1e-8, "values": [1.0, 20.0, 300.0]}, "and the largest value 300"),
        ({"uncertainty": None, "covariance": 1e80 * np.eye(3)}, "covariance: is 1e[+]40 at most"),
        ({"name": ""}, "has no name"),
        ({"tolerance": 0.0}, "tolerance: is not above 0"),
        ({"tolerance": "wide"}, "tolerance: is 'wide'"),
    ],
)
def test_impossible_curve_targets_are_refused(changed: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        CurveTarget(**{"name": "stress", **POINTS, "uncertainty": "2 %", **changed})


@pytest.mark.parametrize(
    ("coordinates", "values", "words"),
    [
        ([0.0, 1.0], [1.0], "at least two"),
        ([0.0, 1.0], [1.0, 2.0, 3.0], "are 2, and there are 3"),
        ([1.0, 0.0], [1.0, 2.0], "do not increase"),
        ([0.0, float("inf")], [1.0, 2.0], "not finite"),
        (None, [1.0, 2.0], "not finite"),
    ],
)
def test_impossible_curves_are_refused(coordinates: Any, values: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Curve(coordinates, values)


def test_curve_saved_by_0_2_0_is_read() -> None:
    saved = {"name": "stress", **POINTS, "uncertainty": "2 %", "common_uncertainty": "1 %"}

    assert CurveTarget.from_json(saved).systematic == "1 %"
