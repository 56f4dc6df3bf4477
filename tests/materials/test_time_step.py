"""Rayleigh time step against the literature's form and its own limits."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grainfit.errors import InputError
from grainfit.materials import messages
from grainfit.materials.particle_shape import ASPECT_RATIO, FAMILIES, ParticleShape
from grainfit.materials.time_step import RayleighTimeStep, rayleigh_time_step
from grainfit.testing.materials import GLASS_BEADS


def test_value_of_the_papers_glass_beads() -> None:
    # Equation 3 by hand: G = 3.6e5 / 2.44, sqrt(2100 / G) = 0.119303, factor 0.912482.
    expected = math.pi * 0.005 * math.sqrt(2100 * 2.44 / 3.6e5) / (0.1631 * 0.22 + 0.8766)
    assert rayleigh_time_step(0.005, 2100.0, 3.6e5, 0.22) == pytest.approx(expected, rel=1e-12)
    assert rayleigh_time_step(0.005, 2100.0, 3.6e5, 0.22) == pytest.approx(2.0538e-3, rel=1e-4)


def test_rayleigh_speed_is_that_of_elasticity() -> None:
    # The wave runs along half the circumference at the speed c of Rayleigh waves, whose exact
    # equation is x^3 - 8 x^2 + 8 x (3 - 2 k) - 16 (1 - k) = 0 with x = (c / c_s)^2 and
    # k = (c_s / c_l)^2 = (1 - 2 nu) / (2 - 2 nu).
    for ratio in (0.0, 0.2, 0.3, 0.45):
        shear_speed = math.sqrt(1e7 / (2 * (1 + ratio)) / 2500.0)
        speed = math.pi * 0.001 / rayleigh_time_step(0.001, 2500.0, 1e7, ratio)
        x = (speed / shear_speed) ** 2
        k = (1 - 2 * ratio) / (2 * (1 - ratio))
        exact = x**3 - 8 * x**2 + 8 * x * (3 - 2 * k) - 16 * (1 - k)
        slope = 3 * x**2 - 16 * x + 8 * (3 - 2 * k)
        # The linear formula of the paper is within 1 % of the exact root.
        assert abs(exact / slope) / (2 * x) < 0.01


@given(
    st.tuples(st.floats(500, 2000), st.floats(2001, 9000)),
    st.tuples(st.floats(1e5, 1e7), st.floats(1.1e7, 1e10)),
    st.tuples(st.floats(0.0, 0.2), st.floats(0.21, 0.49)),
    st.tuples(*[st.floats(0, 1)] * 3),
)
def test_limits_enclose_every_material_in_the_box(
    density: tuple[float, float],
    modulus: tuple[float, float],
    ratio: tuple[float, float],
    inside: tuple[float, float, float],
) -> None:
    names = ("particle.density", "particle.youngs_modulus", "particle.poissons_ratio")
    intervals = dict(zip(names, (density, modulus, ratio), strict=True))
    values = {
        name: low + share * (high - low)
        for (name, (low, high)), share in zip(intervals.items(), inside, strict=True)
    }
    model = RayleighTimeStep(0.004, {})
    smallest, largest = model.limits(intervals)
    assert smallest * (1 - 1e-12) <= model(values) <= largest * (1 + 1e-12)
    assert -1e-9 <= model.criterion(values, intervals) <= 1 + 1e-9


def test_criterion_is_zero_at_the_fastest_and_one_at_the_slowest_material() -> None:
    model = RayleighTimeStep(
        0.005, {"particle.youngs_modulus": 3.6e5, "particle.poissons_ratio": 0.22}
    )
    intervals = {"particle.density": (1400.0, 2800.0)}
    assert model.criterion({"particle.density": 2800.0}, intervals) == pytest.approx(0.0)
    assert model.criterion({"particle.density": 1400.0}, intervals) == pytest.approx(1.0)


def test_criterion_is_zero_when_nothing_free_changes_the_time_step() -> None:
    fixed = {
        "particle.density": 2100.0,
        "particle.youngs_modulus": 3.6e5,
        "particle.poissons_ratio": 0.22,
    }
    model = RayleighTimeStep(0.005, fixed)
    intervals = {"particle_particle.rolling_friction": (0.2, 0.9)}
    assert model.criterion({"particle_particle.rolling_friction": 0.5}, intervals) == 0.0


BEADS = {
    "particle.density": 2100.0,
    "particle.youngs_modulus": 3.6e5,
    "particle.poissons_ratio": 0.22,
}


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("share", [0.003, 0.1, 0.35, 0.72, 1.0])
def test_the_time_step_of_a_free_aspect_ratio_is_that_of_the_clump(
    family: str, share: float
) -> None:
    ratio = 1 + share * (FAMILIES[family].largest - 1)
    clump = ParticleShape(family, aspect_ratio=ratio).clump
    assert clump is not None
    step = RayleighTimeStep(0.005, BEADS, family)({ASPECT_RATIO: ratio})

    exact = rayleigh_time_step(0.01 * clump.rayleigh_radius, *BEADS.values())
    assert step == pytest.approx(exact, rel=0.01)


@pytest.mark.parametrize("family", FAMILIES)
def test_limits_enclose_all_aspect_ratios(family: str) -> None:
    model = RayleighTimeStep(0.005, BEADS, family)
    largest = FAMILIES[family].largest
    for interval in [(1.0, largest), (1.1, 1.35), (1.6, 2.0)]:
        smallest_step, largest_step = model.limits({ASPECT_RATIO: interval})
        ratios = [interval[0] + n / 200 * (interval[1] - interval[0]) for n in range(201)]
        steps = [model({ASPECT_RATIO: ratio}) for ratio in ratios]
        assert smallest_step <= min(steps) * (1 + 1e-12)
        assert largest_step >= max(steps) * (1 - 1e-12)
        assert largest_step == pytest.approx(max(steps), rel=0.01)


def test_a_shape_without_a_free_aspect_ratio_and_an_unknown_one_are_refused() -> None:
    (fault,) = RayleighTimeStep(0.005, BEADS, "grain").faults({})
    assert (fault.key, fault.message) == (ASPECT_RATIO, "is not free, so it needs no shape.")
    (fault,) = RayleighTimeStep(0.005, BEADS, "egg").faults({ASPECT_RATIO: (1.0, 2.0)})
    assert messages.NO_FAMILY.is_in(fault.message, family="egg")


def test_arguments_with_units_are_read_and_impossible_ones_named() -> None:
    known = {"radius": 0.005, "density": 2100.0, "youngs_modulus": 3.6e5, "poissons_ratio": 0.22}
    units = {"radius": "5 mm", "density": "2.1 g/cm^3", "youngs_modulus": "0.36 MPa"}
    assert rayleigh_time_step(**{**known, **units}) == rayleigh_time_step(**known)
    for name in known:
        for wrong in ("much", "5 s", None, [1.0], np.ones(2), math.nan, -1.0):
            with pytest.raises(InputError, match=name):
                rayleigh_time_step(**{**known, name: wrong})  # type: ignore[arg-type]


def test_a_time_step_of_wrong_values_names_them() -> None:
    with pytest.raises(InputError, match="fixed"):
        RayleighTimeStep(0.005, [1])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="radius"):
        RayleighTimeStep("5 mm", GLASS_BEADS)({})  # type: ignore[arg-type]
    with pytest.raises(InputError, match=ASPECT_RATIO):
        RayleighTimeStep(0.005, GLASS_BEADS, "grain")({})
