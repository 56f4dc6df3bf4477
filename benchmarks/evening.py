"""An engineer's evening in a browser: from nothing to cards and the customer's sheet.

Polypropylene granulate with a bucket of 200 mm, a funnel, a stop watch and a phone is entered into
the page of `grainfit start`, calibrated, and handed over; no line of a file is written. The angle
comes from photographs, given to the page: three rendered heaps with the marker sheet before them.
Every step is timed and pictured on a laptop, in a narrow window and on a phone, light and dark, and
is checked for console errors and by axe:

    python -m benchmarks.evening FOLDER [--grainfit PATH] [--until-start]

FOLDER must be empty. PATH is the command of another installation, such as one on a bare machine.
With --until-start it ends where the calibration could begin.
"""

from __future__ import annotations

import argparse
import itertools
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from playwright.sync_api import Page, expect

from benchmarks import chromium
from benchmarks.axe import violations
from grainfit.photographs import marker
from tests.photographs.drawn_pictures import cone
from tests.photographs.rendered_pictures import Shot, save, true_angle
from tests.photographs.test_marker import _printed

_WIDE = {"width": 1400, "height": 900}
_WINDOWS = {"1400": _WIDE, "1100": {"width": 1100, "height": 800}} | {
    "390": {"width": 390, "height": 844}
}
#: What was measured: of a material whose mass flow and angle examples/real_apparatus has.
_MATERIAL = (("Which material", "polypropylene pellets"), ("How large are the particles", "4 mm"))
_AT_HAND = ("or box with a hole", "funnel", "scale", "stop watch", "phone or camera")
_TESTS = ("discharge", "funnel")
_VALUES = (
    ("Orifice diameter", "50 mm"),
    ("Width", "200 mm"),
    ("Fill height", "200 mm"),
    ("Mass flow, measured", "0.34; 0.35; 0.345 kg/s ± 3 %"),
    ("Outlet diameter", "30 mm"),
)
#: Of the photographed heaps: angle, height in particles, particles over those of `cone`; degrees by
#: which the camera is above the table, and rolled.
_ANGLE, _HEIGHT, _SCALE = 27.0, 18.0, 0.4
_CAMERAS = ((8.0, 1.0), (11.0, -1.5), (9.0, 0.5))
#: Longest time of the calibration, s.
_LONGEST = 3600
_CARDS = ("LIGGGHTS", "EDEM")


class Evening:
    """A page, and what is noted of each of its states."""

    def __init__(self, page: Page, folder: Path) -> None:
        self.page, self._folder = page, folder
        self.faults: list[str] = []
        self._begun = time.monotonic()
        self._count = itertools.count(1)
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("console", self._hear)

    def _hear(self, said: object) -> None:
        if getattr(said, "type", "") == "error":
            self.faults.append(f"console: {getattr(said, 'text', '')}")

    def note(self, step: str, page: Page | None = None) -> None:
        """Picture a step in all windows, light and dark, and print when it was done."""
        page = page or self.page
        spent = time.monotonic() - self._begun
        number = next(self._count)
        for scheme, (name, size) in itertools.product(("light", "dark"), _WINDOWS.items()):
            page.set_viewport_size(size)
            page.emulate_media(color_scheme=scheme)
            page.screenshot(path=self._folder / f"{number}_{name}_{scheme}.png", full_page=True)
            found = violations(page)
            self.faults += [f"{step}, {name}, {scheme}: {one}" for one in found]
        page.set_viewport_size(_WIDE)
        page.emulate_media(color_scheme="light")
        print(f"{spent / 60:5.1f} min  {step}", flush=True)

    def answer(self, label: str, given: str) -> None:
        """Type an answer, and wait until it is kept."""
        field = self.page.get_by_label(label, exact=False).first
        field.fill(given)
        field.press("Tab")
        self.kept()

    def tick(self, label: str) -> None:
        """Tick an entry of a list."""
        self.page.get_by_label(label, exact=False).first.check()
        self.kept()

    def add_pictures(self, paths: list[Path]) -> None:
        """Give photographs to the page, and print what it says of them."""
        self.page.get_by_label("Add pictures").set_input_files(paths)
        shown = self.page.locator(".pictures img")
        expect(shown).to_have_count(len(paths))
        self.kept()
        for number in range(len(paths)):
            expect(shown.nth(number)).to_have_js_property("complete", True)
            assert shown.nth(number).evaluate("one => one.naturalWidth") > 0
        print(self.page.locator(".question:has(.pictures) .implies").inner_text())

    def kept(self) -> None:
        """Wait until an answer is in the file."""
        expect(self.page.locator("#saved")).to_have_text("Kept in the file")
        self.page.wait_for_timeout(300)


@contextmanager
def started(command: list[str], folder: Path) -> Iterator[str]:
    """Run `grainfit start` in a folder, and give the address of its page."""
    process = subprocess.Popen(
        [*command, "start", "granulate.toml", "--no-open"],
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        yield process.stdout.readline().split()[-1]
    finally:
        process.terminate()
        process.wait()


def photographed(folder: Path) -> list[Path]:
    """Render a picture of each of three heaps with the marker sheet before it."""
    sheet = _printed()
    sheet = replace(sheet, corner=(sheet.corner[0], -0.36 - marker.HEIGHT / 2, 0.0005))
    folder.mkdir()
    paths = []
    for number, (elevation, roll) in enumerate(_CAMERAS, 1):
        heap = cone(_ANGLE, _HEIGHT, number)
        shot = Shot(
            replace(heap, positions=_SCALE * heap.positions, radii=_SCALE * heap.radii),
            elevation=elevation,
            roll=roll,
            distance=0.9,
            size=(1600, 1200),
            aim=(0.0, -0.05),
            sheet=sheet,
            seed=number,
        )
        paths.append(folder / f"heap_{number}.jpg")
        save(shot, paths[-1], exif=True)
        print(f"heap {number}: {true_angle(shot):.2f}° from this side")
    return paths


def entered(evening: Evening, pictures: list[Path]) -> None:
    """Enter the material, what is at hand, the tests and what was measured."""
    for label, given in _MATERIAL:
        evening.answer(label, given)
    evening.note("material entered")
    for name in _AT_HAND:
        evening.tick(name)
    for name in _TESTS:
        evening.tick(f"{name}:")
    evening.page.get_by_label("Orifice:").select_option("round")
    evening.kept()
    evening.note("tests chosen")
    for label, given in _VALUES:
        evening.answer(label, given)
    evening.add_pictures(pictures)
    evening.note("photographs measured")
    evening.page.get_by_label("How large are the simulated apparatus?").select_option("1500")
    evening.kept()
    expect(evening.page.locator("#plan")).to_contain_text("DEM runs")
    evening.note("measurements entered, cost and forecast known")


def calibrated(evening: Evening) -> None:
    """Start, look at the page that follows, and wait for the end."""
    evening.page.get_by_role("button", name="Start the calibration").click()
    with evening.page.expect_popup() as followed:
        evening.page.locator("#watch").click()
    followed.value.wait_for_timeout(60_000)
    evening.note("calibration under way", followed.value)
    ended = evening.page.locator("#followed")
    expect(ended).to_contain_text("It has ended", timeout=1000 * _LONGEST)
    evening.note("calibration ended")
    print(ended.inner_text())
    evening.note("page of the calibration", followed.value)


def handed_over(evening: Evening, folder: Path) -> None:
    """Fetch cards and sheet."""
    for name in (*_CARDS, "PDF"):
        with evening.page.expect_download() as handed:
            evening.page.get_by_role("link", name=name).first.click()
        handed.value.save_as(folder / handed.value.suggested_filename)
    evening.note(f"handed over: {', '.join(_CARDS)}, sheet")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--grainfit", help="command of another installation")
    parser.add_argument("--until-start", action="store_true", help="do not start the calibration")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    if any(given.folder.iterdir()):
        parser.error(f"{given.folder} is not empty")
    command = [given.grainfit] if given.grainfit else [sys.executable, "-m", "grainfit"]
    expect.set_options(timeout=60_000)
    pictures = photographed(given.folder / "phone")
    with started(command, given.folder) as address, chromium.browser() as browser:
        page = browser.new_page(viewport=_WIDE)
        evening = Evening(page, given.folder)
        page.goto(address)
        evening.note("page open")
        entered(evening, pictures)
        if not given.until_start:
            calibrated(evening)
            handed_over(evening, given.folder)
    print(f"{len(evening.faults)} console errors and violations")
    print("\n".join(evening.faults))


if __name__ == "__main__":
    main()
