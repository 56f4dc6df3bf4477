"""Parameters, targets and problems: transforms and what is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grainfit.errors import InputError
from grainfit.problem import Parameter, Problem, Target


@given(st.floats(0, 1))
def test_log_and_linear_scales_go_there_and_back(position: float) -> None:
    for parameter in (Parameter("E", 1e5, 1e9, "log"), Parameter("density", 1400, 2800)):
        value = parameter.from_unit(position)
        assert parameter.minimum <= value <= parameter.maximum
        assert parameter.to_unit(value) == pytest.approx(position, abs=1e-9)


def test_log_scale_has_its_middle_at_the_geometric_mean() -> None:
    assert Parameter("E", 1e5, 1e9, "log").from_unit(0.5) == pytest.approx(1e7)


@pytest.mark.parametrize(
    ("low", "high", "scale", "word"),
    [
        (2.0, 1.0, "linear", "swapped"),
        (1.0, 1.0, "linear", "equal"),
        (math.nan, 1.0, "linear", "finite"),
        (0.0, math.inf, "linear", "finite"),
        (0.0, 1.0, "log", "log scale"),
        (0.1, 1.0, "cubic", "cubic"),
    ],
)
def test_impossible_intervals_are_refused(low: float, high: float, scale: str, word: str) -> None:
    with pytest.raises(InputError, match=word):
        Parameter("friction", low, high, scale)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [0.0, -3.0, math.nan, math.inf])
def test_targets_must_be_positive_numbers(value: float) -> None:
    with pytest.raises(InputError, match="above 0"):
        Target("angle", value)


def test_tolerance_is_the_users_then_the_uncertainty_then_two_percent() -> None:
    assert Target("a", 50.0, uncertainty=2.0, tolerance=1.5).accepted_deviation == 1.5
    assert Target("a", 50.0, uncertainty=2.0).accepted_deviation == 2.0
    assert Target("a", 50.0).accepted_deviation == pytest.approx(1.0)


def test_every_fault_of_a_problem_is_named_at_once() -> None:
    friction = Parameter("friction", 0, 1)
    with pytest.raises(InputError) as caught:
        Problem([friction, friction], [], rayleigh_weight=-1)
    message = str(caught.value)
    assert "friction" in message
    assert "targets" in message
    assert "rayleigh_weight" in message
