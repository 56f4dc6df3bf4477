"""Distributions of particle sizes against quadrature of their densities."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import lognorm, weibull_min

from grainfit import ground_messages
from grainfit.errors import InputError
from grainfit.materials.size_distributions import (
    LogNormal,
    RosinRammler,
    SieveCurve,
    SizeDistribution,
)
from grainfit.materials.sizes import ParticleSizes

LOG_NORMALS = st.builds(
    LogNormal,
    median=st.floats(1e-4, 1e-2),
    geometric_standard_deviation=st.floats(1.05, 3.0),
)
ROSIN_RAMMLERS = st.builds(RosinRammler, d63=st.floats(1e-4, 1e-2), exponent=st.floats(0.4, 12.0))
ORDERS = st.sampled_from([-3, -2, -1, 0, 1])
#: Shares of the mass at the ends of a part, apart from each other.
PARTS = st.tuples(st.floats(0.001, 0.9), st.floats(0.01, 0.99)).filter(lambda p: p[1] - p[0] > 0.01)


@st.composite
def sieve_curves(draw: st.DrawFn) -> SieveCurve:
    """Two to eight sieves, of which some may retain nothing."""
    steps = draw(st.lists(st.floats(1.05, 3.0), min_size=1, max_size=7))
    masses = draw(st.lists(st.floats(0.0, 1.0), min_size=len(steps), max_size=len(steps)))
    assume(sum(masses) > 0.1)
    openings, shares = [2e-4], [0.0]
    for step, mass in zip(steps, masses, strict=True):
        openings.append(openings[-1] * step)
        shares.append(min(shares[-1] + mass / sum(masses), 1.0))
    shares[-1] = 1.0
    return SieveCurve(tuple(openings), tuple(shares))


def by_quadrature(density: Callable[[float], float], order: int, low: float, high: float) -> float:
    """Return the integral of d^order times a density, over the logarithm of d."""
    integral = quad(
        lambda t: math.exp((order + 1) * t) * density(math.exp(t)),
        math.log(low),
        math.log(high),
        epsabs=0,
        epsrel=1e-10,
        limit=200,
    )
    return float(integral[0])


def assert_moments(
    distribution: SizeDistribution,
    density: Callable[[float], float],
    order: int,
    part: tuple[float, float],
) -> None:
    low, high = map(distribution.quantile, part)
    found = distribution.moment(order, low, high)
    assert found == pytest.approx(by_quadrature(density, order, low, high), rel=1e-6)


@settings(max_examples=30)
@given(LOG_NORMALS, ORDERS, PARTS)
def test_moments_of_log_normal_distributions(
    distribution: LogNormal, order: int, part: tuple[float, float]
) -> None:
    known = lognorm(
        math.log(distribution.geometric_standard_deviation or 0), 0, distribution.median
    )

    assert_moments(distribution, known.pdf, order, part)
    assert distribution.passing(distribution.quantile(part[0])) == pytest.approx(part[0])


@settings(max_examples=30)
@given(ROSIN_RAMMLERS, ORDERS, PARTS)
def test_moments_of_rosin_rammler_distributions(
    distribution: RosinRammler, order: int, part: tuple[float, float]
) -> None:
    known = weibull_min(distribution.exponent, 0, distribution.d63)

    assert_moments(distribution, known.pdf, order, part)
    assert distribution.passing(distribution.quantile(part[0])) == pytest.approx(part[0])


@settings(max_examples=30)
@example(
    SieveCurve((2e-4, 2.5e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 0.016), (0.0, *[0.6] * 5, 0.8, 1.0)),
    -3,
    (0.5, 0.8125),
)
@given(sieve_curves(), ORDERS, PARTS)
def test_moments_of_sieve_curves(curve: SieveCurve, order: int, part: tuple[float, float]) -> None:
    low, high = map(curve.quantile, part)
    found = curve.moment(order, low, high)
    known = by_steps(curve, order, low, high)
    assert found == pytest.approx(known, rel=1e-4)
    assert curve.passing(low) == pytest.approx(part[0], abs=1e-9)


def by_steps(curve: SieveCurve, order: int, low: float, high: float) -> float:
    """Return the integral of d^order over the passing, as a sum over narrow steps.

    None of them goes past a sieve: there the density jumps.
    """
    steps = 1000
    even = [low * (high / low) ** (i / steps) for i in range(steps + 1)]
    ends = sorted({*even, *(opening for opening in curve.openings if low < opening < high)})
    shares = [curve.passing(end) for end in ends]
    return sum(
        (second - first) * math.sqrt(a * b) ** order
        for (a, b), (first, second) in zip(pairwise(ends), pairwise(shares), strict=True)
    )


def test_a_log_normal_distribution_by_two_quantiles() -> None:
    distribution = LogNormal(d10="2 mm", d90="4.5 mm")

    assert distribution.passing(0.002) == pytest.approx(0.1)
    assert distribution.passing(0.0045) == pytest.approx(0.9)


def test_between_two_sieves_mass_is_even_over_the_logarithm() -> None:
    curve = SieveCurve((0.001, 0.004), (0.0, 1.0))

    assert curve.passing(0.002) == pytest.approx(0.5)
    assert curve.quantile(0.5) == pytest.approx(0.002)
    assert curve.passing(0.0005) == 0
    assert curve.passing(0.008) == 1


def test_the_surface_of_a_wide_rosin_rammler_distribution_is_infinite() -> None:
    assert RosinRammler(d63=0.003, exponent=1.0).moment(-1, 0, 1) == math.inf
    assert RosinRammler(d63=0.003, exponent=1.01).moment(-1, 0, 1) < math.inf
    assert RosinRammler(d63=0.003, exponent=1.0).moment(-1, 1e-5, 1) < math.inf


@pytest.mark.parametrize(
    ("make", "key", "words"),
    [
        (lambda: LogNormal(median="3 mm"), "", "has median"),
        (lambda: LogNormal(), "", "has nothing"),
        (
            lambda: LogNormal(median="3 mm", geometric_standard_deviation=1.4, d10="1 mm"),
            "",
            "d10, geometric_standard_deviation, median",
        ),
        (lambda: LogNormal(d10="3 mm", d90="1 mm"), "d10", "3 mm is not below d90, 1 mm"),
        (lambda: LogNormal(median="3 kg", geometric_standard_deviation=1.4), "median", "kg"),
        (
            lambda: LogNormal(median="3 mm", geometric_standard_deviation=1.0),
            "geometric_standard_deviation",
            "1.0",
        ),
        (lambda: RosinRammler(d63="3 mm"), "exponent", "is missing"),
        (lambda: RosinRammler(d63="3 mm", exponent=0.1), "exponent", "0.1"),
        (lambda: SieveCurve((0.001,), (1.0,)), "point 1", "1 opening"),
        (lambda: SieveCurve((0.001, 0.002), (0.5, 0.2)), "point 2", "has a passing of 20 %"),
        (lambda: SieveCurve((0.002, 0.001), (0.0, 1.0)), "point 2", "larger opening"),
        (lambda: SieveCurve((0.001, 0.002), (0.0, 1.2)), "point 2", "120 %"),
        (lambda: SieveCurve((0.001, 2.0), (0.0, 1.0)), "point 2", "2 m"),
        (lambda: SieveCurve((0.001, 0.002), (0.0, math.nan)), "point 2", "nan"),
    ],
)
def test_impossible_distributions_are_refused(
    make: Callable[[], SizeDistribution], key: str, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        make()

    [fault] = caught.value.faults
    assert fault.key == key
    assert words in fault.message


def test_arrays_are_sequences_of_sizes() -> None:
    sizes = ParticleSizes(np.array([0.005, 0.006]), np.array([0.5, 0.5]), np.float64(2))
    assert repr(sizes.definition()) == repr(
        ParticleSizes((0.005, 0.006), (0.5, 0.5), 2.0).definition()
    )
    curve = SieveCurve(np.array([0.001, 0.002]), np.array([0.0, 1.0]))
    assert curve == SieveCurve((0.001, 0.002), (0.0, 1.0))


@pytest.mark.parametrize("given", [np.array(["5 mm", "6 mm"]), np.array(0.5), np.int64(1)])
def test_sizes_that_are_no_numbers_are_named(given: object) -> None:
    for make in (ParticleSizes, SieveCurve):
        with pytest.raises(InputError) as caught:
            make(given, (0.5, 0.5))  # type: ignore[operator]
        assert ground_messages.NO_NUMBERS.is_in(str(caught.value))
