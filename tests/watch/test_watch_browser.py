"""The page as people have it: in Chromium, beside a calibration that runs."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect
from watched_runs import NAME, address, calibration, go, run, served, wait_for

import grainfit as gf
import needs
from benchmarks import campaigns, chromium
from benchmarks.axe import violations
from grainfit.bulk_tests.heap import Heap
from grainfit.calibration.live_file import LIVE_NAME
from grainfit.materials.sizes import ParticleSizes
from grainfit.report import verdict_messages
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.watch import drawings

pytestmark = needs.CHROMIUM
# Chromium, solvers and metamodels share a few cores.
expect.set_options(timeout=60_000)
LAPTOP, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}

BEADS = Path(__file__).parents[2] / "docs" / "recorded" / "beads"
#: Tables with more columns than can be seen.
CUT = """() => [...document.querySelectorAll(".table-wrap")].filter(
    (one) => one.scrollWidth > one.clientWidth
).map((one) => one.innerText)"""
#: Share of the newest drawing that is not empty.
PAINTED = """() => {
    const canvas = document.querySelector("#drawings canvas");
    const { width, height } = canvas;
    const data = canvas.getContext("2d").getImageData(0, 0, width, height).data;
    let painted = 0;
    for (let i = 3; i < data.length; i += 4) painted += data[i] > 0;
    return painted / (width * height);
}"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium.browser() as started:
        yield started


@contextmanager
def opened(browser: Browser, at: str) -> Iterator[tuple[Page, list[str]]]:
    """Open a page, and note what happens on it that should not."""
    context = browser.new_context(viewport=LAPTOP, reduced_motion="reduce")
    page, faults = context.new_page(), []

    def note(message: Any) -> None:
        # A server that has ended is no fault of the page.
        if message.type in ("error", "warning") and "ERR_CONNECTION" not in message.text:
            faults.append(message.text)

    page.on("console", note)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("dialog", lambda dialog: faults.append(dialog.message))
    page.on(
        "request",
        lambda request: (
            None
            if request.url.startswith((at.rpartition("/")[0], "data:"))
            else faults.append(request.url)
        ),
    )
    try:
        page.goto(at, wait_until="domcontentloaded")
        yield page, faults
    finally:
        context.close()


def test_the_page_follows_a_run_to_its_verdict(browser: Browser, tmp_path: Path) -> None:
    file = calibration(tmp_path, breaks=0.5)
    with run(file, "--watch") as process, opened(browser, address(file)) as (page, faults):
        expect(page.locator("#name")).to_have_text(NAME)
        expect(page.locator("#verdict .verdict-line")).to_contain_text("Running")
        expect(page.locator("#runs tbody tr")).to_have_count(2)
        expect(page.locator("#runs tbody tr").first).to_contain_text(re.compile(r"running.*\d s"))
        expect(page.locator("#connection")).to_have_text("Live")
        expect(page.locator("#failures")).to_be_hidden()
        assert violations(page) == []
        page.set_viewport_size(PHONE)
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
        assert violations(page) == []
        page.set_viewport_size(LAPTOP)
        go(tmp_path)
        expect(page.locator(".verdict.good .verdict-line")).to_contain_text("Calibrated")
        expect(page.locator("#responses tbody tr")).to_contain_text("✓ met")
        expect(page.locator("#parameters tbody tr")).to_contain_text("determined")
        expect(page.locator("#failures .watch-failure").first).to_contain_text("exit code 3")
        page.locator("#failures summary").first.click()
        expect(page.locator("#failures pre").first).to_contain_text("the drum <i>broke</i>")
        assert process.wait(60) == 0
        expect(page.locator("#connection")).to_contain_text("The run has ended")
        expect(page.locator("#stop")).to_be_hidden()
        assert page.title().startswith("✓ calibrated")
        for scheme in ("dark", "light"):
            page.emulate_media(color_scheme=scheme)
            assert violations(page) == []
        page.set_viewport_size(PHONE)
        assert violations(page) == []
        assert faults == []
    # The page is gone with its run.
    wait_for(lambda: not _is_served(browser, address(file)), 20)


def _is_served(browser: Browser, at: str) -> bool:
    with browser.new_context() as context:
        try:
            return context.request.get(at).ok
        except Exception:
            return False


def test_the_stop_button_does_what_ctrl_c_does(browser: Browser, tmp_path: Path) -> None:
    file = calibration(tmp_path)
    work = tmp_path / "sand.grainfit"
    with run(file) as process:
        wait_for((work / LIVE_NAME).exists)
        with served(work) as server, opened(browser, server.address) as (page, faults):
            page.get_by_role("button", name="Stop").click()
            assert violations(page) == []
            page.get_by_role("button", name="Let it run").click()
            expect(page.get_by_role("dialog")).to_be_hidden()
            assert process.poll() is None
            page.get_by_role("button", name="Stop").click()
            page.get_by_role("button", name="Stop it").click()
            assert process.wait(60) == 130
            expect(page.locator("#verdict .verdict-line")).to_contain_text("Interrupted.")
            expect(page.locator("#connection")).to_have_text("Nothing is running")
            assert faults == []
    go(tmp_path)
    with run(file) as again:
        assert again.wait(60) == 0


def test_what_cannot_be_stopped_says_why(browser: Browser, tmp_path: Path) -> None:
    file = calibration(tmp_path)
    work = tmp_path / "sand.grainfit"
    with run(file):
        wait_for((work / LIVE_NAME).exists)
        with served(work) as server, opened(browser, server.address) as (page, _):
            stop = page.get_by_role("button", name="Stop")
            expect(stop).to_be_enabled()
            lock = work / "lock"
            signature = lock.read_text()
            stop.click()
            confirm = page.get_by_role("button", name="Stop it")
            expect(confirm).to_be_enabled()
            lock.write_text("1 another-host boot\n")
            # At once, before the page hears of it: the server refuses it, in words.
            confirm.click()
            expect(page.locator("#stop-reason")).to_contain_text("Stop it on another-host")
            lock.write_text(signature)


def test_names_are_text_on_a_laptop_and_a_phone(browser: Browser, tmp_path: Path) -> None:
    with (
        campaigns.campaign("nasty_names", tmp_path),
        served(tmp_path) as server,
        opened(browser, server.address) as (page, faults),
    ):
        expect(page.locator("#name")).to_have_text(campaigns.NASTY_CALIBRATION)
        text = page.locator("main").inner_text()
        for name in (*campaigns.NASTY_PARAMETERS, *campaigns.NASTY_RESPONSES):
            assert name in text
        assert campaigns.NASTY_REASON in text
        assert page.evaluate("window.executed") is None
        for size in (LAPTOP, PHONE):
            page.set_viewport_size(size)
            assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
            assert violations(page) == []
        assert faults == []


def test_no_column_is_cut_off_in_a_window_of_any_width(browser: Browser) -> None:
    with served(BEADS) as server, opened(browser, server.address) as (page, faults):
        expect(page.locator("#parameters")).to_contain_text("rolling friction coefficient")
        for width in (1100, 700, 390):
            page.set_viewport_size({"width": width, "height": 800})
            assert page.evaluate(CUT) == []
        assert faults == []


def test_a_folder_that_is_deleted_leaves_no_drawing(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    about = {"key": "photographs", "kind": "page", "run": "1", "title": "Newest heap", "words": ""}
    drawing = drawings.LatestDrawing(about, json.dumps("<p>angle of repose</p>"))
    monkeypatch.setattr(drawings, "_photographs", lambda _: drawing)
    work = tmp_path / "work"
    shutil.copytree(BEADS, work)
    with served(work) as server, opened(browser, server.address) as (page, _):
        expect(page.locator("#drawings h2")).not_to_have_count(0)
        shutil.rmtree(work)
        expect(page.locator("#verdict")).to_contain_text(verdict_messages.NOTHING_THERE())
        expect(page.locator("#drawings section")).to_have_count(0)


@pytest.mark.slow
def test_the_newest_heap_is_drawn_as_it_comes_in(browser: Browser, tmp_path: Path) -> None:
    heap = Heap(
        ParticleSizes((0.010,)),
        cylinder_radius=0.04,
        strike_off_height=0.08,
        bulk_density_top=0.07,
        plate_radius=0.12,
        **ROUGH_PLATE,
    )
    fixed = {name: v for name, v in GLASS_BEADS.items() if name != "particle.density"}
    problem = gf.Problem(
        [gf.Parameter("particle.density", 1400.0, 2800.0)],
        [gf.Target("bulk_density", 1200.0, uncertainty=20.0)],
    )
    work = tmp_path / "work"
    with ThreadPoolExecutor(1) as threads:
        # A busy machine opens the page late, and runs must be left then.
        ended = threads.submit(
            gf.calibrate, problem, Lammps(heap, fixed), workdir=work, max_runs=10, workers=1
        )
        wait_for((work / LIVE_NAME).exists)
        with served(work) as server, opened(browser, server.address) as (page, faults):
            drawn = page.locator("#drawings canvas")
            expect(drawn).to_be_visible()
            expect(page.locator("#drawings h2")).to_have_text("Newest heap")
            first = page.locator("#drawings p").first.inner_text()
            drawn.focus()
            page.keyboard.press("ArrowLeft")
            page.keyboard.press("+")
            expect(page.locator("#drawings p").first).not_to_have_text(first)
            assert page.evaluate(PAINTED) > 0.05
            assert violations(page) == []
            assert ended.result(120).runs.failed == 0
            assert faults == []
