"""Yield locus: closed forms, and errors against Monte Carlo."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from grainfit.evaluation import Response
from grainfit.measurement import messages
from grainfit.measurement.yield_locus import fit_yield_locus


@pytest.mark.parametrize("stresses", [[250.0, 1000.0], [250.0, 500.0, 1000.0, 2000.0]])
@pytest.mark.parametrize("correlation", [0.0, 0.8])
def test_the_yield_locus_of_a_cohesive_material_has_its_cohesion_and_angle(
    stresses: list[float], correlation: float
) -> None:
    cohesion, angle = 40.0, 26.0
    slopes = [cohesion / s + math.tan(math.radians(angle)) for s in stresses]
    angles = [Response(math.degrees(math.atan(slope)), 0.4) for slope in slopes]
    between = np.full((len(stresses), len(stresses)), correlation)
    np.fill_diagonal(between, 1.0)
    locus = fit_yield_locus(stresses, angles, between)
    shear = [found.value for found in locus.shear_stresses]
    assert shear == pytest.approx([cohesion + math.tan(math.radians(angle)) * s for s in stresses])
    assert locus.normal_stresses == tuple(stresses)
    assert locus.cohesion.value == pytest.approx(cohesion)
    assert locus.internal_friction_angle.value == pytest.approx(angle)

    # Stated errors are those of a fit to angles that scatter.
    random = np.random.default_rng(3)
    found = []
    for errors in random.multivariate_normal(np.zeros(len(stresses)), 0.16 * between, 2000):
        noisy = [replace(a, value=a.value + off) for a, off in zip(angles, errors, strict=True)]
        fit = fit_yield_locus(stresses, noisy, between)
        low = fit.shear_stresses[0].value
        found.append((fit.cohesion.value, fit.internal_friction_angle.value, low))
    wanted = (locus.cohesion, locus.internal_friction_angle, locus.shear_stresses[0])
    stated = [one.standard_error for one in wanted]
    # The standard deviation of 2000 has a standard error of 1.6 %.
    assert np.std(found, axis=0) == pytest.approx(stated, rel=0.06)


def test_two_stresses_give_the_line_through_both_points() -> None:
    locus = fit_yield_locus([250.0, 1000.0], [Response(27.0, 0.5), Response(24.0, 0.5)])
    low, high = locus.shear_stresses
    slope = math.tan(math.radians(locus.internal_friction_angle.value))

    assert locus.cohesion.value + 250 * slope == pytest.approx(low.value)
    assert locus.cohesion.value + 1000 * slope == pytest.approx(high.value)
    # Of intercept and slope, by the errors of the two points alone.
    error = math.hypot(1000 * low.standard_error, 250 * high.standard_error) / 750
    assert locus.cohesion.standard_error == pytest.approx(error)
    error = math.hypot(low.standard_error, high.standard_error) / 750 / (1 + slope**2)
    assert locus.internal_friction_angle.standard_error == pytest.approx(math.degrees(error))


@pytest.mark.parametrize(
    ("stresses", "error"), [([500.0], 0.3), ([500.0, 500.0], 0.3), ([500.0, 900.0], 0.0)]
)
def test_a_yield_locus_needs_two_stresses_and_standard_errors(
    stresses: list[float], error: float
) -> None:
    with pytest.raises(
        ValueError, match=f"{messages.TWO_STRESSES.pattern}|{messages.NO_ERRORS.pattern}"
    ):
        fit_yield_locus(stresses, [Response(25.0, error)] * len(stresses))
