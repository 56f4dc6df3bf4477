"""Results and saved calibrations as short tables, for `print` and for a notebook."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.formatting import plain_ends, plain_interval
from grainfit.tables import TextTable, as_html, as_text
from grainfit.verdict import messages

PROBLEM = gf.Problem(
    [gf.Parameter("friction", 0.1, 0.9), gf.Parameter("<i>stiffness</i>", 1e5, 1e7, "log", "Pa")],
    [gf.Target("angle", 30.0, tolerance=0.5, unit="deg")],
)


def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"angle": 60 * parameters["friction"] + (seed % 5) / 20}


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> gf.OpenedCalibration:
    folder = tmp_path_factory.mktemp("tables") / "beads.grainfit"
    gf.calibrate(PROBLEM, simulate, workdir=folder, name="beads")
    return gf.open(folder)


def test_columns_are_aligned_and_nothing_obeyed() -> None:
    table = TextTable(("name", "value"), (("a", "1 kg"), ("long\x1b[1m", "12 kg")), "caption")
    assert table.text().splitlines() == [
        "name         value",
        "a             1 kg",
        "long\\x1b[1m  12 kg",
        "caption",
    ]
    assert as_text(["head\nline", table, "tail"]).count("\n\n") == 2
    assert as_text(["head"]) == "head"


def test_html_escapes_every_text() -> None:
    nasty = "<script>"
    html = as_html([nasty, "a\n<b>", TextTable((nasty,), ((nasty,),), nasty)])
    assert "<script" not in html
    assert html.startswith("<div><p><b>&lt;script&gt;</b></p><p>a<br>&lt;b&gt;</p><table>")
    assert html.count("&lt;script&gt;") == 4


def test_a_result_prints_as_a_short_table(saved: gf.OpenedCalibration) -> None:
    result = saved.result
    assert result is not None
    lines = str(result).splitlines()
    found = result.responses["angle"]
    expected, half = found.expected
    assert lines[0] == "beads: calibrated: every target is met within its tolerance"
    friction = result.intervals["friction"]
    shown = f"{result.parameters['friction']:.4g} {plain_ends(friction.low, friction.high)}"
    assert ["friction", *shown.split(), "determined"] in map(str.split, lines)
    (stiffness,) = (line for line in lines if line.startswith("<i>stiffness</i>"))
    assert stiffness.endswith("not determined")
    angle = next(line for line in lines if line.startswith("angle"))
    assert "30 ± 0.5 deg" in angle
    assert plain_interval(expected, half) in angle
    assert angle.endswith("met")
    assert messages.ALL_MET(probability="more than 99 %") in lines
    assert lines[-1] == f"DEM runs: {result.runs}."
    assert lines[-1].startswith(f"DEM runs: {result.runs.total} = ")
    assert len(lines) < 15
    assert max(map(len, lines)) <= 80
    assert "<i>" not in result._repr_html_()
    noticed = replace(result, name="", other_notices=("look",), parameters={}, responses={})
    assert str(noticed).splitlines()[:2] == [lines[0].partition(": ")[2], "look"]


def test_a_saved_calibration_prints_its_state(saved: gf.OpenedCalibration, tmp_path: Path) -> None:
    lines = str(saved).splitlines()
    assert lines[0] == "beads: calibrated"
    count = len(saved.evaluations)
    assert lines[1].startswith(f"{count} runs ended, 0 of them failed; 0 under")
    assert str(saved.result).splitlines()[2:] == lines[3:]
    assert "<b>beads: calibrated</b>" in saved._repr_html_()
    failed = replace(saved, state="failed", result=None, failure="no licence", name="")
    assert str(failed).splitlines() == [
        "beads.grainfit: failed",
        lines[1],
        "Stopped by: no licence",
    ]


def test_a_saved_calibration_opens_while_it_runs_and_makes_card_and_report(
    tmp_path: Path,
) -> None:
    seen: list[str] = []

    def look(_progress: gf.Progress) -> None:
        opened = gf.open(tmp_path / "work")
        seen.append(f"{opened.state} {opened.result}")

    def tell(progress: gf.Progress) -> None:
        if progress.done == 3 and not seen:
            look(progress)

    gf.calibrate(PROBLEM, simulate, workdir=tmp_path / "work", on_progress=tell)
    assert seen == ["running None"]

    opened = gf.open(tmp_path / "work")
    card = opened.card()
    written = card.write("json", tmp_path / "card.json")
    assert written == tmp_path / "card.json"
    assert f'"grainfit_version": "{opened.version}"' in written.read_text(encoding="utf-8")
    with pytest.raises(gf.InputError, match="is 'xml'"):
        card.write("xml", tmp_path / "card.xml")
    with pytest.raises(gf.InputError, match="cannot be written"):
        card.write("csv", tmp_path / "none" / "card.csv")
    assert opened.report(tmp_path / "page.html") == tmp_path / "page.html"
    assert opened.report() == tmp_path / "work" / "report.html"
