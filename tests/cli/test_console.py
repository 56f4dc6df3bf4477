"""Printed results."""

import io
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

import grainfit as gf
from grainfit.cli.console import print_result, print_status
from grainfit.result import ParameterInterval, Result
from grainfit.work_folder.status import WorkdirStatus


@pytest.fixture(scope="module")
def calibrated() -> Result:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 22.0, tolerance=0.5)]
    )
    return gf.calibrate(problem, lambda at, seed: {"angle": 15 + 10 * at["friction"]}, seed=1)


def printed(result: Result, **changes: object) -> str:
    """The line of the response, some of whose facts are changed."""
    changed = replace(result.responses["angle"], **changes)
    console = Console(file=io.StringIO(), width=100)
    print_result(console, replace(result, responses={"angle": changed}), Path("sand.grainfit"))
    assert isinstance(console.file, io.StringIO)
    return next(line for line in console.file.getvalue().splitlines() if line.startswith("angle "))


def test_a_response_is_met_or_missed_by_its_verification_only(calibrated: Result) -> None:
    unverified = {"verified_mean": None, "verified_standard_error": None, "verified_interval": None}
    assert printed(calibrated).rstrip().endswith("%  met")
    missed = {"verified_mean": 22.6, "within_tolerance": False}
    assert printed(calibrated, **missed).rstrip().endswith("%  missed")
    lucky = {"verified_mean": 22.4, "verified_interval": 0.6, "within_tolerance": False}
    assert printed(calibrated, **lucky).rstrip().endswith("%  in doubt")
    for close in (True, False):
        shown = printed(calibrated, within_tolerance=close, **unverified).rstrip()
        assert "predicted 22 " in shown
        assert shown.endswith("not verified")


def test_in_80_columns_every_parameter_has_its_whole_name_and_word(calibrated: Result) -> None:
    words = ("determined", "narrowed", "not determined")
    names = [f"particle_particle.sliding_friction{i}" for i in range(3)]
    shown = replace(
        calibrated,
        parameters=dict.fromkeys(names, 1.234e6),
        units=dict.fromkeys(names, "Pa"),
        intervals={
            name: ParameterInterval(1.1e6, 8.8e7, word)
            for name, word in zip(names, words, strict=True)
        },
    )
    console = Console(file=io.StringIO(), width=80)
    print_result(console, shown, Path("sand.grainfit"))
    assert isinstance(console.file, io.StringIO)
    lines = console.file.getvalue().splitlines()
    for name, word in zip(names, words, strict=True):
        (line,) = (line.rstrip() for line in lines if line.startswith(f"{name} "))
        assert line.endswith(f" {word}")


def test_the_status_has_the_word_beside_every_value(calibrated: Result) -> None:
    console = Console(file=io.StringIO(), width=80)
    found = ParameterInterval(0.2, 0.85, "not determined")
    for intervals, shown in (
        ({"friction": found}, "friction = 0.7 (not determined, 0.2 to 0.85)"),
        ({}, "friction = 0.7"),
    ):
        result = replace(calibrated, intervals=intervals)
        print_status(console, WorkdirStatus("sand", "calibrated", {}, {}, 0, (), 5, result))
        assert isinstance(console.file, io.StringIO)
        assert shown in console.file.getvalue().splitlines()
