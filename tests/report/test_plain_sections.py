"""Contents of the plain sections: answer, heap, convergence, verification, runs, reproduction."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import unescape
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import contexts
import numpy as np
import pytest
from contexts import result_of
from PIL import Image

import grainfit
import needs
from benchmarks import chromium
from grainfit.analysis.analysis import Analysis
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.campaign.store.records import RunRecord
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.evaluation import Evaluation, Proposal, Response, Stage
from grainfit.formatting import number, rounded
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.drawing import simplified
from grainfit.metamodels.outliers import NO_OUTLIERS, Outliers
from grainfit.plots.labels import Label
from grainfit.report import messages as of_report
from grainfit.report import page as report_page
from grainfit.report import verdict_messages as messages
from grainfit.report.rows import response_row
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.answer.section import answer
from grainfit.report.sections.convergence.section import convergence
from grainfit.report.sections.particles.section import particles
from grainfit.report.sections.particles.shown_runs import read_view, shown_runs
from grainfit.report.sections.reproduce.section import reproduce
from grainfit.report.sections.runs.section import runs
from grainfit.report.sections.verification.section import verification
from grainfit.report.sections.yield_locus.section import rows_of_locus
from grainfit.report.verdict import shown_verdict
from grainfit.result import ParameterInterval, Result, RunCounts
from grainfit.result.parts import ResponseResult, YieldLocus, YieldLocusResult
from grainfit.run_definition import RunDefinition
from grainfit.scenes.run_output import snapshot_file
from grainfit.verdict import messages as of_verdict
from grainfit.verdict.out_of_reach import OutOfReach
from grainfit.verdict.reasons import Contradicted, FreshSeedsMissing, OutliersDecide, Reason
from grainfit.work_folder.saved_calibration import SavedCalibration

DENSITY, FRICTION = "particle.density", "particle_particle.rolling_friction"
PROBLEM = grainfit.Problem(
    [
        grainfit.Parameter(DENSITY, 1400, 2800, unit="kg/m^3"),
        grainfit.Parameter(FRICTION, 0.4, 0.9),
    ],
    [
        grainfit.Target("bulk_density", 1500.0, tolerance=15.0, unit="kg/m^3"),
        grainfit.Target("angle_of_repose", 22.0, tolerance=0.5, unit="deg"),
    ],
)
ANSWER = {DENSITY: 2309.4321, FRICTION: 0.52}
MET = result_of(PROBLEM, ANSWER)
FRESH_ANGLES = (21.6, 21.9, 22.4, 21.8)
ANGLE = replace(
    MET.responses["angle_of_repose"],
    predicted=21.9,
    standard_error=0.11,
    # Mean 21.925, standard error 0.170, Student's t of three degrees of freedom 3.18.
    verified_mean=21.925,
    verified_standard_error=0.1702,
    verified_interval=0.5417,
    verified_values=FRESH_ANGLES,
    verified_seeds=(10, 11, 12, 13),
    deviation_percent=-0.45,
)
BULK_DENSITY = replace(
    MET.responses["bulk_density"],
    predicted=1501.84,
    standard_error=0.765,
    verified_mean=1503.0,
    verified_standard_error=0.6,
    verified_interval=1.9,
    verified_values=(1502.4, 1502.8, 1503.8, 1503.0),
    verified_seeds=(10, 11, 12, 13),
    deviation_percent=0.12,
)
RESULT = replace(
    MET,
    responses={"bulk_density": BULK_DENSITY, "angle_of_repose": ANGLE},
    runs=RunCounts(
        design=5, optimisation=11, verification=24, failed=1, reused=2, total=40, warm_start_runs=3
    ),
    rayleigh_time_step=0.002153,
    rayleigh_time_step_before=0.002054,
    probability_all_met=0.96,
    wall_seconds=120.0,
    other_notices=("<i>look</i>",),
)


def evaluation(
    seed: int,
    stage: Stage = "design",
    parameters: Mapping[str, float] = ANSWER,
    *,
    density: float | None = 1500.0,
    angle: float | None = 22.0,
    reason: str = "",
) -> Evaluation:
    found = {"bulk_density": density, "angle_of_repose": angle}
    return Evaluation(
        Proposal(parameters, seed, stage),
        {name: Response(value, 0.1) for name, value in found.items() if value is not None},
        {"heap": reason} if reason else {},
        runs={"heap": f"run{seed:029d}"},
        seconds=3.25,
    )


FAILED = evaluation(3, density=None, angle=None, reason="it <b>exploded</b>")
RUNS = (
    evaluation(1, parameters={DENSITY: 1400.0, FRICTION: 0.4}, density=1000.0, angle=15.0),
    evaluation(2, parameters={DENSITY: 2800.0, FRICTION: 0.9}, density=1800.0, angle=30.0),
    FAILED,
    *(evaluation(10 + i, "verification", angle=angle) for i, angle in enumerate(FRESH_ANGLES)),
)


def context(
    state: str = "calibrated",
    result: Result | None = RESULT,
    evaluations: Sequence[Evaluation] = RUNS,
    analysis: Analysis | None = None,
    folder: Path = Path("beads.grainfit"),
    **changes: Any,
) -> ReportContext:
    records = {
        identity: RunRecord(
            identity,
            test,
            "failed" if done.failures else "finished",
            RunDefinition({"solver": "lammps", "version": "29 Aug 2024", "test": {}}, {}, 1),
            reason=done.failures.get(test, ""),
            log_tail="step 1\nERROR: <b>lost</b> atoms\n" if done.failures else "",
            seconds=done.seconds,
        )
        for done in evaluations
        for test, identity in done.runs.items()
    }
    reading = SavedCalibration(
        folder=folder,
        name="beads",
        identity="f" * 32,
        state=state,
        problem=PROBLEM,
        strategy="sequential",
        seed=7,
        evaluations=tuple(evaluations),
        warm_start=(),
        running=2 if state == "running" else 0,
        records=records,
        result=result,
        result_fault="",
        fixed={"wall.density": 7700.0},
        units={DENSITY: "kg/m^3", "wall.density": "kg/m^3"},
        source="it's beads.toml",
        source_text="name = 'beads' # <b>\n",
        version="0.1.0",
        workers=2,
        started=1.7e9,
    )
    return ReportContext(replace(reading, **changes), analysis or Analysis())


def text(section: Section | None) -> str:
    """What is read of a section."""
    assert section is not None
    words = re.sub(r"<[^>]*>", " ", str(section.html))
    return " ".join(unescape(words).split())


def posterior(intervals: Mapping[str, tuple[float, float]]) -> Any:
    return SimpleNamespace(
        interval=lambda name: intervals[name],
        median=lambda name: sum(intervals[name]) / 2,
        converged=True,
    )


def analysis_with(intervals: Mapping[str, tuple[float, float]]) -> Analysis:
    """The first parameter determined, the second narrowed."""
    words = ("determined", "narrowed")
    found = {
        name: ParameterInterval(*ends, word)
        for (name, ends), word in zip(intervals.items(), words, strict=True)
    }
    return Analysis(posterior=posterior(intervals), intervals=found)


# --- Answer ---------------------------------------------------------------------------------------


def test_values_have_the_digits_that_their_uncertainty_leaves() -> None:
    assert rounded(2309.4321, 31.0) == "2309"
    assert rounded(2309.4321, 310.0) == "2310"
    assert rounded(0.52, 0.045) == "0.520"
    assert rounded(-0.0215, 0.0011) == "−0.0215"
    assert rounded(3.6123e7, 2.5e5) == "3.612·10⁷"
    assert rounded(1.234567891, 1e-12) == "1.23457"
    assert rounded(0.0, 0.2) == "0.00"
    assert number(3.6e-7) == "3.6·10⁻⁷"
    assert {rounded(float("nan"), 1.0), number(float("inf")), rounded(None, None)} == {"–"}


def test_the_answer_has_verdict_values_intervals_and_cost() -> None:
    intervals = {DENSITY: (2280.0, 2341.0), FRICTION: (0.4801, 0.5712)}
    analysis = analysis_with(intervals)
    section = answer(context(analysis=analysis))
    shown = text(section)
    for words in (
        messages.CALIBRATED(),
        RESULT.sureness,
        messages.DETERMINATIONS(parameters="2 parameters", parts="1 determined, 1 narrowed"),
        "particle-particle rolling friction coefficient 0.520 ! narrowed 0.48 to 0.571",
        "ρ p kg/m³ particle density of the solid 2309 ✓ determined 2280 to 2340",
        "✓ met 1500 ± 15 1501.8 ± 1.5 +0.12 % 1503.0 ± 1.9",
        "✓ met 22.00 ± 0.50 21.90 ± 0.22 −0.45 % 21.93 ± 0.54",
        "2.153 ms , 1.05 times that of the middle of the intervals (2.054 ms)",
        "40 = 5 design + 11 optimisation + 24 verification; 1 failed, 2 reused, warm start from 3",
        "2 min 00 s since it was started last",
        "7700",
    ):
        assert words in shown
    assert "&lt;i&gt;look&lt;/i&gt;" in section.html


def test_without_an_interval_the_answer_says_why() -> None:
    shown = answer(context(analysis=Analysis(notes=("Too few runs.",))))
    assert '<abbr title="Too few runs.">–</abbr>' in shown.html


@pytest.mark.parametrize(
    ("state", "result", "grade", "words"),
    [
        ("calibrated", RESULT, "good", messages.CALIBRATED()),
        ("calibrated", None, "warn", messages.RESULT_MISSING()),
        ("running", None, "warn", messages.SIMULATED_AND_RUNNING(runs="7 runs", running="2 runs")),
        ("interrupted", None, "warn", messages.INTERRUPTED_EARLY()),
        ("interrupted", RESULT, "warn", messages.INTERRUPTED()),
        ("failed", None, "bad", "The first 3 runs all failed"),
        ("undecided", RESULT, "warn", messages.UNDECIDED(what="every measurement", verb="is")),
        ("out_of_tolerance", RESULT, "bad", "Not calibrated: "),
    ],
)
def test_the_verdict_is_one_line_in_words(
    state: str, result: Result | None, grade: str, words: str
) -> None:
    stopped_by = "the first 3 runs all failed" if state == "failed" else ""
    found = shown_verdict(context(state, result, failure=stopped_by))
    assert found.grade == grade
    assert words in " ".join((found.line, *found.details))


def not_met(state: str, **changes: Any) -> ReportContext:
    """A calibration whose expected angle does not count as met."""
    responses = {**RESULT.responses, "angle_of_repose": replace(ANGLE, **changes)}
    return context(state, replace(RESULT, responses=responses))


def test_a_missed_target_and_a_bound_in_the_way_are_named() -> None:
    outside = not_met(
        "out_of_tolerance",
        predicted=21.3,
        probability=0.01,
        verdict="missed",
        deviation_percent=-3.18,
    )
    assert "angle of repose deviates by −3.18 %, and ±2.27 % are accepted" in text(answer(outside))
    assert "✗ missed" in text(answer(outside))
    assert "bulk density" not in text(answer(outside)).partition("Parameters")[0]
    miss = OutOfReach("bulk_density", 1500, 1425, 2.0, False, DENSITY, "max", 2205.0, 2340.0)
    unreachable = context("unreachable", replace(RESULT, out_of_reach=(miss,)))
    assert of_verdict.BOUND.is_in(
        text(answer(unreachable)), bound="particle.density.max = 2205", suggestion=2340
    )


def test_an_undecided_answer_says_what_is_in_doubt_how_likely_it_is_met_and_why() -> None:
    undecided = not_met("undecided", predicted=21.6, probability=0.71, verdict="in doubt")
    shown = text(answer(undecided))
    top = shown.partition("Parameters")[0]
    line = messages.UNDECIDED(what="angle of repose (71 %)", verb="is")
    assert top.startswith(f"! {line}")
    assert "bulk density" not in top
    # The reasons say what to do.
    assert "<i>look</i>" in top
    assert shown.count("<i>look</i>") == 1
    assert "! in doubt 22.00 ± 0.50 21.60 ± 0.22" in shown
    assert "✓ met 1500 ± 15" in shown
    both = replace(
        undecided.reading.result,
        responses={
            name: replace(found, probability=0.9, verdict="in doubt")
            for name, found in RESULT.responses.items()
        },
    )
    what = "bulk density (90\u00a0%) and angle of repose (90\u00a0%)"
    line = shown_verdict(context("undecided", both)).line
    assert line == messages.UNDECIDED(what=what, verb="are")


@pytest.mark.parametrize(
    ("reason", "gives_probability"),
    [(OutliersDecide(0.96, 0.4), True), (FreshSeedsMissing(1, 3, 0, 0), False)],
)
def test_reasons_stand_beside_the_verdict_and_say_the_probability_once(
    reason: Reason, gives_probability: bool
) -> None:
    found = context("undecided", replace(RESULT, reasons=(reason,)))
    details = shown_verdict(found).details
    assert details[0] == str(reason)
    assert (RESULT.sureness in details) != gives_probability
    shown = unescape(answer(found).html)
    assert shown.count(str(reason)) == 1
    assert shown.count("<i>look</i>") == 1, "other notices stand below"


def test_the_expected_response_is_that_of_all_runs_with_fresh_seeds_and_without() -> None:
    shown = text(answer(context()))
    without = text(answer(context(result=without_fresh_seeds())))
    assert "22.00 ± 0.50 21.90 ± 0.22 −0.45 % 21.93 ± 0.54" in shown
    assert "22.00 ± 0.50 21.90 ± 0.22 −0.45 %" in without
    assert "Fresh seeds" not in without


def without_fresh_seeds(kept: int = 0) -> Result:
    """The result when only so few of the fresh seeds were run."""
    few = {
        name: replace(
            found,
            verified_mean=None,
            verified_standard_error=None,
            verified_interval=None,
            verified_values=found.verified_values[:kept],
            verified_seeds=found.verified_seeds[:kept],
        )
        for name, found in RESULT.responses.items()
    }
    return replace(RESULT, responses=few)


def test_an_interval_over_orders_of_magnitude_has_two_ends() -> None:
    wide = grainfit.Parameter(DENSITY, 1e5, 1e8, "log")
    problem = grainfit.Problem([wide, PROBLEM.parameters[1]], PROBLEM.targets)
    intervals = {DENSITY: (1.312e5, 8.4e7), FRICTION: (0.48, 0.57)}
    result = replace(RESULT, parameters={DENSITY: 3.04e6, FRICTION: 0.52})
    analysis = analysis_with(intervals)
    found = answer(
        context(result=result, problem=problem, evaluations=(), units={}, analysis=analysis)
    )
    assert "3.04·10⁶ ✓ determined 1.31·10⁵ to 8.4·10⁷" in text(found)


def test_where_nothing_agrees_there_is_no_interval() -> None:
    analysis = analysis_with({DENSITY: (1.0, 2.0), FRICTION: (0.4, 0.5)})
    found = answer(context("unreachable", analysis=analysis))
    assert str(found.html).count("No parameter set within the intervals agrees") == 2


def test_all_parameters_are_in_the_answer() -> None:
    free = [grainfit.Parameter(name, 0.1, 0.4) for name in MATERIAL_PARAMETERS]
    parameters = {parameter.name: 0.25 for parameter in free}
    problem = grainfit.Problem(free, PROBLEM.targets)
    result = replace(RESULT, parameters=parameters)
    found = answer(context(result=result, problem=problem, fixed={}, evaluations=()))
    assert str(found.html).count('class="range-value" style="left:50.0%"') == len(free)


# --- Heap -----------------------------------------------------------------------------------------

BEADS = ParticleSizes((0.010,))


def cone(angle: float, seed: int) -> np.ndarray[Any, Any]:
    """Centres of spheres of 10 mm on a lattice, shaken, that fill a cone of this angle."""
    random = np.random.default_rng(seed)
    slope = np.tan(np.radians(angle))
    axis = np.arange(-0.2, 0.2, 0.0095)
    grid = np.stack(np.meshgrid(axis, axis, np.arange(0.005, 0.1, 0.0085)), axis=-1).reshape(-1, 3)
    grid[:, :2] += random.normal(0, 0.001, (len(grid), 2))
    inside = grid[:, 2] < (0.17 - np.hypot(grid[:, 0], grid[:, 1])) * slope
    return np.asarray(grid[inside])


def write_dump(path: Path, centres: np.ndarray[Any, Any]) -> None:
    rows = "".join(f"{i} {x} {y} {z} 0.005 0.001\n" for i, (x, y, z) in enumerate(centres, 1))
    path.parent.mkdir(exist_ok=True)
    path.write_text(
        f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(centres)}\nITEM: BOX BOUNDS ff ff ff\n"
        f"0 1\n0 1\n0 1\nITEM: ATOMS id x y z radius mass\n{rows}"
    )


@pytest.fixture
def heaps(tmp_path: Path) -> ReportContext:
    """A calibration whose runs left heaps of 15 to 30 degrees behind."""
    known = context(folder=tmp_path)
    test = Heap(BEADS).definition()
    records = {
        identity: replace(record, definition=RunDefinition({"test": test}, {}, 1))
        for identity, record in known.reading.records.items()
    }
    for done in RUNS:
        folder = tmp_path / "runs" / done.runs["heap"]
        folder.mkdir(parents=True)
        if "angle_of_repose" in done.responses:
            angle = done.responses["angle_of_repose"].value
            write_dump(folder / snapshot_file("heap"), cone(angle, done.proposal.seed))
    return context(folder=tmp_path, records=records)


def test_the_answer_says_how_its_tests_were_simulated(heaps: ReportContext) -> None:
    shown = text(answer(heaps))
    assert "How the test heap was simulated" in shown
    assert "cylinder_radius Inner radius of the cylinder 60 mm" in shown
    assert "lift_speed Speed of the cylinder 0.05 m/s" in shown


def test_the_heap_is_that_of_a_typical_verification_run(heaps: ReportContext) -> None:
    section = particles(heaps)
    shown = text(section)
    # Their mean is 21.925 degrees.
    assert "nearest to their mean: run 5." in shown
    assert "simulated: 21.9°" in shown
    assert "measured: 22.00°" in shown
    # One of each parameter set, in order.
    strip = re.findall(r"<figcaption><strong>([\d.]+)°", str(section.html))
    assert strip == ["15", "21.8", "30"]
    assert len(section.html) < 60_000
    # In three dimensions, all at one scale, and small.
    drawn = [
        section.data[key] for key in re.findall(r'data-particles="([^"]+-run-\d)"', section.html)
    ]
    assert len(drawn) == 3
    assert len({json.dumps(one["extent"]) for one in drawn}) == 1
    radii = {np.frombuffer(base64.b64decode(one["particles"]), "<i2")[3] for one in drawn}
    assert len(radii) == 1
    tops = [np.frombuffer(base64.b64decode(one["particles"]), "<i2")[2::4].max() for one in drawn]
    assert tops == sorted(tops)
    assert max(tops) + radii.pop() == drawn[0]["extent"]["top"]
    assert tops[0] < 0.7 * tops[2]
    assert section.data["particles-1"]["outlines"][0][0][0] > 0


#: Width of each drawing of the strip, and a mark of its picture; 0 for one that is not shown.
STRIP = """() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(
    [...document.querySelectorAll(".strip canvas")].map((canvas) => [
        canvas.clientWidth, canvas.clientWidth && canvas.toDataURL(),
    ])))))"""


@needs.CHROMIUM
def test_the_corners_stand_side_by_side_in_three_dimensions(
    heaps: ReportContext, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(report_page, "SECTIONS", (particles,))
    path = tmp_path / "report.html"
    path.write_text(report_page.render_page(heaps))
    with chromium.browser() as browser:
        page = browser.new_page(viewport={"width": 1366, "height": 900})
        page.goto(path.as_uri())
        page.evaluate("document.querySelector('details').open = true")
        silhouettes, canvases = page.locator(".strip .silhouette"), page.locator(".strip canvas")
        button = page.get_by_role("button", name="in 3-D")
        assert silhouettes.count() == canvases.count() == 3
        # Nothing is drawn before it is asked for: a canvas begins 300 pixels wide.
        assert not any(width for width, _ in page.evaluate(STRIP))
        assert canvases.nth(0).evaluate("one => one.width") == 300

        button.click()
        page.wait_for_function(
            "() => Array.from(document.querySelectorAll('.strip canvas'))"
            ".every((one) => one.width !== 300)"
        )
        assert button.get_attribute("aria-pressed") == "true"
        assert not silhouettes.nth(0).is_visible()
        before = page.evaluate(STRIP)
        assert len({picture for _, picture in before}) == 3
        # One stop of the keyboard, and turning one turns all.
        assert canvases.evaluate_all("all => all.map((one) => one.tabIndex)") == [0, -1, -1]
        canvases.nth(0).focus()
        page.keyboard.press("ArrowRight")
        turned = page.evaluate(STRIP)
        assert all(one != other for one, other in zip(before, turned, strict=True))
        assert canvases.nth(0).evaluate("one => one === document.activeElement")

        # On paper they are silhouettes.
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert silhouettes.nth(0).is_visible()
        assert not canvases.nth(0).is_visible()
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        button.click()
        assert silhouettes.nth(0).is_visible()
        assert not canvases.nth(0).is_visible()


def test_the_drawn_outline_is_that_of_the_heap(heaps: ReportContext) -> None:
    runs_of_test = shown_runs(
        heaps.reading.evaluations, heaps.reading.records, heaps.reading.folder
    )
    found = read_view(runs_of_test["heap"][1])
    assert found is not None
    path = found.drawing().path
    heights = [-float(y) for y in re.findall(r",(-?\d+)", path)]
    # A particle's diameter is 20 pixels.
    top = (found.particles.positions[:, 2] + found.particles.radii).max()
    assert max(heights) == pytest.approx(top / 0.010 * 20, abs=2)
    measured = found.measured_drawing(22.0)
    assert re.fullmatch(r"mean of \d+ fitted flanks from all sides", measured.words)
    for flank in measured.drawing.fitted:
        rise, run = flank.y2 - flank.y1, flank.x2 - flank.x1
        assert abs(np.degrees(np.arctan(rise / run))) == pytest.approx(30, abs=2.5)
    assert len(measured.drawing.wanted) == 2


def test_simplified_outlines_stay_near_the_whole_ones() -> None:
    heights = np.sqrt(np.maximum(0, 400 - np.arange(-30.0, 31.0) ** 2))
    kept = simplified(heights, 1.0)
    drawn = np.interp(np.arange(len(heights)), kept, heights[kept])
    assert len(kept) < 20
    assert np.abs(drawn - heights).max() <= 1.0


def test_heaps_of_version_0_1_0_are_shown(heaps: ReportContext) -> None:
    """Their dumps lie beside the deck."""
    before = text(particles(heaps))
    for dump in list(heaps.reading.folder.rglob("heap.dump")):
        dump.rename(dump.parents[1] / dump.name)
        dump.parent.rmdir()

    assert "simulated: 21.9°" in before
    assert text(particles(heaps)) == before


def test_the_picture_takes_the_place_of_particles_that_are_gone(heaps: ReportContext) -> None:
    for dump in heaps.reading.folder.rglob("heap.dump"):
        dump.unlink()
    pictured = heaps.reading.folder / "runs" / RUNS[4].runs["heap"] / "heap.png"
    Image.new("RGB", (4, 4)).save(pictured)
    section = particles(heaps)
    assert 'src="data:image/png;base64,' in section.html
    assert "Its particles were not kept" in text(section)
    pictured.write_text("<svg onload=alert(1)>")
    assert "No heap to show" in text(particles(heaps))


@pytest.mark.parametrize("damage", ["ITEM: TIMESTEP\n", "\x00", "ITEM: ATOMS id x\n1 nan\n"])
def test_damaged_folders_and_records_are_passed_over(heaps: ReportContext, damage: str) -> None:
    for dump in list(heaps.reading.folder.rglob("heap.dump"))[1:]:
        dump.write_text(damage)
    text(particles(heaps))
    broken = {
        identity: replace(
            record, definition=RunDefinition({"test": {"type": "heap", "setup": 3}}, {}, 1)
        )
        for identity, record in heaps.reading.records.items()
    }
    assert "No heap to show" in text(
        particles(context(folder=heaps.reading.folder, records=broken))
    )


def test_without_a_bulk_test_the_section_says_so() -> None:
    words = text(particles(context()))
    assert "this calibration has no run" in words
    assert all(name in words for name in BUILT_IN)


# --- Convergence and verification -----------------------------------------------------------------


def test_convergence_shows_every_run_by_stage_and_failures_at_the_edge() -> None:
    section = convergence(context())
    figure = section.figures["convergence-1"]
    by_name = {trace["name"]: trace for trace in figure.data if "name" in trace}
    assert by_name["design"]["x"] == [1, 2]
    assert by_name["verification"]["x"] == [4, 5, 6, 7]
    assert by_name["failed"]["x"] == [3]
    assert by_name["failed"]["text"] == ["it &lt;b&gt;exploded&lt;/b&gt;"]
    shapes = {trace["marker"]["symbol"] for trace in figure.data if "marker" in trace}
    assert len(shapes) == 3, "stages are told apart without colour"
    band = figure.layout["shapes"][0]
    assert (band["y0"], band["y1"]) == (21.5, 22.5)
    low, high = figure.layout["yaxis"]["range"]
    assert low < 15 < 30 < high


def test_the_line_of_the_deviation_is_the_expected_one_not_the_luckiest_run() -> None:
    figure = convergence(context()).figures["convergence-misfit"]
    names = [trace.get("name") for trace in figure.data]
    # Too few runs for metamodels.
    assert "best so far" not in names
    assert "expected at the answer" not in names
    wanted = contexts.problem(2, 2)
    made = contexts.context(wanted, contexts.evaluations(wanted, 24))
    [line] = (
        trace
        for trace in convergence(made).figures["convergence-misfit"].data
        if trace.get("name") == "expected at the answer"
    )
    means = made.analysis.metamodels.predict(wanted.to_unit(made.answer))[0][0]  # type: ignore[union-attr]
    values = [abs(m - t.value) / t.tolerance for m, t in zip(means, wanted.targets, strict=True)]
    assert line["x"][-1] == 24
    assert line["y"][-1] == pytest.approx(max(values))


def test_before_the_first_run_sections_say_what_they_wait_for() -> None:
    empty = context("running", None, ())
    for section in (convergence(empty), verification(empty), runs(empty), answer(empty)):
        assert len(text(section)) > 15
        assert not section.figures


def test_verification_puts_the_mean_of_fresh_seeds_beside_what_all_runs_expect() -> None:
    section = verification(context())
    shown = text(section)
    assert "simulated 4 times" in shown
    assert "angle of repose ✓ agrees" in shown
    assert (
        "their mean is 21.93 ± 0.54°; all runs together lead to expect 21.90 ± 0.22°, and "
        "22 ± 0.5° was measured"
    ) in shown
    bulk_density, angle = (section.figures[f"verification-{i}"].data for i in (0, 1))
    assert bulk_density[0]["x"] == [1502.4, 1502.8, 1503.8, 1503.0]
    points, mean, expected = angle
    assert points["x"] == list(FRESH_ANGLES)
    assert points["customdata"] == [10, 11, 12, 13]
    assert mean["x"] == [21.925]
    assert mean["error_x"]["array"][0] == pytest.approx(0.5417, abs=1e-3)
    assert expected["x"] == [21.9]
    assert expected["error_x"]["array"][0] == pytest.approx(1.96 * 0.11)


def test_only_runs_of_particles_are_said_to_jam(heaps: ReportContext) -> None:
    angle = replace(ANGLE, jams_not_excluded=0.19)
    result = replace(RESULT, responses={"angle_of_repose": angle})
    own_model = text(verification(context(result=result)))
    assert of_report.NO_OUTLYING_RUNS.is_in(own_model, share=19)
    assert "jam" not in own_model
    bulk_test = replace(heaps, reading=replace(heaps.reading, result=result))
    assert of_report.NO_JAMS.is_in(text(verification(bulk_test)), share=19)


def test_fresh_seeds_that_contradict_the_others_are_marked_as_the_verdict_has_it() -> None:
    doubt = Contradicted("angle_of_repose", "deg", 21.93, 0.54, 4, 22.7)
    shown = text(verification(context("undecided", replace(RESULT, reasons=(doubt,)))))
    assert "angle of repose ! differs" in shown
    assert "bulk density ✓ agrees" in shown


@pytest.mark.parametrize(
    ("state", "runs", "words"),
    [
        ("interrupted", 1, "at least 2 finished runs at it with fresh seeds, and 1 is there"),
        ("undecided", 1, "Only 1 run with fresh seeds at the answer gave a response"),
        ("unreachable", 0, "they are made only where they could confirm it"),
    ],
)
def test_an_answer_without_fresh_seeds_says_why(state: str, runs: int, words: str) -> None:
    shown = text(verification(context(state, without_fresh_seeds(runs))))
    assert words in shown
    # Those that were made verified an earlier answer.
    assert f"{4 - runs} more runs verified earlier answers." in shown


def test_the_fresh_seeds_of_a_result_of_version_0_1_0_are_those_of_its_runs() -> None:
    old = {
        name: replace(found, probability=None, verified_values=(), verified_seeds=())
        for name, found in RESULT.responses.items()
    }
    section = verification(context(result=replace(RESULT, responses=old)))
    assert "simulated 4 times" in text(section)
    points, *_ = section.figures["verification-1"].data
    assert points["x"] == list(FRESH_ANGLES)


def test_verification_runs_at_other_answers_do_not_count() -> None:
    other = evaluation(50, "verification", {DENSITY: 2000.0, FRICTION: 0.6}, angle=40.0)
    shown = text(verification(context(evaluations=(*RUNS, other))))
    assert "simulated 4 times" in shown
    assert "1 more run verified earlier answers." in shown


# --- Runs and reproduction ------------------------------------------------------------------------


def test_every_run_is_in_the_table_with_its_reason_and_log() -> None:
    section = runs(context())
    html = str(section.html)
    assert len(re.findall(r'<tr id="run-\d+"', html)) == len(RUNS)
    assert "it &lt;b&gt;exploded&lt;/b&gt;" in html
    assert "ERROR: &lt;b&gt;lost&lt;/b&gt; atoms" in html
    assert 'data-value="2309.4321"' in html
    assert "7 parameter sets, 1 of them with a failed run" in text(section)


def test_outlying_runs_are_marked_in_the_table() -> None:
    outliers = [NO_OUTLIERS, Outliers((4,), (9.0,), ((0.5,),) * 7, (11,))]
    metamodels: Any = SimpleNamespace(problem=PROBLEM, outliers=outliers)
    html = str(runs(context(analysis=Analysis(metamodels=metamodels))).html)
    assert html.count(">outlying</abbr>") == 1
    (row,) = (row for row in html.split("<tr ") if ">outlying</abbr>" in row)
    assert 'data-value="11"' in row
    assert "Its angle of repose lies far from" in row


def test_the_command_can_be_pasted_into_a_shell() -> None:
    section = reproduce(context())
    command = "grainfit run 'it'\"'\"'s beads.toml' --strategy sequential --seed 7 --workers 2"
    shown = text(section)
    assert command in shown
    assert "lammps 29 Aug 2024 (test heap)" in shown
    assert "f" * 32 in shown
    assert "name = 'beads' # <b>" in unescape(str(section.html))
    limited = text(reproduce(context(max_runs=40)))
    assert f"{command} --max-runs 40" in limited


def test_a_calibration_from_python_says_so() -> None:
    shown = text(reproduce(context(source="", source_text="")))
    assert "started from Python" in shown


def test_an_error_that_is_rounding_of_the_computer_is_none_in_any_cell() -> None:
    target = grainfit.Target("angle", 22.0, tolerance=0.5)
    found = ResponseResult(22.0, 0.5, "", 22.0, 0.1, 22.0, 1e-15, 4e-15, 0.0, "met", 0.99)
    row = response_row(Label("angle", "angle", "", ""), target, found)
    assert row.fresh == "22 ± 0"
    line = YieldLocus((), (), Response(40.0, 4e-15), Response(26.0, 0.12))
    cells = rows_of_locus(YieldLocusResult(("one", "other"), line))
    assert list(cells) == [("Measured", ["40 ± 0", "26.00 ± 0.12"])]
