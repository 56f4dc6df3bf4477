"""The report is one complete file and is written in every state of a calibration."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from html.parser import HTMLParser
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

import grainfit
from grainfit.analysis import analysis
from grainfit.analysis.analysis import Analysis
from grainfit.campaign.folder_lock import hold
from grainfit.errors import StoreError
from grainfit.report import messages, verdict_messages
from grainfit.report.page import render_page
from grainfit.report.rendering import script_json
from grainfit.report.section import ReportContext
from grainfit.work_folder.saved_calibration import SavedCalibration

PROBLEM = grainfit.Problem(
    [grainfit.Parameter("friction", 0.1, 0.9)],
    [grainfit.Target("angle", 36.0, tolerance=0.5, unit="deg")],
)


def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
    scatter = np.random.default_rng(seed).normal(0, 0.2)
    return {"angle": 20 + 40 * parameters["friction"] + scatter}


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A work folder with a calibration that has ended well."""
    folder = tmp_path_factory.mktemp("work")
    grainfit.calibrate(PROBLEM, simulate, workdir=folder, name="sand </script><b> & 'Kies'")
    return folder


class Page(HTMLParser):
    """What a browser would make of the page: texts by element, and all addresses."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.texts: dict[str, str] = {}
        self.scripts: list[tuple[str, str]] = []
        self.addresses: list[str] = []
        self._open: list[str] = []
        self._kind = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        known = dict(attributes)
        self._open.append(tag)
        self._kind = known.get("type") or ""
        self.addresses += [v or "" for name, v in attributes if name in ("src", "href")]
        if tag == "script":
            self.scripts.append((self._kind, ""))

    def handle_endtag(self, tag: str) -> None:
        if tag in self._open:
            del self._open[len(self._open) - 1 - self._open[::-1].index(tag) :]

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "script":
            kind, before = self.scripts[-1]
            self.scripts[-1] = kind, before + data
        elif self._open:
            self.texts[self._open[-1]] = self.texts.get(self._open[-1], "") + data


def test_the_report_is_one_file_that_asks_for_nothing(work: Path) -> None:
    path = grainfit.write_report(work)
    assert path == work / "report.html"
    assert 1_000_000 < path.stat().st_size < 4_000_000
    page = Page(path.read_text(encoding="utf-8"))
    assert "sand </script><b> & 'Kies'" in page.texts["h1"]
    # Links to the folders of runs beside it are followed by a reader, never by the page.
    known = ("#", "data:", "runs/")
    assert [a for a in page.addresses if not a.startswith(known)] == []
    kinds = [kind for kind, _ in page.scripts]
    assert kinds.count("text/plain") == 1
    for kind, text in page.scripts:
        if kind == "application/json":
            json.loads(text)
        if kind == "text/plain":
            assert "Plotly, Inc." in text
            assert text.rstrip().endswith("}));")
    assert list(work.glob("*.new")) == []


def test_a_report_limits_threads_of_linear_algebra_once(
    work: Path, tmp_path: Path, thread_limits: Mock, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(analysis, "_last", None)
    grainfit.write_report(work, tmp_path / "report.html")
    thread_limits.assert_called_once()


def test_data_in_a_page_is_read_back_and_ends_no_element() -> None:
    data = {
        "<b>": "</script><!-- & \u2028 '\"",
        "surface": np.array([[1.0, np.nan], [-np.inf, 123456.789]]),
        "count": np.int64(3),
    }
    text = script_json(data)
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == {
        "<b>": "</script><!-- & \u2028 '\"",
        "surface": [[1.0, None], [None, 123456.789]],
        "count": 3,
    }
    assert json.loads(script_json(data, digits=3))["surface"][1] == [None, 123000.0]


@pytest.fixture
def result(work: Path) -> Iterator[Path]:
    """The result of the work folder, put back afterwards."""
    path = work / "result.json"
    text = path.read_text()
    yield path
    path.write_text(text)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("parameters", {"friction": "many"}),
        ("parameters", {"fiction": 0.4}),
        ("parameters", 3),
        ("responses", {}),
        ("responses", {"angle": {"target": 36}}),
        ("runs", {"design": None}),
        ("notices", [{"a": 1}]),
        ("out_of_reach", ["friction"]),
        ("wall_seconds", None),
    ],
)
def test_a_result_that_was_edited_is_no_answer(result: Path, key: str, value: object) -> None:
    result.write_text(json.dumps({**json.loads(result.read_text()), key: value}))
    reading = SavedCalibration.open(result.parent)
    assert reading.result is None
    page = render_page(ReportContext(reading, Analysis()))
    assert "result.json&#39; is damaged: " in page


def test_the_report_can_be_written_while_it_is_running(work: Path, tmp_path: Path) -> None:
    work = shutil.copytree(work, tmp_path / "work")
    with closing(sqlite3.connect(work / "runs.sqlite")) as store, store:
        store.execute("UPDATE calibrations SET status = 'running'")
    before = {path: path.stat().st_mtime_ns for path in work.rglob("*") if path.is_file()}
    said: list[str] = []
    with hold(work):
        path = grainfit.write_report(work, tmp_path / "half way.html", on_progress=said.append)
    assert verdict_messages.RUNNING() in path.read_text(encoding="utf-8")
    assert len(said) > 2
    changed = {path for path, time in before.items() if path.stat().st_mtime_ns != time}
    assert {path.name for path in changed} <= {"lock", "runs.sqlite-shm"}


def test_another_command_in_its_folder_does_not_make_it_running(work: Path) -> None:
    with hold(work):
        reading = SavedCalibration.open(work)
    assert (reading.state, reading.running) == ("calibrated", 0)
    assert reading.result is not None


def test_a_place_that_cannot_be_written_is_named(work: Path, tmp_path: Path) -> None:
    taken = tmp_path / "taken.html"
    taken.mkdir()
    for output in (taken, tmp_path / "nowhere" / "report.html"):
        with pytest.raises(StoreError, match=messages.CANNOT_BE_WRITTEN.pattern):
            grainfit.write_report(work, output)
    assert [path.name for path in tmp_path.iterdir()] == ["taken.html"]
