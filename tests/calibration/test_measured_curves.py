"""Calibration on measured curves, from Python."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from benchmarks import chromium
from benchmarks.axe import violations_in
from grainfit.calibration import messages as of_calibration
from grainfit.cli.app import app
from grainfit.metamodels import messages as of_metamodels
from grainfit.report import verdict_messages as messages
from grainfit.report.page import write_report
from grainfit.result import Result
from grainfit.verdict.messages import NO_SUCH_SHAPE

STRAINS = np.linspace(0.002, 0.04, 15)
TRUTH = {"modulus": 2.4e5, "stiffening": 0.6}


def stress(parameters: Mapping[str, float], strains: np.ndarray) -> np.ndarray:
    """Stress of a bed that stiffens, Pa."""
    bend = 1 + 20 * parameters["stiffening"] * strains
    return np.asarray(parameters["modulus"] * strains * bend)


def press(parameters: Mapping[str, float], seed: int) -> dict[str, gf.Curve]:
    """One run: the whole curve scatters by 2 %, its points by 0.5 %."""
    random = np.random.default_rng([seed, 3])
    strains = np.linspace(0.0, 0.05, 40)
    factors = (1 + 0.02 * random.normal()) * (1 + 0.005 * random.normal(size=40))
    return {"stress": gf.Curve(strains.tolist(), (stress(parameters, strains) * factors).tolist())}


def measured(values: np.ndarray | None = None, common: str = "2 %") -> gf.CurveTarget:
    """A laboratory's curve of the true material, by default without error."""
    shown = stress(TRUTH, STRAINS) if values is None else values
    return gf.CurveTarget(
        "stress", STRAINS.tolist(), shown.tolist(), "2 %", common, unit="Pa", coordinate="strain"
    )


def problem(curve: gf.CurveTarget) -> gf.Problem:
    return gf.Problem(
        [gf.Parameter("modulus", 1e5, 4e5), gf.Parameter("stiffening", 0.0, 1.0)],
        [],
        curves=[curve],
    )


def calibrated(curve: gf.CurveTarget, **options: Any) -> Result:
    return gf.calibrate(problem(curve), gf.solvers.PythonCallable(press), **options)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    folder = tmp_path_factory.mktemp("curves") / "work"
    return calibrated(measured(), workdir=folder), folder


def test_curve_calibrates_two_parameters(finished: tuple[Result, Path]) -> None:
    result, _ = finished

    assert result.status == "calibrated"
    for name, interval in result.intervals.items():
        assert interval.low < TRUTH[name] < interval.high
        assert interval.determination == "determined"


def test_parameters_from_a_curve_are_known_as_closely_as_wanted(
    finished: tuple[Result, Path],
) -> None:
    usual, _ = finished
    widths = [(i.high - i.low) / 2 / usual.parameters[n] for n, i in usual.intervals.items()]
    strategy = gf.Sequential(wanted_half_width=0.8 * max(widths))
    result = calibrated(measured(), strategy=strategy)

    assert result.status == "calibrated"
    assert result.runs.total > usual.runs.total
    [notice] = [notice for notice in result.notices if "wanted" in notice]
    assert "stiffening" in notice


def test_curve_at_the_answer_is_in_the_result(finished: tuple[Result, Path]) -> None:
    result, folder = finished
    curve = result.curves["stress"]

    assert curve.verdict == "met"
    assert curve.expected == pytest.approx(stress(TRUTH, STRAINS), rel=0.05)
    assert curve.deviation < 1.5
    assert "15 points" in str(result)
    assert Result.from_json(folder / "result.json").curves == result.curves


def test_fresh_seeds_of_a_curve_are_compared_with_the_measured_one(
    finished: tuple[Result, Path],
) -> None:
    result, folder = finished
    curve = result.curves["stress"]
    runs = [run for run in gf.open(folder).evaluations if run.proposal.stage == "verification"]
    near = [run for run in runs if run.proposal.parameters == result.parameters] or runs
    mean = np.mean(
        [
            np.interp(STRAINS, run.curves["stress"].coordinates, run.curves["stress"].values)
            for run in near
        ],
        axis=0,
    )

    # The answer moves a little with these runs, and the metamodels carry them over to it.
    assert curve.verified_mean == pytest.approx(mean, rel=0.03)
    assert curve.verified_runs >= 3
    off = np.subtract(curve.verified_mean, curve.measured) / curve.uncertainties
    assert curve.verified_deviations == pytest.approx(off)
    assert f"stress {curve.fresh}" in result.fresh_seeds()
    assert f"Mean of {curve.verified_runs} fresh seeds" in str(result)
    page = write_report(folder).read_text()
    assert page.count(curve.fresh) == 2
    assert "There is no run with fresh seeds" not in page


def test_warnings_of_metamodels_name_the_curve_and_the_points_that_they_are_about(
    finished: tuple[Result, Path], tmp_path: Path
) -> None:
    result, folder = finished
    doubted = {n: replace(q, warnings=("Few runs.",)) for n, q in result.metamodels.items()}
    shown = tmp_path / "copy"
    shutil.copytree(folder, shown)
    replace(result, metamodels=doubted).to_json(shown / "result.json")

    said = CliRunner().invoke(app, ["result", str(shown)]).output
    for words in (" ".join(said.split()).lower(), write_report(shown).read_text().lower()):
        assert re.search(r"of stress, as it varies most at strain = 0\.\d+: few runs\.", words)
        assert "metamodel of stress, component" not in words


def test_curve_calibration_opens_again_with_figures_and_report(
    finished: tuple[Result, Path],
) -> None:
    saved = gf.open(finished[1])
    page = write_report(finished[1]).read_text()

    assert saved.problem.curves[0].values == pytest.approx(stress(TRUTH, STRAINS))
    names = {trace.name for trace in gf.plots.curves(saved).data}
    assert {"measured, with 95 % intervals", "expected at the answer", "fresh seeds"} <= names
    assert "Do the simulated curves follow the measured ones?" in page


@pytest.mark.skipif(chromium.EXECUTABLE is None, reason="Chromium is not installed")
def test_no_entry_of_a_legend_is_cut_off_on_a_phone(
    finished: tuple[Result, Path], tmp_path: Path
) -> None:
    path = write_report(finished[1], tmp_path / "curves.html")
    right = "all => all.map((one) => one.getBoundingClientRect().right)"
    with chromium.browser() as browser:
        page = browser.new_page(viewport={"width": 375, "height": 800})
        page.goto(path.as_uri())
        page.evaluate("document.querySelectorAll('details').forEach((one) => (one.open = true))")
        figure = page.locator("[data-figure='curves-0']")
        entries = figure.locator(".legendtext")
        entries.first.wait_for()
        [edge] = figure.evaluate_all(right)
        assert entries.count() == 5
        assert max(entries.evaluate_all(right)) <= edge


@pytest.mark.skipif(chromium.EXECUTABLE is None, reason="Chromium is not installed")
def test_report_with_curves_breaks_no_rule_of_accessibility(
    finished: tuple[Result, Path], tmp_path: Path
) -> None:
    assert violations_in(write_report(finished[1], tmp_path / "curves.html")) == []


def test_curve_calibration_repeats_no_run(finished: tuple[Result, Path]) -> None:
    result, folder = finished
    again = calibrated(measured(), workdir=folder)

    assert again.runs.reused == again.runs.total == result.runs.total
    assert again.parameters == result.parameters


def test_more_points_do_not_promise_more_than_common_errors_allow() -> None:
    def half_width(points: int, common: str) -> float:
        strains = np.linspace(0.002, 0.04, points)
        curve = gf.CurveTarget(
            "stress", strains.tolist(), stress(TRUTH, strains).tolist(), "1 %", common
        )
        known = gf.Problem([gf.Parameter("modulus", 1e5, 4e5)], [], curves=[curve])

        def exact(parameters: Mapping[str, float], seed: int) -> dict[str, gf.Curve]:
            del seed
            fine = np.linspace(0.0, 0.05, 60)
            found = stress({**TRUTH, **parameters}, fine)
            return {"stress": gf.Curve(fine.tolist(), found.tolist())}

        interval = gf.calibrate(known, gf.solvers.PythonCallable(exact)).intervals["modulus"]
        return (interval.high - interval.low) / 2 / TRUTH["modulus"]

    # 1.96 times the root of 5 % squared, and 1 % squared over the points.
    assert half_width(3, "5 %") == pytest.approx(1.96 * np.hypot(0.05, 0.01 / 3**0.5), rel=0.15)
    assert half_width(40, "5 %") == pytest.approx(1.96 * np.hypot(0.05, 0.01 / 40**0.5), rel=0.15)
    assert half_width(40, "0 %") == pytest.approx(1.96 * 0.01 / 40**0.5, rel=0.15)


@pytest.mark.thorough
def test_curve_of_a_shape_that_no_run_has_is_out_of_tolerance() -> None:
    wave = stress(TRUTH, STRAINS) * (1 + 0.15 * np.sin(np.arange(len(STRAINS))))
    result = calibrated(measured(wave))

    assert result.status in ("out_of_tolerance", "unreachable")
    assert result.curves["stress"].verdict == "missed"
    if result.status == "out_of_tolerance":
        assert "other shape" in {reason.kind for reason in result.reasons}


def test_curve_out_of_reach_says_where_it_deviates_and_which_bound_is_in_the_way() -> None:
    stiffer = stress({"modulus": 5e5, "stiffening": 0.6}, STRAINS)
    result = calibrated(measured(stiffer))

    assert result.status == "unreachable"
    [miss] = result.out_of_reach
    assert (miss.target, miss.parameter, miss.bound) == ("stress", "modulus", "max")
    assert miss.curve is not None
    errors = result.curves["stress"].uncertainties
    off = np.subtract(result.curves["stress"].expected, stiffer) / errors
    assert miss.curve.deviation == pytest.approx(np.sqrt((off**2).mean()), rel=0.1)
    place, value, expected = miss.curve.points[0]
    assert value == pytest.approx(float(np.interp(place, STRAINS, stiffer)))
    assert expected == pytest.approx(
        float(np.interp(place, STRAINS, result.curves["stress"].expected)), rel=0.05
    )
    assert str(miss).startswith("stress is out of reach: the nearest curve")
    assert "modulus.max = 400000" in str(miss)
    assert "component" not in "".join([*result.notices, str(miss)])


def test_curve_out_of_reach_moves_the_bound_in_the_way() -> None:
    stiffer = stress({"modulus": 5e5, "stiffening": 0.6}, STRAINS)
    result = calibrated(measured(stiffer), strategy=gf.Sequential(extend_intervals=True))

    assert result.status == "calibrated"
    assert result.parameters["modulus"] == pytest.approx(5e5, rel=0.05)


def test_curve_out_of_reach_for_its_shape_says_so() -> None:
    falls = stress(TRUTH, STRAINS)[::-1]
    [miss] = calibrated(measured(falls)).out_of_reach
    assert str(miss).endswith(NO_SUCH_SHAPE())


def test_curve_beyond_the_simulated_ones_says_what_they_hold(tmp_path: Path) -> None:
    strains = np.linspace(0.002, 0.08, 10)
    curve = gf.CurveTarget("stress", strains.tolist(), stress(TRUTH, strains).tolist(), "2 %")

    with pytest.raises(gf.RunFailedError, match=r"shortest is 0 to 0\.05, and"):
        calibrated(curve, workdir=tmp_path)
    page = write_report(tmp_path).read_text()
    names = [trace.name for trace in gf.plots.curves(gf.open(tmp_path)).data]
    assert messages.STOPPED() in page
    assert "shortest is 0 to 0.05, and" in page
    assert names == ["other runs", "measured, with 95 % intervals"]


def test_curves_that_are_too_short_in_a_part_of_the_intervals_are_told() -> None:
    def stops(parameters: Mapping[str, float], seed: int) -> dict[str, gf.Curve]:
        whole = press(parameters, seed)["stress"]
        last = 40 if parameters["stiffening"] < 0.8 else 20
        return {"stress": gf.Curve(whole.coordinates[:last], whole.values[:last])}

    result = gf.calibrate(problem(measured()), gf.solvers.PythonCallable(stops))

    assert any("do not hold all measured points" in words for words in result.notices)


def test_staged_search_calibrates_on_a_curve() -> None:
    assert calibrated(measured(), strategy=gf.Staged(design_runs=12)).status == "calibrated"


def test_curve_and_number_of_two_tests_calibrate_together() -> None:
    def weigh(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        noise = 3.0 * np.random.default_rng([seed, 8]).normal()
        return {"density": 1500.0 + 100.0 * parameters["stiffening"] + noise}

    both = gf.Problem(
        problem(measured()).parameters,
        [gf.Target("weighing.density", 1560.0, uncertainty=5.0)],
        curves=[replace(measured(), name="pressing.stress")],
        tests=[
            gf.TestScope("pressing", ["pressing.stress"], ["modulus", "stiffening"], 10.0),
            gf.TestScope("weighing", ["weighing.density"], ["stiffening"], 1.0),
        ],
    )
    solvers = {
        "pressing": gf.solvers.PythonCallable(press),
        "weighing": gf.solvers.PythonCallable(weigh),
    }
    result = gf.calibrate(both, solvers)

    assert result.status == "calibrated"
    assert set(result.responses) == {"weighing.density"}
    assert set(result.curves) == {"pressing.stress"}


def test_search_learns_curves_by_ask_and_tell() -> None:
    search = gf.Sequential().start(problem(measured()), seed=1)
    while not search.finished:
        proposal = search.ask()
        assert proposal is not None
        search.tell(proposal, press(proposal.parameters, proposal.seed))

    assert search.answer().parameters["modulus"] == pytest.approx(TRUTH["modulus"], rel=0.1)


def test_a_curve_where_a_number_is_the_target_or_the_reverse_is_said_to_be_one() -> None:
    number = gf.Problem([gf.Parameter("modulus", 1e5, 4e5)], [gf.Target("stress", 5e3)])
    with pytest.raises(gf.RunFailedError) as caught:
        gf.calibrate(number, lambda p, seed: press({**p, "stiffening": 0.5}, seed))
    assert of_metamodels.IS_A_CURVE.is_in(str(caught.value), name="stress")

    with pytest.raises(gf.RunFailedError) as caught:
        gf.calibrate(problem(measured()), lambda p, _seed: {"stress": p["modulus"]})
    assert of_metamodels.IS_A_NUMBER.is_in(str(caught.value), name="stress")
    assert not of_calibration.RESPONSES_MISSING.is_in(str(caught.value))
