"""The customer's sheet: two pages that say what a material is worth, in every state."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pypdfium2
import pytest
from reportlab.pdfbase import pdfmetrics
from typer.testing import CliRunner

import grainfit
from grainfit.analysis.analysis import Analysis
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.cli.app import app
from grainfit.contact_models.registry import CONTACT_MODELS
from grainfit.formatting import plain_interval, rounded
from grainfit.pdf import BOLD, REGULAR, use_fonts
from grainfit.report import messages
from grainfit.report.sheet.sheet import write_sheet
from grainfit.result import CurveResult
from grainfit.work_folder.saved_calibration import SavedCalibration
from tests.report.contexts import NASTY, problem, reading, renamed

BEADS = Path(__file__).parents[2] / "docs" / "recorded" / "beads"


def pages(path: Path) -> list[str]:
    """Texts of the pages, lines and blanks as single blanks."""
    with closing(pypdfium2.PdfDocument(path)) as document:
        return [" ".join(page.get_textpage().get_text_range().split()) for page in document]


def sheet(saved: SavedCalibration, path: Path, **changes: Any) -> Path:
    """The sheet of a calibration, without an analysis: that takes seconds."""
    saved = replace(saved, **changes)
    vars(saved)["_analysis"] = Analysis()
    return write_sheet(saved, path)


@pytest.fixture(scope="module")
def saved() -> SavedCalibration:
    return SavedCalibration.open(BEADS)


def test_a_customer_gets_values_tests_forecast_and_hashes(
    saved: SavedCalibration, tmp_path: Path
) -> None:
    path = sheet(saved, tmp_path / "sheet.pdf")

    first, second = pages(path)
    result = saved.result
    assert result is not None
    for name, interval in result.intervals.items():
        assert rounded(result.parameters[name], (interval.high - interval.low) / 2) in first
        assert interval.determination in first
    assert "Hertz-Mindlin contact, EPSD rolling friction" in first
    for response in result.responses.values():
        assert plain_interval(response.target, response.tolerance) in second
    assert messages.TIME_STEP.is_in(second)
    assert "1,000,000" in second
    assert f"SHA-256 of {saved.source}" in second
    assert hashlib.sha256(saved.source_text.encode()).hexdigest() in second
    assert saved.identity in second
    # As in the report: what came from earlier calibrations is no run of this one.
    warm = replace(saved, result=replace(result, runs=replace(result.runs, warm_start_runs=4)))
    assert f"{result.runs.total} + 4 of earlier" in pages(sheet(warm, tmp_path / "warm.pdf"))[1]
    again = sheet(saved, tmp_path / "again.pdf")
    assert again.read_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    ("status", "words"),
    [
        ("calibrated", "CALIBRATED"),
        ("predicted", "PREDICTED, FULL SIZE PENDING"),
        ("undecided", "NOT CALIBRATED: UNDECIDED"),
        ("out_of_tolerance", "NOT CALIBRATED: OUT OF TOLERANCE"),
        ("unreachable", "NOT CALIBRATED: OUT OF REACH"),
        ("interrupted", "NOT CALIBRATED: NOT AT ITS END"),
    ],
)
def test_every_page_begins_with_the_state(status: str, words: str, tmp_path: Path) -> None:
    told = reading(problem(2, 2), [], answered=True)
    assert told.result is not None
    result = replace(told.result, status=status)

    path = sheet(told, tmp_path / "sheet.pdf", state=status, result=result)

    texts = pages(path)
    assert [text.startswith(f"{words} Material data") for text in texts] == [True, True]
    assert (messages.NOT_TO_BE_USED.is_in(texts[0])) == (status != "calibrated")
    # The band says it in colour, too: only a calibrated material is green.
    with closing(pypdfium2.PdfDocument(path)) as document:
        red, green, _ = np.array(document[1].render().to_pil().convert("RGB"))[3, 3].tolist()
    assert (green > red) == (status == "calibrated")


def test_a_result_of_a_start_that_was_begun_again_is_not_called_calibrated(tmp_path: Path) -> None:
    told = reading(problem(2, 2), [], answered=True)

    path = sheet(told, tmp_path / "sheet.pdf", state="running")

    assert all(text.startswith("NOT CALIBRATED: NOT AT ITS END") for text in pages(path))


def test_fourteen_parameters_long_names_and_a_curve_fit_on_two_pages(tmp_path: Path) -> None:
    wanted = renamed(problem(14, 12))
    told = reading(wanted, [], answered=True)
    assert told.result is not None
    values = tuple(range(1, 41))
    curve = CurveResult(
        "strain",
        "",
        "Pa",
        values,
        values,
        (0.5,) * 40,
        values,
        (0.1,) * 40,
        2,
        0.1,
        0.9,
        0.9,
        "met",
    )
    result = replace(
        told.result,
        curves={NASTY: curve},
        other_notices=tuple(f"notice {i} " + "and so on " * 90 for i in range(20)),
    )

    path = sheet(told, tmp_path / "s.pdf", result=result, name=NASTY + "x" * 400)

    first, second = pages(path)
    # Names are divided where they do not fit.
    shown = ["".join(page.split()) for page in (first, second)]
    assert all("".join(one.name.split()) in shown[0] for one in wanted.parameters)
    assert all("".join(one.name.split()) in shown[1] for one in wanted.targets)
    assert "14 further notices" in first
    assert "SHA-256 of the values" in second
    # Nothing crosses the margins.
    with closing(pypdfium2.PdfDocument(path)) as document:
        for page in document:
            seen = np.array(page.render().to_pil().convert("L"))[60:]
            assert (seen[:, :30] == 255).all()
            assert (seen[:, -30:] == 255).all()


def test_the_command_writes_it_and_says_why_it_cannot(tmp_path: Path) -> None:
    wanted = grainfit.Problem(
        [grainfit.Parameter("friction", 0.1, 0.9)],
        [grainfit.Target("angle", 36.0, tolerance=0.5, unit="deg")],
    )

    def simulate(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        return {"angle": 60 * parameters["friction"] + 0.1 * (seed % 3)}

    grainfit.calibrate(wanted, simulate, workdir=tmp_path / "sand", name="sand")

    done = CliRunner().invoke(app, ["report", str(tmp_path / "sand"), "--sheet"])

    assert done.exit_code == 0, done.output
    [name] = [path.name for path in (tmp_path / "sand").glob("*.pdf")]
    assert name == "sheet.pdf"
    first, second = pages(tmp_path / "sand" / name)
    assert "friction" in first
    assert messages.NO_SPEED.is_in(second) or messages.NO_TIME_STEP.is_in(second)
    (tmp_path / "taken").mkdir()
    with pytest.raises(grainfit.StoreError, match="cannot be written"):
        grainfit.open(tmp_path / "sand").sheet(tmp_path / "taken")
    unfinished = reading(wanted, [], answered=False)
    with pytest.raises(grainfit.InputError):
        sheet(unfinished, tmp_path / "no.pdf")
    assert not (tmp_path / "no.pdf").exists()


def test_every_symbol_has_a_letter_in_the_fonts() -> None:
    symbols = [info.symbol for test in BUILT_IN.values() for info in test.responses.values()]
    symbols += [one.symbol for model in CONTACT_MODELS for one in model.parameters]
    use_fonts()
    for font in map(pdfmetrics.getFont, (REGULAR, BOLD)):
        known = font.face.charToGlyph
        assert {sign for symbol in symbols for sign in symbol if ord(sign) not in known} == set()
