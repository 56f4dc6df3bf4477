"""Parameters, targets and problems: transforms and what is refused."""

import json
import math
from collections.abc import Callable
from dataclasses import asdict
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grainfit.errors import InputError
from grainfit.materials import messages as of_materials
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.materials.wall_friction import friction_of_angle
from grainfit.problem import CurveTarget, Parameter, Problem, Target, TestScope
from grainfit.problem import messages as of_problem
from grainfit.problem.quantities import shown


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


@pytest.mark.parametrize("several", [np.array([1.0, 2.0]), pd.Series([1.0, 2.0])])
def test_several_numbers_or_names_are_none(several: Any) -> None:
    for make, message in (
        (lambda: Target("x", several), of_problem.NO_NUMBER),
        (lambda: Target(several, 1.0), of_problem.NO_TARGET_NAME),
        (lambda: CurveTarget(several, [1, 2], [1, 2], 0.1), of_problem.NO_TARGET_NAME),
        (lambda: Parameter(several, 0, 1), of_problem.NO_PARAMETER_NAME),
        (lambda: Target.of_measurements("x", np.array(0.5)), of_problem.FEW_MEASUREMENTS),
        (lambda: friction_of_angle(several), of_materials.NO_ANGLE),
    ):
        with pytest.raises(InputError) as caught:
            make()
        assert message.is_in(str(caught.value))


@pytest.mark.parametrize("unit", [["kPa"], ("kPa",), np.array(["kPa", "Pa"]), 5])
def test_a_unit_that_is_no_text_is_refused(unit: Any) -> None:
    for make, key in (
        (lambda: Target("x", 1.0, unit=unit), "x.unit"),
        (lambda: Target("x", "1 kPa", unit=unit), "x.unit"),
        (lambda: Target.of_measurements("x", [1.0, 2.0], unit=unit), "x.unit"),
        (lambda: Parameter("p", "1 m", "2 m", unit=unit), "p.unit"),
        (lambda: CurveTarget("c", [1, 2], [1, 2], 0.1, coordinate_unit=unit), "c.coordinate_unit"),
    ):
        with pytest.raises(InputError) as caught:
            make()
        assert [fault.key for fault in caught.value.faults] == [key]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_targets_must_be_finite_numbers(value: float) -> None:
    with pytest.raises(InputError, match=f"{of_problem.NO_NUMBER.pattern} It must"):
        Target("angle", value)


@pytest.mark.parametrize(
    ("make", "key", "shown"),
    [
        (lambda: Target("angle", 5e-324), "angle.value", "5e-324"),
        (lambda: Target("angle", 1e308), "angle.value", "1e+308"),
        (lambda: Target("angle", 30.0, tolerance=1e300), "angle.tolerance", "1e+300"),
        (lambda: Target("angle", 30.0, uncertainty=1e-300), "angle.uncertainty", "1e-300"),
        (lambda: Target("angle", 30.0, uncertainty=1e-9), "angle.uncertainty", "the value is 30"),
        (lambda: Target("angle", 30.0, uncertainty="1e-300 %"), "angle.uncertainty", "3e-301"),
        (lambda: Target("angle", 0, 1.0, 1e-12), "angle.tolerance", "the uncertainty is 1"),
        (lambda: Target("angle", 30.0, weight=1e300), "angle.weight", "1e+300"),
        (lambda: Target("angle", 30.0, weight=1e-300), "angle.weight", "1e-300"),
        (lambda: Parameter("friction", -1e308, 1e308), "friction.min", "-1e+308"),
        (lambda: Parameter("friction", 5e-324, 1.0, "log"), "friction.min", "5e-324"),
        (lambda: Parameter("friction", 1.0, 1.0 + 1e-15), "friction", "almost equal"),
        (
            lambda: Parameter("friction", 0, 1, measured=0.5, uncertainty=1e-300),
            "friction.uncertainty",
            "1e-300, nothing beside its interval of 1",
        ),
        (
            lambda: Parameter("friction", 0, 1, measured=0.5, uncertainty=1e300),
            "friction.uncertainty",
            "1e+300, too much beside its interval of 1",
        ),
        (lambda: problem_with(rayleigh_weight=1e300), "rayleigh_weight", "1e+300"),
    ],
)
def test_numbers_that_cannot_be_computed_with_are_refused(
    make: Callable[[], object], key: str, shown: str
) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.faults[0].key == key
    assert shown in caught.value.faults[0].message
    assert caught.value.faults[0].remedy


def test_tiny_values_and_wide_tolerances_are_possible() -> None:
    assert Target("offset", 1e-17, tolerance=0.2).tolerance == 0.2
    assert Target("offset", 1e-12).tolerance == pytest.approx(2e-14)


def test_tolerance_is_the_users_then_the_uncertainty_then_two_percent() -> None:
    assert Target("a", 50.0, uncertainty=2.0, tolerance=1.5).tolerance == 1.5
    assert Target("a", 50.0, uncertainty=2.0).tolerance == 2.0
    assert Target("a", 50.0).tolerance == pytest.approx(1.0)


def test_every_fault_of_a_problem_is_named_at_once() -> None:
    friction = Parameter("friction", 0, 1)
    with pytest.raises(InputError) as caught:
        Problem([friction, friction], [], rayleigh_weight=-1)
    message = str(caught.value)
    assert "friction" in message
    assert "targets" in message
    assert "rayleigh_weight" in message


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.float32, np.float64, int, Fraction])
def test_numbers_of_any_kind_become_plain_floats(kind: Any) -> None:
    parameter = Parameter("friction", kind(1), kind(2))
    target = Target("angle", kind(30), kind(2), kind(1), kind(1))
    problem = Problem([parameter], [target], rayleigh_weight=kind(0))
    assert json.loads(json.dumps([asdict(parameter), asdict(target)]))[0]["maximum"] == 2.0
    assert type(problem.rayleigh_weight) is float
    assert parameter.from_unit(1.0) == 2.0
    assert target.tolerance == 1.0


@pytest.mark.parametrize("value", ["0.5", None, True, 1j, [0.5], 10**400])
def test_what_is_no_number_is_refused_by_name(value: Any) -> None:
    for key, make in (
        ("friction.min", lambda: Parameter("friction", value, 1.0)),
        ("friction.max", lambda: Parameter("friction", 0.0, value)),
        ("angle.value", lambda: Target("angle", value)),
        ("angle.weight", lambda: Target("angle", 30.0, weight=value)),
        ("rayleigh_weight", lambda: problem_with(rayleigh_weight=value)),
    ):
        with pytest.raises(InputError) as caught:
            make()
        assert [fault.key for fault in caught.value.faults] == [key]
    if value is not None:
        with pytest.raises(InputError, match="tolerance"):
            Target("angle", 30.0, tolerance=value)


def problem_with(**options: Any) -> Problem:
    return Problem([Parameter("particle.density", 1e3, 3e3)], [Target("angle", 30.0)], **options)


@pytest.mark.parametrize("items", [None, 3, "friction", ["friction"], Target("a", 1.0)])
def test_a_problem_is_made_of_lists(items: Any) -> None:
    with pytest.raises(InputError, match="parameters"):
        Problem(items, [Target("angle", 30.0)])
    with pytest.raises(InputError, match="targets"):
        Problem([Parameter("friction", 0, 1)], items)


MODULUS_AND_RATIO = {"particle.youngs_modulus": 3.6e5, "particle.poissons_ratio": 0.22}


def test_a_rayleigh_time_step_takes_free_and_fixed_values() -> None:
    problem = problem_with(rayleigh=RayleighTimeStep(0.005, MODULUS_AND_RATIO))
    step = problem.rayleigh_time_step({"particle.density": 2100.0})
    assert step == pytest.approx(0.002054, rel=1e-3)


@pytest.mark.parametrize("missing", list(MODULUS_AND_RATIO))
def test_a_rayleigh_time_step_that_lacks_a_value_is_refused(missing: str) -> None:
    fixed = {name: value for name, value in MODULUS_AND_RATIO.items() if name != missing}
    with pytest.raises(
        InputError, match=f"{missing}: {of_materials.NEITHER_FIXED_NOR_FREE.pattern}"
    ):
        problem_with(rayleigh=RayleighTimeStep(0.005, fixed))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("particle.youngs_modulus", 0.0),
        ("particle.youngs_modulus", "3.6e5"),
        ("particle.poissons_ratio", 0.6),
        ("particle.poissons_ratio", math.nan),
    ],
)
def test_a_rayleigh_time_step_of_an_impossible_material_is_refused(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=name):
        problem_with(rayleigh=RayleighTimeStep(0.005, {**MODULUS_AND_RATIO, name: value}))


def test_a_rayleigh_time_step_over_an_impossible_interval_is_refused() -> None:
    rayleigh = RayleighTimeStep(0.005, MODULUS_AND_RATIO)
    with pytest.raises(InputError, match=r"particle\.density: is 0\.0 to 3000\.0"):
        Problem([Parameter("particle.density", 0, 3e3)], [Target("angle", 30.0)], rayleigh=rayleigh)
    with pytest.raises(InputError, match="radius"):
        problem_with(rayleigh=RayleighTimeStep(0.0, MODULUS_AND_RATIO))


def test_quantities_are_read_in_si() -> None:
    density = Parameter("particle.density", "1.4 g/cm^3", "2800 kg/m^3")
    assert (density.minimum, density.maximum, density.unit) == (1400.0, 2800.0, "kg/m^3")
    own = Parameter("cohesion", "10 kPa", "70 kPa")
    assert (own.minimum, own.maximum, own.unit) == (10e3, 70e3, "Pa")
    angle = Target("angle", "22 deg", uncertainty="2 %", tolerance="0.01 rad")
    assert (angle.value, angle.uncertainty, angle.unit) == (22.0, 0.44, "deg")
    assert angle.tolerance == pytest.approx(0.572957795130823)


def test_numbers_keep_the_unit_that_was_given() -> None:
    assert Parameter("particle.density", 1400.0, 2800.0).unit == ""
    assert Target("angle", 22.0, uncertainty="0.5 deg", unit="deg").uncertainty == 0.5


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Parameter("particle.density", "1.4 m", 3e3), r"particle\.density\.min: .*kg/m\^3"),
        (lambda: Parameter("x", "10 parsnips", 20), r"x\.min: 'parsnips' in '10 parsnips'"),
        (lambda: Target("angle", "22 deg", uncertainty="1 kg"), r"angle\.uncertainty: '1 kg'"),
        (lambda: Target("angle", "twenty"), r"angle\.value: 'twenty' is not a quantity"),
        (lambda: Target("angle", "-1 deg", tolerance="0 deg"), r"angle\.tolerance: is 0"),
    ],
)
def test_what_is_no_quantity_is_named(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()


def test_a_tolerance_is_always_there() -> None:
    assert Target("angle", 22.0).tolerance == 0.44
    assert Target("angle", 22.0, uncertainty=0.5).tolerance == 0.5
    assert Target("angle", 22.0, uncertainty=0.5, tolerance=0.7).tolerance == 0.7


@pytest.mark.parametrize(
    "make",
    [
        lambda: Parameter(None, 0, 1),  # type: ignore[arg-type]
        lambda: Target(None, 1.0),  # type: ignore[arg-type]
        lambda: TestScope("heap", 5, ["friction"]),  # type: ignore[arg-type]
        lambda: TestScope(None, ["angle"], ["friction"]),  # type: ignore[arg-type]
        lambda: problem_with(rayleigh="short"),
    ],
)
def test_what_is_no_name_or_object_is_a_fault(make: Callable[[], object]) -> None:
    with pytest.raises(InputError):
        make()


def test_reprs_are_short() -> None:
    assert repr(Parameter("friction", 0.1, 0.9)) == "Parameter('friction', 0.1, 0.9)"
    assert repr(problem_with()) == "Problem(parameters=['particle.density'], targets=['angle'])"


@pytest.mark.parametrize("given", [("5 deg", "9 deg"), ("5 mm", "9 m"), ("0.5 kPa", "0.9 kPa")])
def test_a_parameter_that_is_a_number_takes_no_unit(given: tuple[str, str]) -> None:
    with pytest.raises(InputError) as refused:
        Parameter("particle_particle.sliding_friction", *given)
    assert "particle_particle.sliding_friction.min" in str(refused.value)
    assert Parameter("particle_particle.sliding_friction", "5 %", "0.9").minimum == 0.05


@pytest.mark.parametrize(
    ("given", "place"),
    [
        ({"scatters": [1]}, "scatters"),
        ({"scatters": {"height": 3.0}}, r"scatters\.height: .*angle"),
        ({"ratios": 3}, "ratios"),
        ({"ratios": {"height": 2.0}}, r"ratios\.height: .*angle"),
        ({"ratios": {"angle": math.nan}}, r"ratios\.angle"),
    ],
)
def test_values_by_name_are_of_names_that_there_are(given: dict[str, Any], place: str) -> None:
    with pytest.raises(InputError, match=place):
        problem_with(**given)


def test_a_part_of_the_targets_keeps_what_is_known_of_it() -> None:
    targets = [Target("angle", 22.0), Target("height", 0.1)]
    known = {"angle": 0.5, "height": 0.01}
    parameters = [Parameter("friction", 0.1, 0.9)]
    whole = Problem(parameters, targets, scatters=known, ratios={"height": 1.1})
    part = whole.with_targets(targets[:1])
    assert part.scatters == {"angle": 0.5}
    assert part.ratios == {}
    with pytest.raises(InputError, match="targets"):
        whole.with_targets([3])  # type: ignore[list-item]


@pytest.mark.parametrize("wrong", [math.nan, math.inf, "0.5", None])
def test_a_correlation_that_is_no_number_is_named(wrong: Any) -> None:
    targets = [Target("angle", 22.0), Target("height", 0.1)]
    with pytest.raises(InputError) as refused:
        Problem(
            [Parameter("friction", 0.1, 0.9)], targets, correlations=[("angle", "height", wrong)]
        )
    assert of_problem.BAD_COEFFICIENT.is_in(
        str(refused.value), given=shown(wrong), first="angle", second="height"
    )


def test_a_covariance_that_is_not_finite_is_named() -> None:
    targets = [Target("angle", 22.0), Target("height", 0.1)]
    problem = Problem([Parameter("friction", 0.1, 0.9)], targets)
    for wrong in (math.nan, math.inf):
        with pytest.raises(InputError) as refused:
            problem.with_covariance([[1.0, wrong], [wrong, 1.0]])
        assert of_problem.NOT_FINITE_ENTRY.is_in(
            str(refused.value), given=wrong, first="angle", second="height"
        )


def test_a_matrix_is_no_list_of_correlations() -> None:
    targets = [Target(name, 1.0) for name in ("a", "b", "c")]
    with pytest.raises(InputError) as refused:
        Problem([Parameter("friction", 0.1, 0.9)], targets, correlations=np.eye(3))  # type: ignore[arg-type]
    assert of_problem.NO_TRIPLES.is_in(str(refused.value))
