"""Verdicts on parameters for samples of known shape."""

import math

import numpy as np
import pytest

from grainfit.analysis import messages as of_analysis
from grainfit.analysis.identifiability import Identifiability, assess_identifiability
from grainfit.analysis.posterior import Posterior
from grainfit.problem import Parameter, Problem, Target

SLIDING = Parameter("particle_particle.sliding_friction", 0.0, 1.0)
ROLLING = Parameter("particle_particle.rolling_friction", 0.0, 2.0)
DENSITY = Parameter("particle.density", 2000.0, 3000.0, unit="kg/m^3")
MODULUS = Parameter("particle.youngs_modulus", 1e6, 1e8, "log", unit="Pa")
OWN = Parameter("cohesion", 0.0, 1.0)

COUNT = 4000


def judged(parameters: list[Parameter], *columns: np.ndarray, target: str = "y") -> Identifiability:
    problem = Problem(parameters, [Target(target, 1.0)])
    points = np.column_stack(columns)
    values = np.array([list(problem.from_unit(point).values()) for point in points])
    posterior = Posterior(tuple(parameters), points, values, np.ones((COUNT, 1)), True, "", 1000.0)
    return assess_identifiability(posterior, problem)


@pytest.fixture
def random() -> np.random.Generator:
    return np.random.default_rng(1)


def test_a_ridge_is_told_with_both_names_and_the_values_at_its_ends(
    random: np.random.Generator,
) -> None:
    x = random.uniform(0.1, 0.9, COUNT)
    y = 1.0 - x + random.normal(0.0, 0.005, COUNT)
    density = random.normal(0.5, 0.015, COUNT)
    found = judged([SLIDING, DENSITY, ROLLING], x, density, y)
    ridge, determined = found.verdicts
    start, end = (
        float(number) for number in ridge.split("sliding_friction ")[2].split(",")[0].split(" → ")
    )
    assert ridge.startswith(
        "particle_particle.sliding_friction and particle_particle.rolling_friction cannot be told "
        "apart by these tests: any pair along particle_particle.sliding_friction "
    )
    assert (start, end) == pytest.approx((0.12, 0.88), abs=0.03)
    # The cube's 1 is a rolling friction of 2.
    others = [float(n) for n in ridge.split("rolling_friction ")[2].split(" fits")[0].split(" → ")]
    assert others == pytest.approx([2 - 2 * start, 2 - 2 * end], abs=0.05)
    assert determined.startswith("particle.density is determined to ±1.2 % (24")
    assert determined.endswith("kg/m³).")
    assert [d.determined for d in found.directions] == [True, True, False]
    best = found.directions[0].components
    wanted = {SLIDING.name: 0.5**0.5, ROLLING.name: 0.5**0.5, DENSITY.name: 0.0}
    assert best == pytest.approx(wanted, abs=0.02)
    assert found.directions[0].narrowing == pytest.approx(0.005 / 2**0.5 * 12**0.5, rel=0.1)
    (test,) = found.further_tests
    assert "draw-down test" in test
    assert "uniaxial compression" in test


@pytest.mark.parametrize("shape", ["hyperbola", "parabola", "ring"])
def test_a_curved_ridge_is_a_ridge(shape: str, random: np.random.Generator) -> None:
    if shape == "hyperbola":
        x = 0.1 * 10 ** random.random(COUNT)
        y = 0.1 / x
    elif shape == "parabola":
        x = random.random(COUNT)
        y = 4.0 * (x - 0.5) ** 2
    else:
        angle = random.uniform(0.0, 2 * math.pi, COUNT)
        x, y = 0.5 + 0.45 * np.cos(angle), 0.5 + 0.45 * np.sin(angle)
    found = judged([SLIDING, OWN], x, y + random.normal(0.0, 0.005, COUNT))
    (verdict,) = found.verdicts
    assert of_analysis.SETS_FIT.is_in(verdict)
    stops = [
        [float(number) for number in part.split(" fits")[0].rsplit("n ", 1)[1].split(" → ")]
        for part in verdict.replace("−", "-").split("along ")[1].split(", ")
    ]
    for first, second in zip(*stops, strict=True):
        on = {
            "hyperbola": first * second - 0.1,
            "parabola": second - 4 * (first - 0.5) ** 2,
            "ring": math.hypot(first - 0.5, second - 0.5) - 0.45,
        }
        assert on[shape] == pytest.approx(0.0, abs=0.06)
    assert len(stops[0]) == 3


def test_three_parameters_of_which_only_the_sum_is_known_are_one_group(
    random: np.random.Generator,
) -> None:
    points = random.random((40 * COUNT, 3))
    points = points[np.abs(points.sum(axis=1) - 1.5) < 0.02][:COUNT]
    found = judged([SLIDING, ROLLING, OWN], *points.T)
    (verdict,) = found.verdicts
    assert verdict.startswith(
        "particle_particle.sliding_friction, particle_particle.rolling_friction and cohesion "
        "cannot be told apart by these tests: "
    )


def test_what_is_not_determined_comes_before_what_is(random: np.random.Generator) -> None:
    found = judged(
        [DENSITY, MODULUS, ROLLING, OWN],
        random.normal(0.3, 0.01, COUNT),
        random.random(COUNT),
        random.uniform(0.3, 0.8, COUNT),
        random.uniform(0.001, 0.03, COUNT),
    )
    modulus, rolling, density, own = found.verdicts
    assert modulus == (
        "particle.youngs_modulus is not determined: 1·10⁶ to 1·10⁸ Pa with 95 % probability."
    )
    assert rolling.startswith("particle_particle.rolling_friction is only narrowed: 0.")
    # Percent of next to nothing would look like a lot.
    assert own.startswith("cohesion is determined: ")
    assert density.startswith("particle.density is determined to ±0.8")
    assert found.narrowing[MODULUS.name] == pytest.approx(1.0, abs=0.02)
    assert found.narrowing[ROLLING.name] == pytest.approx(0.5, abs=0.02)
    assert [test.split(":")[0] for test in found.further_tests] == [
        "To determine particle.youngs_modulus",
        "To determine particle_particle.rolling_friction",
    ]


def test_a_determined_parameter_that_hangs_on_an_open_one_says_so(
    random: np.random.Generator,
) -> None:
    modulus = random.random(COUNT)
    density = 0.4 + 0.2 * modulus + random.normal(0.0, 0.01, COUNT)
    found = judged([DENSITY, MODULUS, OWN], density, modulus, random.normal(0.5, 0.01, COUNT))
    assert found.verdicts[1].startswith("particle.density is determined to ±")
    assert found.verdicts[1].endswith(" It would be known better if particle.youngs_modulus were.")
    assert found.verdicts[2].endswith(").")


def test_independent_parameters_are_no_ridge(random: np.random.Generator) -> None:
    found = judged([SLIDING, ROLLING, OWN], *random.random((3, COUNT)))
    assert all("is not determined" in verdict for verdict in found.verdicts)
    assert [d.determined for d in found.directions] == [False] * 3


def test_a_parameter_that_bulk_tests_do_not_see_is_better_fixed(
    random: np.random.Generator,
) -> None:
    ratio = Parameter("wall.poissons_ratio", 0.1, 0.4)
    found = judged([ratio, OWN], *random.random((2, COUNT)))
    fixed, own = sorted(found.further_tests, reverse=True)
    assert fixed.startswith("wall.poissons_ratio hardly changes any common bulk test: take it out")
    assert own == "To determine cohesion: add a target of a test that responds to it."


def test_the_angle_of_a_heap_is_not_proposed_where_it_is_a_target(
    random: np.random.Generator,
) -> None:
    [proposed] = judged([ROLLING], random.random(COUNT)).further_tests
    assert "the angle of repose of a heap (" in proposed
    [not_again] = judged([ROLLING], random.random(COUNT), target="angle_of_repose").further_tests
    assert "heap (" not in not_again
    assert "angle of repose is measured already" in not_again


def test_the_ends_of_a_narrow_interval_differ_in_what_is_shown(
    random: np.random.Generator,
) -> None:
    (verdict,) = judged([DENSITY], random.normal(0.5, 1e-4, COUNT)).verdicts
    assert verdict == "particle.density is determined to ±0.008 % (2499.8 to 2500.2 kg/m³)."


def test_a_single_parameter_is_judged_too(random: np.random.Generator) -> None:
    found = judged([DENSITY], random.normal(0.5, 0.01, COUNT))
    (direction,) = found.directions
    assert direction.components == {DENSITY.name: 1.0}
    assert direction.narrowing == pytest.approx(0.01 * 12**0.5, rel=0.1)


def test_independent_parameters_of_equal_spread_are_not_called_inseparable() -> None:
    for seed in range(20):
        random = np.random.default_rng(seed)
        cloud = random.normal(0.5, 0.0675, (3, COUNT))
        found = judged([SLIDING, ROLLING, OWN], *cloud)
        assert not any("told apart" in verdict for verdict in found.verdicts)


def test_what_a_determined_parameter_hangs_on_is_not_inseparable_for_that(
    random: np.random.Generator,
) -> None:
    b, c = random.random((2, COUNT))
    a = 0.4 * (b + c) + random.normal(0.0, 0.01, COUNT)
    found = judged([SLIDING, ROLLING, OWN], 0.25 * a, b, c)
    assert not any("told apart" in verdict for verdict in found.verdicts)


def test_two_peaks_are_two_ranges(random: np.random.Generator) -> None:
    peaks = np.where(random.random(COUNT) < 0.5, 0.03, 0.97) + random.normal(0.0, 0.004, COUNT)
    (verdict,) = judged([DENSITY], peaks).verdicts
    assert verdict == (
        "particle.density is not determined: 2000 to 2050 or 2950 to 3000 kg/m³ fits."
    )


@pytest.mark.parametrize(("middle", "bound"), [(0.02, "min"), (0.5, ""), (0.98, "max")])
def test_a_parameter_whose_interval_reaches_a_bound_is_said_to(
    random: np.random.Generator, middle: float, bound: str
) -> None:
    points = random.normal(middle, 0.05, 3 * COUNT)
    inside = points[(points >= 0.0) & (points <= 1.0)][:COUNT]
    (verdict,) = judged([DENSITY], inside).verdicts
    assert of_analysis.UP_TO_BOUND.is_in(verdict, bound=bound) == bool(bound)
    value = DENSITY.from_unit(0.0 if bound == "min" else 1.0)
    assert (f"{value:g}" in verdict) == bool(bound)
