"""Yield locus of a calibration: result, summary, figure, and section of the report."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
import needs
from benchmarks import chromium
from benchmarks.axe import violations
from grainfit.analysis.analysis import Analysis
from grainfit.cli.app import app
from grainfit.errors import InputError
from grainfit.plots import messages
from grainfit.report.section import ReportContext
from grainfit.report.sections.yield_locus.section import yield_locus
from grainfit.result import Result, YieldLocusResult

SLIDING, ENERGY = "particle_particle.sliding_friction", "particle_particle.surface_energy"
STRESSES = {"shear_250": 250.0, "shear_1000": 1000.0}
#: Yield locus of the material that was measured.
COHESION, ANGLE = 40.0, 26.0


class Sheared(gf.solvers.Solver):
    """Shear test in closed form: cohesion by the surface energy, angle by sliding friction."""

    name, uses_folder = "closed form", False

    def __init__(self, stress: float) -> None:
        self.test = gf.tests.Shear(diameter="10 mm", normal_stress=stress)

    @property
    def response_names(self) -> tuple[str, ...] | None:
        return self.test.response_names

    @property
    def bulk_test(self) -> gf.tests.Shear:
        return self.test

    def model(self) -> Mapping[str, Any]:
        return {"solver": self.name, "test": self.test.definition()}

    def run(self, parameters: Mapping[str, float], seed: int, workspace: Any) -> dict[str, Any]:
        slope = math.tan(math.radians(10 + 32 * parameters[SLIDING]))
        ratio = 400 * parameters[ENERGY] / self.test.setup.normal_stress + slope
        angle = math.degrees(math.atan(ratio)) + np.random.default_rng(seed).normal(0, 0.2)
        return {"internal_friction_angle": gf.Response(angle, 0.2)}


def angle_at(stress: float) -> float:
    return math.degrees(math.atan(COHESION / stress + math.tan(math.radians(ANGLE))))


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    """Result and work folder."""
    targets = [
        gf.Target(f"{test}.internal_friction_angle", angle_at(stress), 0.5, unit="deg")
        for test, stress in STRESSES.items()
    ]
    free = [gf.Parameter(SLIDING, 0.1, 0.9), gf.Parameter(ENERGY, 0.0, 0.3)]
    folder = tmp_path_factory.mktemp("locus") / "work"
    solvers = {test: Sheared(stress) for test, stress in STRESSES.items()}
    return gf.calibrate(gf.Problem(free, targets), solvers, workdir=folder, seed=2), folder


def require_locus(locus: YieldLocusResult) -> None:
    assert locus.tests == tuple(STRESSES)
    assert locus.measured.cohesion.value == pytest.approx(COHESION)
    assert locus.measured.internal_friction_angle.value == pytest.approx(ANGLE)
    assert locus.expected is not None
    for wanted, found in (
        (COHESION, locus.expected.cohesion),
        (ANGLE, locus.expected.internal_friction_angle),
    ):
        assert found.standard_error > 0
        assert found.value == pytest.approx(wanted, abs=4 * found.standard_error + 0.02 * wanted)


def test_result_and_work_folder_have_the_same_locus(calibrated: tuple[Result, Path]) -> None:
    result, folder = calibrated
    (locus,) = result.yield_loci
    require_locus(locus)
    assert gf.open(folder).yield_loci == result.yield_loci
    assert Result.from_json(folder / "result.json").yield_loci == result.yield_loci


def test_a_calibration_that_is_interrupted_before_any_run_has_no_locus_anywhere(
    calibrated: tuple[Result, Path], tmp_path: Path
) -> None:
    class Endless(Sheared):
        def run(self, parameters: Mapping[str, float], seed: int, workspace: Any) -> dict[str, Any]:
            workspace.cancelled.wait()
            raise gf.RunFailedError("stopped", kind="cancelled")

    def interrupt(progress: gf.Progress) -> None:
        raise KeyboardInterrupt

    problem = gf.open(calibrated[1]).problem
    solvers = {test: Endless(stress) for test, stress in STRESSES.items()}
    result = gf.calibrate(problem, solvers, workdir=tmp_path, on_progress=interrupt)
    assert result.status == "interrupted"
    assert result.yield_loci == gf.open(tmp_path).yield_loci == ()


def test_the_summary_has_it_in_one_line(calibrated: tuple[Result, Path]) -> None:
    result, folder = calibrated
    (locus,) = result.yield_loci
    assert re.fullmatch(
        r"Yield locus \(shear_250, shear_1000\): measured cohesion 40.0 ± \d.\d Pa, "
        r"26.00 ± 0.\d\d°; expected at the answer cohesion [\d.]+ ± [\d.]+ Pa, "
        r"[\d.]+ ± [\d.]+° \(± standard error\)\.",
        str(locus),
    )
    assert str(locus) in str(result)
    assert str(locus) in str(gf.open(folder))
    done = CliRunner().invoke(app, ["result", str(folder)])
    assert str(locus) in " ".join(done.output.split())


def test_a_result_of_an_older_version_is_read_and_its_runs_have_the_locus(
    calibrated: tuple[Result, Path],
) -> None:
    result, folder = calibrated
    path = folder / "result.json"
    text = path.read_text(encoding="utf-8")
    older = {key: value for key, value in json.loads(text).items() if key != "yield_loci"}
    try:
        path.write_text(json.dumps(older), encoding="utf-8")
        saved = gf.open(folder)
    finally:
        path.write_text(text, encoding="utf-8")
    assert saved.result is not None
    assert saved.result.yield_loci == ()
    assert saved.yield_loci == result.yield_loci


def test_section_and_figure_have_points_and_lines(calibrated: tuple[Result, Path]) -> None:
    saved = gf.open(calibrated[1])
    (locus,) = saved.yield_loci
    section = yield_locus(ReportContext(saved, Analysis()))
    assert section is not None
    (shown,) = section.figures.values()
    words = " ".join(unescape(re.sub(r"<[^>]*>", " ", str(section.html))).split())
    assert "Measured 40.0 ± " in words
    assert "Expected " in words

    drawn = json.loads(gf.plots.yield_locus(saved).to_json())["data"]
    assert [trace["y"] for trace in drawn] == [pytest.approx(trace["y"]) for trace in shown.data]
    line, points, *_ = drawn
    assert line["y"][0] == pytest.approx(COHESION)
    assert points["x"] == [250.0, 1000.0]
    slope = math.tan(math.radians(ANGLE))
    assert points["y"] == pytest.approx([COHESION + 250 * slope, COHESION + 1000 * slope])
    # The measured angles have a standard uncertainty of 0.5°.
    ratio = 1 + math.tan(math.radians(angle_at(1000))) ** 2
    half = 1.96 * 1000 * ratio * math.radians(0.5)
    assert points["error_y"]["array"][1] == pytest.approx(half)
    assert drawn[3]["y"] == [shear.value for shear in locus.expected.shear_stresses]


def test_one_stress_has_neither_section_nor_figure(calibrated: tuple[Result, Path]) -> None:
    saved = gf.open(calibrated[1])
    one = replace(
        saved, problem=replace(saved.problem.with_targets(saved.problem.targets[:1]), tests=())
    )
    assert yield_locus(ReportContext(one, Analysis())) is None
    with pytest.raises(InputError, match=messages.NO_YIELD_LOCUS()):
        gf.plots.yield_locus(one)


@needs.CHROMIUM
def test_the_section_breaks_no_rule_of_accessibility(
    calibrated: tuple[Result, Path], tmp_path: Path
) -> None:
    path = gf.write_report(calibrated[1], tmp_path / "report.html")
    with chromium.browser() as browser:
        page = browser.new_page()
        page.goto(path.as_uri())
        assert violations(page) == []
        assert page.evaluate(chromium.DRAW) == ""
        assert page.locator("#yield_locus .figure .main-svg").count() > 0
        assert page.locator("#yield_locus table tbody tr").count() == 2
