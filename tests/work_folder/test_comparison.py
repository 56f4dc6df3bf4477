"""Calibrations side by side."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
import needs
from benchmarks import chromium
from benchmarks.axe import violations
from grainfit.cli.app import app
from grainfit.errors import InputError, StoreError
from grainfit.evaluation import response_name
from grainfit.report.compared.page import write_compared_page
from grainfit.result import CurveResult, YieldLocus, YieldLocusResult
from grainfit.tables import TextTable
from grainfit.work_folder import messages
from grainfit.work_folder.compared_rows import ComparedValue
from grainfit.work_folder.comparison import compare
from grainfit.work_folder.saved_calibration import SavedCalibration


def calibrated(folder: Path, angle: float) -> SavedCalibration:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", angle, tolerance=0.6)]
    )

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        return {"angle": 60 * parameters["friction"] + 0.1 * (seed % 7 - 3)}

    gf.calibrate(problem, simulate, workdir=folder)
    return SavedCalibration.open(folder)


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> list[SavedCalibration]:
    folder = tmp_path_factory.mktemp("compared")
    angles = {"dry sand": 30.0, "again": 30.1, "wet 'sand'": 42.0}
    return [calibrated(folder / name, angle) for name, angle in angles.items()]


def rows(saved: list[SavedCalibration], number: int) -> dict[str, tuple[str, ...]]:
    table = [part for part in compare(saved).parts() if isinstance(part, TextTable)][number]
    return {name: tuple(cells) for name, *cells in table.rows}


def test_comparison_of_one_material_agrees_and_of_two_differs(
    three: list[SavedCalibration],
) -> None:
    first, again, wet = three
    for number, name in enumerate(("friction", "angle")):
        assert rows([first, again], number)[name][-1] == "agree"
        assert rows([first, wet], number)[name][-1] == "differ"
    shown = rows(three, 0)["friction"]
    assert [cell.split()[0][:3] for cell in shown[:3]] == ["0.5", "0.5", "0.7"]


def test_comparison_judges_those_that_have_a_row_and_lists_no_equal_fixed_values(
    three: list[SavedCalibration],
) -> None:
    first, again, wet = three
    equal, other = {"damping": 0.1, "blades": 4.0}, {"damping": 0.1, "blades": 6.0}
    one, two = replace(first, fixed=equal), replace(again, fixed=other)
    found = rows([one, two, wet], 0)
    assert "damping" not in found
    assert found["blades"] == ("4 (fixed)", "6 (fixed)", "–", "differ")
    assert rows([one, wet], 0)["blades"] == ("4 (fixed)", "–", "")


def of_tests(saved: SavedCalibration, **types: str) -> SavedCalibration:
    """Return a calibration as if the angle were that of each of these bulk tests, by name."""
    record, result = next(iter(saved.records.values())), saved.result
    assert result is not None
    own = {
        name: replace(record.definition, model={"test": {"type": kind}})
        for name, kind in types.items()
    }
    records = {n: replace(record, test=n, definition=one) for n, one in own.items()}
    names = [response_name(name, "angle", len(types)) for name in types]
    responses = dict.fromkeys(names, result.responses["angle"])
    return replace(saved, records=records, result=replace(result, responses=responses))


def test_only_responses_of_one_type_of_test_are_in_one_row(three: list[SavedCalibration]) -> None:
    first, again, wet = three
    heap, funnel = of_tests(first, heap="heap"), of_tests(wet, funnel="funnel")
    both = of_tests(again, pile="heap", drum="drum")

    assert [row[-1] for row in rows([heap, funnel], 1).values()] == ["", ""]
    assert rows([of_tests(first, drum="drum"), of_tests(wet, mill="drum")], 1).keys() == {"angle"}
    found = rows([heap, both], 1)
    assert list(found) == ["heap.angle", "drum.angle"]
    assert found["heap.angle"][-1] == "agree"
    assert {(r.test, r.response) for r in compare([heap, heap]).responses} == {("heap", "angle")}


def test_two_tests_of_a_type_are_told_by_their_names(three: list[SavedCalibration]) -> None:
    one, two = of_tests(three[0], dry="heap"), of_tests(three[2], wet="heap", dry="heap")

    found = rows([one, two], 1)
    assert list(found) == ["dry.angle", "wet.angle"]
    assert found["dry.angle"][-1] == "differ"
    assert found["wet.angle"][0] == "–"


CURVE = CurveResult(
    *("strain", "", "Pa", (0.1, 0.2), (3.0, 4.0), (0.1, 0.1), (3.1, 4.0), (0.0, 0.0)),
    *(1, 0.71, 0.9, 1.0, "met"),
)
LINE = YieldLocus(
    (1e3, 2e3), (gf.Response(600.0),) * 2, gf.Response(100.0, 5.0), gf.Response(30.0, 1.0)
)


def test_curves_and_yield_loci_have_rows(three: list[SavedCalibration], tmp_path: Path) -> None:
    first, again, wet = (
        replace(one, result=replace(one.result, curves={"stress": CURVE})) for one in three
    )
    for one, other in (
        (first, LINE),
        (again, None),
        (wet, replace(LINE, cohesion=LINE.shear_stresses[0])),
    ):
        vars(one)["yield_loci"] = (YieldLocusResult(("simulate",), LINE, other),)
    saved = [first, again, wet, three[0]]

    found = compare(saved)
    assert rows(saved, 2)["stress"] == (*["0.71 σ off 2 points, met"] * 3, "–")
    loci = rows(saved, 3)
    assert loci["cohesion"][1:] == (
        "– (100.0 ± 9.8 Pa)",
        "600 ± 0 Pa (100.0 ± 9.8 Pa)",
        "–",
        "differ",
    )
    assert loci["internal_friction_angle"][-1] == "agree"
    plain = json.loads(json.dumps(found.document()))
    assert [one and one["deviation"] for one in plain["curves"][0]["values"]] == [0.71] * 3 + [None]
    assert [row["verdict"] for row in plain["yield_loci"]] == ["differ", "agree"]
    write_compared_page(found, saved, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert page.count("0.71 σ off 2 points, met") == 3
    assert "100.0 ± 9.8 Pa" in page


def test_comparison_has_one_notation_of_numbers() -> None:
    free = ComparedValue(9.279e6, 8.87e6, 9.74e6, "Pa")
    assert free.shown == "9.279·10⁶ Pa (8.87·10⁶ to 9.74·10⁶)"
    assert "e+" not in replace(free, measured=9.3e6, tolerance=2e5).shown


def test_comparison_shows_the_lines_and_the_particles_that_differ(
    three: list[SavedCalibration],
) -> None:
    files = [
        replace(one, source_text=f'diameter = "{d} mm"', sizes=gf.ParticleSizes((d / 1000,)))
        for one, d in zip(three, (10, 12), strict=False)
    ]
    assert '+diameter = "12 mm"' in compare(files).parts()
    assert rows(files, 2)["particle diameters"] == ("10 mm", "12 mm")


def test_comparison_names_states_as_the_report_does(three: list[SavedCalibration]) -> None:
    missed = replace(three[2], name="wet", state="unreachable")
    first = compare([three[0], missed]).parts()[1]
    assert first == "wet 'sand': wet, out of reach"


def test_comparison_says_that_a_calibration_has_no_answer_yet(
    three: list[SavedCalibration],
) -> None:
    with pytest.raises(InputError, match=messages.ONE_CALIBRATION.pattern):
        compare(three[:1])
    result = three[0].folder / "result.json"
    kept = result.read_text()
    try:
        result.unlink()
        with pytest.raises(InputError, match=messages.NO_ANSWER_FILE.pattern):
            compare([SavedCalibration.open(three[0].folder), three[1]])
        result.write_text("{")
        with pytest.raises(StoreError, match="is damaged"):
            compare([SavedCalibration.open(three[0].folder), three[1]])
    finally:
        result.write_text(kept)


@needs.CHROMIUM
def test_compare_command_writes_a_page_and_a_document(
    three: list[SavedCalibration], tmp_path: Path
) -> None:
    page = tmp_path / "compared.html"
    folders = [str(three[number].folder) for number in (0, 2, 1)]
    done = CliRunner().invoke(app, ["compare", *folders, "-o", str(page), "--json"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    (friction,) = found["parameters"]
    assert friction["verdict"] == "differ"
    assert friction["values"][0]["high"] < friction["values"][1]["low"]
    with chromium.browser() as browser:
        shown = browser.new_page(viewport={"width": 390, "height": 800})
        faults: list[str] = []
        shown.on("console", lambda message: faults.append(message.text))
        shown.on("pageerror", lambda error: faults.append(str(error)))
        shown.goto(page.as_uri())
        assert violations(shown) == []
        first, second = (bar.bounding_box() for bar in shown.locator(".range-credible").all()[:2])
        assert first is not None
        assert second is not None
        assert first["x"] + first["width"] < second["x"]
        assert shown.get_by_text("differ", exact=False).count() >= 2
        assert shown.evaluate("document.documentElement.scrollWidth") <= 390
        # A heading breaks between its words.
        height = "(one) => one.offsetHeight / parseFloat(getComputedStyle(one).lineHeight)"
        for heading in shown.locator(".table-wrap:not(:has(.bars)) tbody th").all():
            assert heading.evaluate(height) < 1 + len(heading.inner_text().split())
        # Bars and values are beside no edge, but the names of folders may be long.
        wide = "(one) => one.scrollWidth > one.clientWidth"
        assert not any(
            part.evaluate(wide) for part in shown.locator(".table-wrap:has(.bars)").all()
        )
        assert faults == []


@needs.CHROMIUM
@pytest.mark.parametrize("width", [1400, 1100, 700, 390])
def test_no_column_of_the_page_is_cut_off_beside_long_names(
    three: list[SavedCalibration], tmp_path: Path, width: int
) -> None:
    long = shutil.copytree(three[2].folder, tmp_path / ("a_long_name_of_a_folder_" * 3))
    page = tmp_path / "compared.html"
    write_compared_page(compare([three[0], SavedCalibration.open(long)]), [three[0]] * 2, page)
    with chromium.browser() as browser:
        shown = browser.new_page(viewport={"width": width, "height": 900})
        shown.goto(page.as_uri())
        tables = shown.locator(".table-wrap").all()
        assert len(tables) == 3
        assert not any(one.evaluate("one => one.scrollWidth > one.clientWidth") for one in tables)


def test_compare_command_shows_folders_by_their_names(three: list[SavedCalibration]) -> None:
    done = CliRunner().invoke(app, ["compare", *(str(one.folder) for one in three)])
    assert done.exit_code == 0, done.output
    for name in ("dry sand", "wet 'sand'", "friction", "differ"):
        assert name in done.output
