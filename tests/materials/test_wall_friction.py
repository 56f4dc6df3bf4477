"""Wall friction from the angle of an inclined plane."""

import math

import pytest

from grainfit.errors import InputError
from grainfit.materials.wall_friction import friction_about, friction_of_angle
from grainfit.problem import Parameter, messages


@pytest.mark.parametrize("friction", [0.005, 0.1, 0.4, 3.0])
def test_the_friction_of_a_slope_is_that_at_which_a_sled_begins_to_slide(friction: float) -> None:
    # Coulomb on a plane: it slides when m g sin exceeds friction times m g cos.
    angle = math.degrees(math.atan(friction))

    assert friction_of_angle(angle) == pytest.approx(friction, rel=1e-12)
    assert friction_of_angle(f"{angle} deg") == pytest.approx(friction, rel=1e-12)
    assert friction_of_angle(f"{math.radians(angle)} rad") == pytest.approx(friction, rel=1e-12)


def test_the_uncertainty_of_the_angle_becomes_that_of_the_friction() -> None:
    friction, spread, low, high = friction_about(21.8, 0.5)
    steps = [math.tan(math.radians(21.8 + side * 1e-4)) for side in (-1, 1)]

    assert spread == pytest.approx((steps[1] - steps[0]) / 2e-4 * 0.5, rel=1e-6)
    assert low == pytest.approx(math.tan(math.radians(21.8 - 1.5)))
    assert high == pytest.approx(math.tan(math.radians(21.8 + 1.5)))
    assert friction == friction_of_angle(21.8)


def test_the_interval_ends_where_friction_does() -> None:
    assert friction_about(1.0, 0.5)[2] == 0.0
    assert friction_about(80.0, 3.0)[3] < 10.0


@pytest.mark.parametrize(
    ("angle", "uncertainty", "message"),
    [
        ("21.8 mm", 0.5, "angle: '21.8 mm' has the unit mm"),
        (90, 0.5, "angle: is 90. An angle must be at least 0, and below 84 degrees."),
        (-1, 0.5, "angle: is -1"),
        (math.nan, 0.5, "angle: is nan"),
        (20, 0, "uncertainty: is 0. Leave it out"),
        (20, "much", "uncertainty: "),
    ],
)
def test_what_is_no_angle_is_refused(angle: float, uncertainty: float, message: str) -> None:
    with pytest.raises(InputError) as caught:
        friction_about(angle, uncertainty)
    assert message in str(caught.value)


def test_only_wall_friction_is_measured_as_an_angle() -> None:
    with pytest.raises(InputError, match=f"restitution: {messages.NO_TANGENT.pattern}"):
        Parameter.from_angle("particle_wall.restitution", 20, 1)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"measured": 0.5}, "x.uncertainty: is missing. Give both, or neither."),
        ({"uncertainty": 0.5}, "x.measured: is missing"),
        ({"measured": 2.0, "uncertainty": 0.1}, "x.measured: is 2.0. It must be in its interval"),
        ({"measured": 0.5, "uncertainty": 0.0}, "x.uncertainty: is 0.0. It must be a number ab"),
        ({"measured": 0.5, "uncertainty": math.nan}, "x.uncertainty: is nan"),
    ],
)
def test_half_a_measurement_is_refused(given: dict[str, float], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Parameter("x", 0.0, 1.0, **given)
    assert message in str(caught.value)


def test_without_a_measurement_a_parameter_is_written_as_it_always_was() -> None:
    keys = ["name", "minimum", "maximum", "scale", "unit"]
    assert list(Parameter("x", 0.0, 1.0).to_json()) == keys
    measured = Parameter("x", -1.0, 1.0, measured=0.0, uncertainty=0.1).to_json()
    assert list(measured) == [*keys, "measured", "uncertainty"]
    assert Parameter(**measured).to_json() == measured


def test_a_share_is_one_of_the_measured_value() -> None:
    parameter = Parameter("x", 0.0, 100.0, measured=50.0, uncertainty="2 %")
    assert parameter.uncertainty == 1.0
