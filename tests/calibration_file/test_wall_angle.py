"""Wall friction in a calibration file as the angle of an inclined plane."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from grainfit.calibration_file import messages
from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.options.places import FileFault

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
SLIDING = "sliding_friction = 0.27"
WALL = "particle_wall.sliding_friction"


def setup_with(folder: Path, friction: str) -> CalibrationSetup:
    assert GLASS_BEADS.count(SLIDING) == 1
    path = folder / "calibration.toml"
    path.write_text(GLASS_BEADS.replace(SLIDING, f"sliding_friction = {friction}"))
    return build_calibration(load_calibration_file(path))


def test_an_angle_fixes_the_friction_exactly(tmp_path: Path) -> None:
    setup = setup_with(tmp_path, '{ measured_angle = "21.8 deg" }')

    assert setup.file.fixed[WALL] == pytest.approx(math.tan(math.radians(21.8)), rel=1e-14)
    assert setup.problem.dimension == 2
    same = setup_with(tmp_path, repr(setup.file.fixed[WALL]))
    values = setup.problem.from_unit([0.5, 0.5])
    run = setup.solvers["heap"].definition(values, 1)
    assert run.identity == same.solvers["heap"].definition(values, 1).identity


def test_an_uncertain_angle_is_a_free_parameter_with_a_measurement(tmp_path: Path) -> None:
    setup = setup_with(tmp_path, "{ measured_angle = 21.8, uncertainty = 0.5 }")

    (parameter,) = setup.problem.measured
    assert parameter.name == WALL
    assert parameter.measured == pytest.approx(0.4, abs=1e-4)
    assert parameter.uncertainty == pytest.approx(0.01012, abs=1e-5)
    assert WALL not in setup.file.fixed


def test_check_says_what_was_measured(tmp_path: Path) -> None:
    plan = describe_plan(setup_with(tmp_path, "{ measured_angle = 21.8, uncertainty = 0.5 }"))

    assert (
        f"{WALL} is 0.4, the tangent of the measured angle of 21.8°, with a standard uncertainty "
        "of 0.01 (0.5°) that is part of all intervals."
    ) in plan.lines
    # Two targets settle the two other parameters.
    assert not any("free parameters and 2 targets" in line for line in plan.notes)


@pytest.mark.parametrize(
    ("friction", "key", "message"),
    [
        ("{ measured_angle = 90 }", f"{WALL}.measured_angle", "is 90. It must be above 0, and at"),
        ('{ measured_angle = "2 mm" }', f"{WALL}.measured_angle", "has the unit mm"),
        ("{ measured_angle = 9, uncertainty = 0 }", f"{WALL}.uncertainty", "must be above 0"),
        ("{ measured_angle = 9, min = 0.1 }", f"{WALL}.min", "is not a known key."),
        ('{ measured_angle = "steep" }', f"{WALL}.measured_angle", "steep"),
    ],
)
def test_what_is_no_angle_is_named_with_its_line(
    faults_of: Callable[..., list[FileFault]], friction: str, key: str, message: str
) -> None:
    (fault,) = faults_of((SLIDING, f"sliding_friction = {friction}"))

    assert fault.key == key
    assert message in str(fault)
    assert fault.line == 1 + GLASS_BEADS[: GLASS_BEADS.index(SLIDING)].count("\n")


def test_an_angle_measures_nothing_but_wall_friction(
    faults_of: Callable[..., list[FileFault]],
) -> None:
    (fault,) = faults_of(("sliding_friction = 0.18", "sliding_friction = { measured_angle = 10 }"))

    assert fault.key == "particle_particle.sliding_friction.measured_angle"
    assert fault.remedy.startswith("Angles measure particle_wall.sliding_friction and ")


def test_measured_parameters_alone_are_nothing_to_calibrate(
    faults_of: Callable[..., list[FileFault]],
) -> None:
    faults = faults_of(
        ('{ min = "1407 kg/m^3", max = "2793 kg/m^3" }', "2100"),
        ("{ min = 0.449, max = 0.891 }", "0.6"),
        (SLIDING, "sliding_friction = { measured_angle = 15, uncertainty = 1 }"),
    )

    assert messages.NOTHING_FREE.is_in(str(faults[0]))
