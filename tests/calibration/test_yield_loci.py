"""Which tests of a calibration give a yield locus, and by which values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

import grainfit as gf
from grainfit.bulk_tests.base import BulkTest
from grainfit.calibration.yield_loci import yield_loci
from grainfit.result import ResponseResult
from grainfit.run_definition import RunDefinition

FREE = "particle_particle.sliding_friction"
FIXED = {"particle.density": 2100.0}
LOW = gf.tests.Shear(diameter="10 mm", normal_stress=250)
HIGH = gf.tests.Shear(diameter="10 mm", normal_stress=1000)


def angle_at(stress: float, cohesion: float, slope: float) -> float:
    return math.degrees(math.atan(cohesion / stress + math.tan(math.radians(slope))))


def run_of(test: BulkTest, friction: float = 0.5, **fixed: float) -> RunDefinition:
    model = {"solver": "lammps", "test": test.definition()}
    return RunDefinition(model, {**FIXED, FREE: friction, **fixed}, 1)


def problem(**angles: float) -> gf.Problem:
    targets = [
        gf.Target(f"{test}.internal_friction_angle", angle, uncertainty=0.5, unit="deg")
        for test, angle in angles.items()
    ]
    return gf.Problem([gf.Parameter(FREE, 0.1, 0.9)], targets)


PROBLEM = problem(low=angle_at(250, 40, 26), high=angle_at(1000, 40, 26))
#: In no order, as runs end.
TESTS = {"high": run_of(HIGH, friction=0.7), "low": run_of(LOW)}


def responses(wanted: gf.Problem, expected: Mapping[str, float]) -> dict[str, ResponseResult]:
    fields: dict[str, Any] = dict.fromkeys(
        ["verified_mean", "verified_standard_error", "verified_interval", "deviation_percent"]
    )
    return {
        target.name: ResponseResult(
            target=target.value,
            tolerance=target.tolerance,
            unit="deg",
            predicted=expected[target.name.partition(".")[0]],
            standard_error=0.2,
            verdict="met",
            **fields,
        )
        for target in wanted.targets
    }


def test_two_stresses_have_the_line_of_the_targets_and_that_of_the_answer() -> None:
    expected = {"low": angle_at(250, 20, 28), "high": angle_at(1000, 20, 28)}
    (locus,) = yield_loci(PROBLEM, TESTS, responses(PROBLEM, expected))

    assert locus.tests == ("low", "high")
    assert locus.measured.normal_stresses == (250.0, 1000.0)
    assert locus.measured.cohesion.value == pytest.approx(40)
    assert locus.measured.internal_friction_angle.value == pytest.approx(26)
    assert locus.expected is not None
    assert locus.expected.cohesion.value == pytest.approx(20)
    assert locus.expected.internal_friction_angle.value == pytest.approx(28)
    # 0.5° and 0.2°, at nearly the same slopes.
    ratio = locus.expected.cohesion.standard_error / locus.measured.cohesion.standard_error
    assert ratio == pytest.approx(0.4, rel=0.05)


def test_before_an_answer_there_is_the_line_of_the_targets() -> None:
    (locus,) = yield_loci(PROBLEM, TESTS, {})
    assert locus.expected is None
    assert str(locus).startswith("Yield locus (low, high): measured cohesion 40.0 ± ")
    assert "expected" not in str(locus)


def test_metamodels_without_an_error_give_no_line() -> None:
    found = responses(PROBLEM, {"low": 30.0, "high": 28.0})
    exact = {name: replace(one, standard_error=0.0) for name, one in found.items()}
    (locus,) = yield_loci(PROBLEM, TESTS, exact)
    assert locus.expected is None


def test_correlated_errors_of_the_angles_are_those_of_the_line() -> None:
    names = [target.name for target in PROBLEM.targets]
    together = replace(PROBLEM, correlations=[(*names, 0.99)])
    (alone,), (common,) = yield_loci(PROBLEM, TESTS, {}), yield_loci(together, TESTS, {})

    # An error that all angles have is one of the slope.
    assert common.measured.cohesion.value == pytest.approx(alone.measured.cohesion.value)
    assert common.measured.cohesion.standard_error < 0.2 * alone.measured.cohesion.standard_error


@pytest.mark.parametrize(
    "tests",
    [
        {"low": TESTS["low"]},
        {"low": run_of(LOW), "high": run_of(LOW)},
        {"low": run_of(LOW), "high": run_of(replace(LOW, normal_stress=250.001))},
        {"low": run_of(LOW), "high": run_of(gf.tests.Heap(diameter="10 mm"))},
        {"low": run_of(LOW), "high": run_of(HIGH, **{"particle.density": 2500.0})},
        {"low": run_of(LOW), "high": run_of(replace(HIGH, diameter="8 mm", sizes=None))},
        {"low": run_of(LOW), "high": RunDefinition({"command": ["shear"]}, {}, 1)},
        {"low": run_of(LOW), "high": RunDefinition({"test": {"type": "shear"}}, {}, 1)},
    ],
)
def test_one_stress_on_one_material_gives_no_line(tests: Mapping[str, RunDefinition]) -> None:
    assert yield_loci(PROBLEM, tests, {}) == ()


def test_a_test_without_a_target_for_its_angle_is_no_point() -> None:
    other = gf.Target("high.shear_density", 1200.0, unit="kg/m^3")
    assert yield_loci(replace(PROBLEM, targets=[PROBLEM.targets[0], other]), TESTS, {}) == ()


def test_each_material_has_its_own_line() -> None:
    names = {"a": (LOW, 1.0), "b": (LOW, 2.0), "c": (HIGH, 1.0), "d": (HIGH, 2.0)}
    tests = {name: run_of(test, **{"particle.density": d}) for name, (test, d) in names.items()}
    loci = yield_loci(problem(a=30, b=31, c=28, d=29), tests, {})
    assert [locus.tests for locus in loci] == [("a", "c"), ("b", "d")]
