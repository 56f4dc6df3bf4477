"""Classes keep mass and surface of a distribution, and lose of the rest what is documented."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grainfit as gf
from grainfit.bulk_tests.packing import Packing
from grainfit.errors import InputError
from grainfit.materials.size_classes import divide_into_classes
from grainfit.materials.size_distributions import (
    LogNormal,
    RosinRammler,
    SieveCurve,
    SizeDistribution,
)
from tests.materials.test_size_distributions import LOG_NORMALS, sieve_curves

CLASSES = st.integers(1, 20)
NARROW = LogNormal(median="3 mm", geometric_standard_deviation=1.4)
WITHOUT_LIMITS = st.one_of(
    LOG_NORMALS,
    sieve_curves(),
    st.builds(RosinRammler, d63=st.floats(1e-3, 1e-2), exponent=st.floats(1.5, 12.0)),
)


def change(distribution: SizeDistribution, order: int, classes: int) -> float:
    """Relative change of a moment by the division."""
    exact = distribution.moment(order, 0, math.inf)
    return divide_into_classes(distribution, classes).mass_moment(order) / exact - 1


@given(WITHOUT_LIMITS, CLASSES)
def test_mass_and_surface_are_kept(distribution: SizeDistribution, classes: int) -> None:
    sizes = divide_into_classes(distribution, classes)

    assert len(sizes.diameters) == classes
    assert sizes.mass_fractions == pytest.approx([1 / classes] * classes)
    assert list(sizes.diameters) == sorted(sizes.diameters)
    surface = distribution.moment(-1, 0, math.inf)
    assert 1 / sizes.sauter_diameter == pytest.approx(surface, rel=1e-9)


@given(LOG_NORMALS, CLASSES, st.floats(0.0, 0.4), st.floats(0.0, 0.4))
def test_truncated_classes_keep_the_surface_of_what_is_left(
    distribution: LogNormal, classes: int, fine: float, coarse: float
) -> None:
    low, high = distribution.quantile(0.01 + fine), distribution.quantile(0.99 - coarse)

    sizes = divide_into_classes(distribution, classes, smallest=low, largest=high)

    mean = distribution.moment(-1, low, high) / distribution.moment(0, low, high)
    assert 1 / sizes.sauter_diameter == pytest.approx(mean, rel=1e-9)
    assert low <= min(sizes.diameters)
    assert max(sizes.diameters) <= high


@pytest.mark.parametrize(
    ("spread", "classes", "number", "mean_diameter"),
    [
        # The table of docs/developers/evidence.md.
        (1.2, 5, -0.013, -0.003),
        (1.4, 5, -0.058, -0.012),
        (1.4, 10, -0.031, -0.005),
        (1.7, 5, -0.199, -0.032),
        (1.7, 10, -0.127, -0.014),
        (2.2, 5, -0.514, -0.076),
    ],
)
def test_other_moments_change_as_documented(
    spread: float, classes: int, number: float, mean_diameter: float
) -> None:
    distribution = LogNormal(median="3 mm", geometric_standard_deviation=spread)

    assert change(distribution, -3, classes) == pytest.approx(number, abs=6e-4)
    assert change(distribution, 1, classes) == pytest.approx(mean_diameter, abs=6e-4)


def test_truncation_and_changes_are_told() -> None:
    sizes = divide_into_classes(NARROW, 4, smallest="2 mm", largest="6 mm")

    assert sizes.origin is not None
    first, second, third = sizes.origin.describe(sizes)
    assert "log-normal, median 3 mm, geometric standard deviation 1.4" in first
    assert "4 diameters of 25 % of the mass: " in first
    assert f"of particles by {100 * _number_change(sizes):+.1f} %" in second
    fine, coarse = NARROW.passing(0.002), 1 - NARROW.passing(0.006)
    assert f"The finest {100 * fine:.3g} % and the coarsest {100 * coarse:.3g} %" in third


def _number_change(sizes: gf.ParticleSizes) -> float:
    exact = NARROW.moment(-3, 0.002, 0.006) / NARROW.moment(0, 0.002, 0.006)
    return sizes.mass_moment(-3) / exact - 1


def test_the_finest_share_can_be_left_out() -> None:
    sizes = divide_into_classes(NARROW)
    assert sizes.origin is not None

    limit, rest = sizes.origin.without_finest(0.05)

    assert limit == pytest.approx(NARROW.quantile(0.05), rel=3e-3)
    assert rest == divide_into_classes(NARROW, smallest=limit)
    assert min(rest.diameters) > min(sizes.diameters)


def test_where_classes_come_from_is_no_part_of_a_run() -> None:
    sizes = divide_into_classes(NARROW)
    same = gf.ParticleSizes(sizes.diameters, sizes.mass_fractions)

    assert same == sizes
    assert Packing(same).definition() == Packing(sizes).definition()


def test_bulk_tests_take_distributions() -> None:
    as_option = Packing(
        diameter={
            "log_normal": {"median": "3 mm", "geometric_standard_deviation": 1.4},
            "classes": 3,
        }
    )

    assert as_option.sizes == divide_into_classes(NARROW, 3)


SIEVES = SieveCurve((0.001, 0.002, 0.004), (0.05, 0.5, 0.9))


@pytest.mark.parametrize(
    ("distribution", "limits", "keys", "words"),
    [
        (NARROW, {"smallest": "9 mm"}, ["smallest"], "the limits leave 0.05"),
        (NARROW, {"largest": "1 mm"}, ["largest"], "the limits leave 0.05"),
        (NARROW, {"smallest": "4 mm", "largest": "3 mm"}, ["smallest"], "4 mm is not below"),
        (NARROW, {"classes": 21}, ["classes"], "21"),
        (RosinRammler(d63="3 mm", exponent=0.9), {}, ["smallest"], "is infinite"),
        (
            LogNormal(median="1 um", geometric_standard_deviation=5),
            {},
            ["smallest"],
            "would have a diameter of",
        ),
        (SIEVES, {}, ["", ""], "5 % of the mass pass the finest sieve, 1 mm"),
        (SIEVES, {"smallest": "1 mm"}, [""], "only 90 % of the mass pass the coarsest sieve, 4 mm"),
    ],
)
def test_impossible_classes_are_refused(
    distribution: SizeDistribution, limits: dict[str, str], keys: list[str], words: str
) -> None:
    with pytest.raises(InputError) as caught:
        divide_into_classes(distribution, **limits)

    assert [fault.key for fault in caught.value.faults] == keys
    assert words in caught.value.faults[0].message


def test_unknown_ends_of_a_sieve_curve_can_be_left_out() -> None:
    sizes = divide_into_classes(SIEVES, smallest="1 mm", largest="4 mm")

    assert 0.001 < min(sizes.diameters) < max(sizes.diameters) < 0.004
