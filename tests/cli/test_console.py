"""Printed results."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import grainfit as gf
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.starter import starter_file
from grainfit.cli.console import print_parts, print_plan, print_result, print_status
from grainfit.cli.exit_codes import OF_STATUS
from grainfit.result import ParameterInterval, Result
from grainfit.tables import TextTable
from grainfit.verdict import messages
from grainfit.work_folder.status import FailedRun, WorkdirStatus


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


def test_a_response_has_the_verdict_and_the_expectation_of_all_runs(calibrated: Result) -> None:
    assert printed(calibrated).rstrip().endswith("%  met")
    for verdict in ("missed", "in doubt"):
        line = printed(calibrated, predicted=22.6, standard_error=0.1, verdict=verdict)
        # The mean of the fresh seeds, still 22, changes neither.
        assert " 22.60 ± 0.20 " in line
        assert line.rstrip().endswith(f"%  {verdict}")


def test_the_mean_of_the_fresh_seeds_stands_beside_the_expectation(calibrated: Result) -> None:
    found = replace(
        calibrated.responses["angle"], verified_mean=22.134, verified_interval=0.31, unit="deg"
    )
    shown = replace(calibrated, responses={"angle": found})
    sentence = "Mean of 3 fresh seeds at the answer: angle 22.13 ± 0.31 deg."
    assert sentence in str(shown)
    console = Console(file=io.StringIO(), width=200)
    print_result(console, shown, Path("sand.grainfit"))
    assert isinstance(console.file, io.StringIO)
    assert sentence in console.file.getvalue()
    without = replace(found, verified_mean=None, verified_interval=None)
    assert "fresh" not in str(replace(calibrated, responses={"angle": without}))


def test_an_undecided_calibration_says_so_why_and_how_likely() -> None:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 22.0, tolerance=0.5)]
    )

    def scattering(at: dict[str, float], seed: int) -> dict[str, float]:
        return {"angle": 15 + 10 * at["friction"] + np.random.default_rng(seed).normal(0, 3)}

    result = gf.calibrate(problem, scattering, seed=1, name="sand", max_runs=20)
    console = Console(file=io.StringIO(), width=100)
    print_result(console, result, Path("sand.grainfit"))
    assert isinstance(console.file, io.StringIO)
    shown = " ".join(console.file.getvalue().split())
    assert result.status == "undecided"
    assert OF_STATUS["undecided"] == 3
    assert "sand: undecided: the runs" in shown
    assert " in doubt" in shown
    assert messages.TOO_MUCH_SCATTER.is_in(shown)
    assert messages.ALL_MET.is_in(shown)


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


@pytest.mark.parametrize("width", [70, 80])
def test_in_a_narrow_terminal_headings_and_lists_of_tests_break_before_numbers(width: int) -> None:
    tests = ["heap + draw_down", "heap + compression + discharge"]
    header = ("tests", "density", "sliding friction", "rolling friction", "factor", "a run")
    rows = tuple((name, "± 1.8 %", "± 26 %", "± 23 %", "1.2", "1 min 29 s") for name in tests)
    console = Console(file=io.StringIO(), width=width)
    print_parts(console, [TextTable(header, rows)])
    lines = console.file.getvalue().splitlines()  # type: ignore[attr-defined]
    [first, second] = [line for line in lines if line.startswith("heap")]
    for line in (first, second):
        for number in rows[0][1:]:
            assert number in line
    assert first.startswith(tests[0])
    assert not any("…" in line for line in lines)


def test_in_a_wide_terminal_no_heading_breaks() -> None:
    console = Console(file=io.StringIO(), width=80)
    print_parts(console, [TextTable(("test", "sliding friction", "a run"), (("heap", "1", "2"),))])
    assert "sliding friction" in console.file.getvalue()  # type: ignore[attr-defined]


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


def test_check_shows_the_severity_of_each_finding(tmp_path: Path) -> None:
    lines = starter_file(["heap"]).replace('type = "heap"', 'type = "heap"\ngravity = 981')
    file = tmp_path / "moon.toml"
    file.write_text(lines, encoding="utf-8")
    console = Console(file=io.StringIO(), width=10_000)
    plan = describe_plan(load_calibration(file))
    print_plan(console, plan)
    assert isinstance(console.file, io.StringIO)
    shown = console.file.getvalue().splitlines()
    assert {finding.severity for finding in plan.findings} == {"note", "warning"}
    for finding in plan.findings:
        assert f"{finding.severity.capitalize()}: {finding.text}" in shown


def test_failures_that_differ_in_numbers_only_are_one_line_of_the_status() -> None:
    failed = [FailedRun(f"runs/{n}", f"no rest within 4.{n} s", "") for n in range(3)]
    failed += [FailedRun("runs/3", "no heap", "")]
    console = Console(file=io.StringIO(), width=100)
    print_status(console, WorkdirStatus("sand", "failed", {}, {}, 0, tuple(failed), 0, None))
    assert isinstance(console.file, io.StringIO)
    lines = [one for one in console.file.getvalue().splitlines() if one.startswith("failed: ")]
    assert lines == [
        "failed: no rest within 4.0 s (runs/0, and 2 runs alike)",
        "failed: no heap (runs/3)",
    ]
