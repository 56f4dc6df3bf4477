"""Targets of bulk tests have any value that is physically possible, zero included, and no other."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.planned import load_planned_file
from grainfit.calibration_file.starter import starter_file
from grainfit.errors import InputError


def file_of(folder: Path, test: str, target: str) -> Path:
    """Write the file of one test with one target."""
    lines = [one for one in starter_file([test]).splitlines() if not one.startswith("targets.")]
    at = next(n for n, line in enumerate(lines) if line.startswith("type = "))
    path = folder / "beads.toml"
    path.write_text("\n".join([*lines[: at + 1], f"targets.{target}", *lines[at + 1 :]]))
    return path


def load(folder: Path, test: str, target: str) -> CalibrationSetup:
    return gf.load(file_of(folder, test, target))


@pytest.mark.parametrize(
    ("test", "target"),
    [
        ("discharge", 'mass_flow = { value = 0, uncertainty = "0.01 kg/s" }'),
        ("discharge", 'mass_flow = { value = "0 kg/s", tolerance = 0.01 }'),
        ("drum", 'dynamic_angle = { value = 0, uncertainty = "1 deg" }'),
        ("drum", 'lower_angle = { value = "-3 deg", uncertainty = "1 deg" }'),
        ("draw_down", "discharged_share = { value = 1, uncertainty = 0.01 }"),
        ("heap", 'angle_of_repose = { value = "90 deg", uncertainty = "1 deg" }'),
    ],
)
def test_a_possible_value_is_a_target(tmp_path: Path, test: str, target: str) -> None:
    setup = load(tmp_path, test, target)
    [found] = setup.problem.targets
    assert found.is_relative == (found.value != 0)
    # Notes divide by the value of a target where it has one.
    setup.notes()


@pytest.mark.parametrize(
    ("test", "target", "fault"),
    [
        ("heap", "angle_of_repose.value = 120", "at most 90 deg. A flank is not steeper"),
        ("heap", 'base_radius.value = "0 mm"', "must be above 0"),
        ("draw_down", "angle_of_repose.value = 91", "at most 90 deg. A flank is not steeper"),
        ("draw_down", "shear_angle.value = 91", "at most 90 deg. A flank is not steeper"),
        ("draw_down", "discharged_share.value = 1.4", "at most 1. It is a share of the mass"),
        ("draw_down", "discharged_share.measurements = [0.9, 1.1]", "at most 1. It is a share"),
        ("compression", "lateral_stress_ratio.value = 3", "at most 1. A bed that is pressed"),
        ("compression", "loading_modulus.value = 0", "must be above 0"),
        ("shear", "internal_friction_angle.value = 95", "at most 90 deg. It is an arc tangent."),
        ("drum", "dynamic_angle.value = -1", "from 0 to 90 deg. The surface of a bed"),
        ("drum", "surface_angle.value = 100", "from -90 to 90 deg. The surface of a bed"),
        ("discharge", 'mass_flow.value = "-1 kg/s"', "at least 0 kg/s. Nothing flows back"),
        ("discharge", "mass_flow = { value = 0 }", "Give a tolerance or an uncertainty in the"),
        ("discharge", 'mass_flow = { value = 0, uncertainty = "1 %" }', "so is any percentage"),
    ],
)
def test_an_impossible_value_is_refused_with_the_reason(
    tmp_path: Path, test: str, target: str, fault: str
) -> None:
    with pytest.raises(InputError, match=re.escape(fault)):
        load(tmp_path, test, target)


def test_a_file_from_before_the_laboratory_has_the_same_limits(tmp_path: Path) -> None:
    assert load_planned_file(file_of(tmp_path, "discharge", "mass_flow.value = 0"))
    with pytest.raises(InputError, match=r"at most 90 deg\. A flank is not steeper"):
        load_planned_file(file_of(tmp_path, "heap", "angle_of_repose.value = 120"))
