"""Photographs beside simulated heaps and drums, in the report and on the watch page."""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Mapping
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
import needs
from benchmarks import chromium
from benchmarks.axe import violations
from grainfit.analysis.analysis import Analysis
from grainfit.calibration_file.originals import keep_pictures
from grainfit.local_pages.server import listen
from grainfit.measurement.particles import Particles
from grainfit.photographs.kept_list import LIST_NAME
from grainfit.report.section import ReportContext
from grainfit.report.sections.photographs.comparison import Comparison, compared
from grainfit.report.sections.photographs.section import photographs
from grainfit.scenes.run_output import RunOutput
from grainfit.watch.drawings import LatestDrawings
from grainfit.watch.server import WatchServer
from tests.photographs.drawn_pictures import heap
from tests.photographs.photographed_heap import ANGLE, PROFILE, load

FRICTION = "particle_particle.sliding_friction"


class Poured(gf.solvers.Solver):
    """Heaps of beads that are placed and not simulated: steeper with more friction."""

    name = "placed"

    def __init__(self, height: float) -> None:
        self.test = gf.tests.Heap(diameter="10 mm", plate_radius="310 mm", views=6)
        self.height = height

    @property
    def response_names(self) -> tuple[str, ...] | None:
        return self.test.response_names

    @property
    def bulk_test(self) -> gf.tests.Heap:
        return self.test

    def model(self) -> Mapping[str, Any]:
        return {"solver": self.name, "height": self.height, "test": self.test.definition()}

    def run(self, parameters: Mapping[str, float], seed: int, workspace: Any) -> dict[str, Any]:
        write_heap(workspace.folder, heap(17 + 16 * parameters[FRICTION], self.height, seed))
        return dict(self.test.view(RunOutput(workspace.folder)).measure(workspace.folder / "a.png"))


def write_heap(folder: Path, particles: Particles) -> None:
    rows = "".join(
        f"{i} {x} {y} {z} {radius} 0.001\n"
        for i, ((x, y, z), radius) in enumerate(
            zip(particles.positions.tolist(), particles.radii.tolist(), strict=True), 1
        )
    )
    (folder / "snapshots").mkdir()
    (folder / "snapshots/heap.dump").write_text(
        f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(particles)}\nITEM: BOX BOUNDS ff ff ff\n"
        f"0 1\n0 1\n0 1\nITEM: ATOMS id x y z radius mass\n{rows}"
    )


def calibrated(folder: Path, targets: str, height: float = 10.0) -> Path:
    """Calibrate on the pictures of a folder, for a few runs."""
    setup = load(folder, targets)
    work = folder / "work"
    keep_pictures(setup.file.photographed, work, folder)
    gf.calibrate(setup.problem, Poured(height), workdir=work, max_runs=7, seed=1, workers=1)
    return work


@pytest.fixture(scope="module")
def of_profile(measured: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A work folder, within a folder with the originals."""
    folder = tmp_path_factory.mktemp("profile") / "copy"
    return calibrated(Path(shutil.copytree(measured, folder)), ANGLE + PROFILE)


@pytest.fixture
def work(of_profile: Path, tmp_path: Path) -> Path:
    """A copy of that folder: both have moved together."""
    return Path(shutil.copytree(of_profile.parent, tmp_path / "moved")) / "work"


def shown(work: Path) -> str:
    """Return the section as it is read."""
    section = photographs(ReportContext(gf.open(work), Analysis()))
    assert section is not None
    return " ".join(unescape(re.sub(r"<[^>]*>", " ", str(section.html))).split())


def the_comparison(work: Path) -> Comparison:
    (found,) = compared(gf.open(work))
    return found


def points(path: str) -> np.ndarray[Any, Any]:
    """Return the points of an SVG path, heights upwards."""
    pairs = re.findall(r"(-?[\d.]+),(-?[\d.]+)", path)
    return np.array(pairs, dtype=float) * [1, -1]


def test_photograph_and_simulated_heap_are_at_one_scale(work: Path) -> None:
    found = the_comparison(work)

    unit = found.chosen.frame.unit
    run = gf.open(work).records[found.run]
    simulated, outline = points(found.outline) * unit, points(found.chosen.measured) * unit
    # The apex of the response, and that of the target.
    assert simulated[:, 1].max() == pytest.approx(run.responses["profile"].values[0], abs=0.002)
    curve = gf.open(work).problem.curves[0]
    assert outline[:, 1].max() == pytest.approx(max(curve.values), rel=0.05)
    # The silhouette is that heap: its highest particle and its foot.
    assert found.drawing is not None
    silhouette = points(found.drawing.path) * found.drawing.pixel_size
    assert silhouette[:, 1].max() == pytest.approx(simulated[:, 1].max(), abs=0.01)
    for distance in (-0.08, 0.08):
        heights = [np.interp(distance, *one.T) for one in (silhouette, simulated)]
        assert heights[0] == pytest.approx(heights[1], abs=0.01)
    # Heaps of one height and nearly one angle.
    assert not found.is_scaled
    assert all(float(one.apart.removesuffix(" mm")) < 15 for one in found.pictures)


def test_the_run_at_the_answer_stands_beside_every_picture(work: Path) -> None:
    words, saved = shown(work), gf.open(work)

    assert re.search(r"Photographs, angle of repose: 2[3-6]\.\d+ ± 0\.\d+°; pictures: 2", words)
    assert "heap_1.jpg" in words
    assert "heap_2.jpg" in words
    found = the_comparison(work)
    assert saved.records[found.run].responses["angle_of_repose"].value == pytest.approx(25, abs=2)
    assert all(one.image.startswith("data:image/jpeg;base64,") for one in found.pictures)
    assert all(one.simulated for one in found.pictures)


def test_changed_and_missing_originals_are_named_and_the_copies_shown(work: Path) -> None:
    assert "Changed since" not in shown(work)
    assert "any more" not in shown(work)

    (work.parent / "heap_1.jpg").write_bytes((work.parent / "heap_2.jpg").read_bytes())
    (work.parent / "heap_2.jpg").unlink()
    words = shown(work)
    assert "Changed since it was measured: heap_1.jpg." in words
    assert "Not in its place any more: heap_2.jpg." in words
    assert all(one.image for one in the_comparison(work).pictures)


def test_the_report_needs_neither_opencv_nor_the_copies_nor_the_particles(
    work: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    for path in [*(work / "photographs").glob("*.jpg"), *work.glob("runs/*/snapshots/*")]:
        path.unlink()

    words = shown(work)
    assert "whose copy is gone" in words
    assert "particles were not kept" in words
    found = the_comparison(work)
    assert found.outline
    assert found.chosen.measured
    page = gf.open(work).report(work / "report.html").read_text(encoding="utf-8")
    assert 'id="photographs"' in page


def test_a_damaged_list_costs_no_report(work: Path) -> None:
    path = work / "photographs" / LIST_NAME
    whole = json.loads(path.read_text())
    del whole["targets"][0]["pictures"][0]["outline"]
    path.write_text(json.dumps(whole))
    (result,) = the_comparison(work).results
    assert "profile" in result
    path.write_text("{")
    assert photographs(ReportContext(gf.open(work), Analysis())) is None


def test_heaps_of_other_sizes_are_compared_by_their_slopes(measured: Path, tmp_path: Path) -> None:
    work = calibrated(Path(shutil.copytree(measured, tmp_path / "copy")), ANGLE, height=6.0)

    found = the_comparison(work)
    assert float(found.relative_size) == pytest.approx(0.6, abs=0.06)
    assert found.is_scaled
    beside, over = (points(path)[:, 1].max() for path in (found.outline, found.chosen.measured))
    assert beside < 0.7 * over
    for one in found.pictures:
        assert points(one.simulated)[:, 1].max() == pytest.approx(
            points(one.measured)[:, 1].max(), rel=0.1
        )
        assert not one.apart
    assert "compare the slopes, not the sizes" in shown(work)


def test_the_watch_page_has_them_and_follows_newer_runs(work: Path) -> None:
    latest, saved = LatestDrawings(), gf.open(work)
    latest.update(saved)
    first = latest.found(saved.identity)["photographs"]
    assert "drawn-target" in json.loads(first.content)
    latest.update(saved)
    assert latest.found(saved.identity)["photographs"] is first

    # Of an earlier moment, another run was the best.
    earlier = LatestDrawings()
    earlier.update(
        type(saved)(**{**vars(saved), "evaluations": saved.evaluations[:1], "result": None})
    )
    found = earlier.found(saved.identity)["photographs"]
    assert found.about["run"] != first.about["run"]


@needs.CHROMIUM
def test_the_watch_page_shows_them_on_a_phone(work: Path) -> None:
    server = WatchServer(work, listen(0))
    server.serve()
    faults: list[str] = []
    try:
        with chromium.browser() as browser:
            page = browser.new_page(viewport={"width": 390, "height": 844})
            page.on("console", lambda message: faults.append(message.text))
            page.on("pageerror", lambda error: faults.append(str(error)))
            page.goto(server.address, wait_until="domcontentloaded")
            page.locator(".photographs figure").nth(1).wait_for(timeout=60_000)

            assert page.evaluate("document.documentElement.scrollWidth") <= 390
            first, second = (
                page.locator(".cards .photograph-drawing").nth(i).bounding_box() for i in (0, 1)
            )
            assert first is not None
            assert second is not None
            assert first["width"] == second["width"]
            assert violations(page) == []
    finally:
        server.follower.end()
        server.shutdown()
        server.server_close()
    assert faults == []
