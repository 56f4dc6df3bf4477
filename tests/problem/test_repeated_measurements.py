"""Tests of targets that are repeated measurements."""

import math

import pytest

from grainfit import InputError, Target
from grainfit.messages import Message
from grainfit.problem import messages


@pytest.mark.parametrize(
    ("name", "values", "tolerance"),
    [
        ("bulk_density", ["528 kg/m^3", 534, 531], 5.31),
        ("angle_of_repose", ["22 deg", 22.1], 0.5),
        ("angle_of_repose", ["21.4 deg", 22.9, 21.8], 4.3027 / 1.96 * 0.44845),
    ],
)
def test_repeats_alone_give_no_tolerance_finer_than_1_percent_or_half_a_degree(
    name: str, values: list[float | str], tolerance: float
) -> None:
    assert Target.of_measurements(name, values).tolerance == pytest.approx(tolerance, rel=1e-3)


def test_students_factor_makes_1_96_uncertainties_the_half_width_of_the_mean() -> None:
    # Student's t of 0.975 with 2 degrees of freedom is 4.3027; the standard deviation is 3.
    target = Target.of_measurements("bulk_density", [528, 534, 531])
    assert 1.96 * (target.uncertainty or 0) == pytest.approx(4.3027 * 3 / math.sqrt(3), rel=1e-4)


def test_the_systematic_part_adds_to_the_random_one_and_lifts_the_limit() -> None:
    repeats = Target.of_measurements("angle_of_repose", ["22 deg", "22.02 deg"])
    both = Target.of_measurements("angle_of_repose", ["22 deg", "22.02 deg"], systematic="0.1 deg")
    assert both.uncertainty == pytest.approx(math.hypot(repeats.uncertainty or 0, 0.1))
    assert both.tolerance == both.uncertainty < repeats.tolerance == 0.5


def test_a_systematic_share_is_one_of_the_mean_and_a_tolerance_is_taken_as_given() -> None:
    target = Target.of_measurements("flow", [10, 10], systematic="2 %", tolerance="0.1 %")
    assert (target.uncertainty, target.tolerance) == (0.2, 0.01)


@pytest.mark.parametrize(
    ("values", "systematic", "message"),
    [
        ([], None, messages.FEW_MEASUREMENTS),
        ([5], None, messages.FEW_MEASUREMENTS),
        ("55", None, messages.FEW_MEASUREMENTS),
        (None, None, messages.FEW_MEASUREMENTS),
        ([5, 5], None, messages.EQUAL_MEASUREMENTS),
        ([5, math.nan], None, messages.NO_NUMBER),
        ([5, None], None, messages.NO_NUMBER),
        ([5, 6], 0, messages.NOT_ABOVE_ZERO),
        ([5, 6], True, messages.NOT_ABOVE_ZERO),
        ([-5, 5], "1 %", messages.SHARE_OF_ZERO),
    ],
)
def test_what_cannot_be_measurements_is_refused(
    values: list[float], systematic: float | str | None, message: Message
) -> None:
    with pytest.raises(InputError, match=message.pattern):
        Target.of_measurements("angle", values, systematic=systematic)
