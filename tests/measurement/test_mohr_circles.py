"""Yield locus, Mohr circles and flowability against geometry, and their standard errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grainfit.evaluation import Response
from grainfit.measurement.mohr_circles import MohrCircles, ShearTest


def angles_of(frictions: list[float], error: float) -> list[Response]:
    """Return angles with a relative error of their tangents."""
    return [
        Response(math.degrees(math.atan(f)), math.degrees(error * f / (1 + f**2)))
        for f in frictions
    ]


def a_test(cohesion: float, slope: float, steady: float, error: float = 0.01) -> ShearTest:
    """Return a test whose points lie on a line, after a preshear under 1000 Pa."""
    stresses = [200.0, 500.0, 800.0]
    frictions = angles_of([cohesion / s + slope for s in stresses], error)
    return ShearTest(stresses, frictions, 1000.0, *angles_of([steady], error))


@pytest.mark.parametrize("cohesion", [0.0, 40.0, 300.0])
@pytest.mark.parametrize("slope", [0.2, 0.6, 1.1])
@pytest.mark.parametrize("below", [0.7, 0.95])
def test_circles_touch_the_locus_and_go_through_their_points(cohesion, slope, below):
    shear = below * (cohesion + 1000 * slope)
    circles = MohrCircles(cohesion, slope, 1000.0, shear)

    def from_locus(centre: float) -> float:
        return (cohesion + slope * centre) / math.hypot(1.0, slope)

    assert from_locus(circles.centre) == pytest.approx(circles.radius)
    assert math.hypot(1000 - circles.centre, shear) == pytest.approx(circles.radius)
    # The locus ends where it touches, left of the preshear point.
    touching = circles.centre - circles.radius * slope / math.hypot(1.0, slope)
    assert touching < 1000
    assert circles.major_consolidation_stress == pytest.approx(circles.centre + circles.radius)
    half = circles.unconfined_strength / 2
    assert from_locus(half) == pytest.approx(half)
    lean = math.sin(math.radians(circles.effective_angle))
    assert lean == pytest.approx(circles.radius / circles.centre)


def test_a_preshear_point_above_the_locus_counts_as_one_on_it():
    on, above = (MohrCircles(50.0, 0.5, 1000.0, shear) for shear in (550.0, 560.0))
    assert above.major_consolidation_stress == pytest.approx(on.major_consolidation_stress)
    # The circle touches at the preshear point.
    assert on.centre == pytest.approx(1000 + 550 * 0.5)


def test_a_material_without_cohesion_flows_freely_and_has_no_ffc():
    test = a_test(0.0, 0.5, 0.5)
    found = test.responses
    assert "ffc" not in found
    assert test.flows_freely
    assert found["cohesion"].value == pytest.approx(0.0, abs=1e-6)
    assert found["unconfined_strength"].value == pytest.approx(0.0, abs=1e-6)
    for angle in ("phi_lin", "phi_e", "phi_sf"):
        assert found[angle].value == pytest.approx(math.degrees(math.atan(0.5)))
    # Four times the errors tell a quarter of it.
    assert test.least_ffc == pytest.approx(4 * a_test(0.0, 0.5, 0.5, 0.04).least_ffc, rel=0.1)


def test_a_cohesive_material_has_the_ffc_of_its_circles():
    test = a_test(100.0, 0.5, 0.55)
    found = {name: response.value for name, response in test.responses.items()}
    assert not test.flows_freely
    assert found["cohesion"] == pytest.approx(100.0)
    assert found["phi_e"] > found["phi_sf"] > found["phi_lin"]
    ratio = found["major_consolidation_stress"] / found["unconfined_strength"]
    assert found["ffc"] == pytest.approx(ratio)


def test_standard_errors_are_those_of_repeated_tests():
    exact, random = a_test(150.0, 0.45, 0.5, 0.02), np.random.default_rng(3)
    inputs = [*exact.angles, exact.steady_angle]
    repeats: dict[str, list[float]] = {name: [] for name in exact.responses}
    for _ in range(400):
        moved = [
            Response(random.normal(a.value, a.standard_error), a.standard_error) for a in inputs
        ]
        test = ShearTest(exact.normal_stresses, moved[:-1], 1000.0, moved[-1])
        for name, response in test.responses.items():
            repeats[name].append(response.value)
    for name, response in exact.responses.items():
        assert response.standard_error == pytest.approx(np.std(repeats[name]), rel=0.2), name


def test_shear_stress_that_does_not_rise_is_refused():
    with pytest.raises(ValueError, match="does not rise"):
        a_test(500.0, -0.1, 0.4)
