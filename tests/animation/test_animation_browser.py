"""The page of an animation as people have it: in a browser that is not connected to anything."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page, expect

import needs
from benchmarks import chromium
from grainfit.scenes.shapes import Block
from tests.animation.animated_runs import made_up, moving, page_of, turning

pytestmark = needs.CHROMIUM
LAPTOP = {"width": 1366, "height": 768}
PHONE = {"width": 390, "height": 844}
#: The picture of now, once it is drawn.
PICTURE = """() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(
    () => done(document.getElementById("film").toDataURL()))))"""
#: Play until a stage begins, then pause, at once: no processor is slow enough to miss it.
PLAY_UNTIL = """(stage) => new Promise((done) => {
    const button = document.getElementById("film-play");
    button.click();
    const during = button.textContent;
    const look = () => {
        if (document.getElementById("film-stage").textContent !== stage) {
            requestAnimationFrame(look);
            return;
        }
        button.click();
        done(during);
    };
    look();
})"""
#: What sticks out of the page, and controls without a name.
CUT = """() => [...document.querySelectorAll("main *")].filter(
    (one) => one.getBoundingClientRect().right > document.documentElement.clientWidth + 1
).map((one) => one.outerHTML.slice(0, 100))"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium.browser() as started:
        yield started


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return page_of(
        made_up(tmp_path_factory.mktemp("run"), moving()), moving(), failure="it slipped"
    )


@contextmanager
def opened(
    browser: Browser, path: Path, motion: str = "reduce", size: dict[str, int] = LAPTOP
) -> Iterator[Page]:
    """Open a page; nothing on it may go wrong, or ask for anything."""
    context = browser.new_context(viewport=size, reduced_motion=motion, offline=True)
    page, faults = context.new_page(), []
    # The tests themselves read pixels.
    page.on("console", lambda m: None if "getImageData" in m.text else faults.append(m.text))
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on(
        "request",
        lambda r: None if r.url.startswith(("file:", "data:")) else faults.append(r.url),
    )
    page.goto(path.as_uri())
    try:
        yield page
        assert faults == []
    finally:
        context.close()


def test_playing_changes_the_picture_until_the_end(browser: Browser, path: Path) -> None:
    with opened(browser, path) as page:
        time, stage = page.locator("#film-time"), page.locator("#film-stage")
        # With reduced motion, nothing moves before it is asked for.
        expect(time).to_have_text("0.000 s")
        before = page.evaluate(PICTURE)
        page.wait_for_timeout(300)
        assert page.evaluate(PICTURE) == before

        page.get_by_label("Speed").select_option(index=4)
        assert page.evaluate(PLAY_UNTIL, "close") == "Pause"
        expect(page.get_by_role("button", name="Play")).to_be_visible()
        assert page.evaluate(PICTURE) != before
        stopped = time.inner_text()
        page.wait_for_timeout(300)
        expect(time).to_have_text(stopped)
        assert stopped != "0.200 s"

        page.get_by_role("button", name="Play").click()
        expect(time).to_have_text("0.200 s", timeout=20_000)
        expect(page.get_by_role("button", name="Play")).to_be_visible()
        expect(stage).to_have_text("push")
        expect(page.get_by_text("This run failed: it slipped")).to_be_visible()


def test_it_plays_by_itself_where_motion_is_welcome(browser: Browser, path: Path) -> None:
    with opened(browser, path, motion="no-preference") as page:
        expect(page.locator("#film-time")).not_to_have_text("0.000 s")


def test_keys_slider_and_stages_go_to_frames(browser: Browser, path: Path) -> None:
    with opened(browser, path) as page:
        time, keyboard = page.locator("#film-time"), page.keyboard
        for key, expected in (
            *((".", "0.005 s"), (".", "0.010 s"), (",", "0.005 s"), ("End", "0.200 s")),
            *((".", "0.200 s"), ("Home", "0.000 s"), (",", "0.000 s")),
        ):
            keyboard.press(key)
            expect(time).to_have_text(expected)
        page.get_by_label("One frame on").click()
        page.get_by_label("One frame on").click()
        page.get_by_label("One frame back").click()
        expect(time).to_have_text("0.005 s")
        page.get_by_label("Go to the stage wait").click()
        expect(time).to_have_text("0.135 s")
        expect(page.locator("#film-stages li[aria-current=step]")).to_contain_text("wait")

        slider = page.get_by_role("slider", name="Frame")
        slider.fill("12")
        expect(time).to_have_text("0.060 s")
        assert slider.get_attribute("aria-valuetext") == "0.060 s, close"
        # Slow enough for a busy machine to see it play.
        page.get_by_label("Speed").select_option(index=0)
        page.locator("#film").focus()
        keyboard.press(" ")
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        keyboard.press(" ")
        expect(page.get_by_role("button", name="Play")).to_be_visible()
        # A button is pressed by the key once, not twice.
        page.locator("#film-play").focus()
        keyboard.press(" ")
        expect(page.get_by_role("button", name="Pause")).to_be_visible()


def test_walls_come_move_and_go_and_the_view_turns(browser: Browser, path: Path) -> None:
    with opened(browser, path) as page:

        def at(frame: int) -> str:
            page.get_by_role("slider", name="Frame").fill(str(frame))
            picture: str = page.evaluate(PICTURE)
            return picture

        #: Share of pixels in the vermilion of walls that move.
        share = """() => {
            const canvas = document.getElementById("film");
            const { width, height } = canvas;
            const data = canvas.getContext("2d").getImageData(0, 0, width, height).data;
            let red = 0;
            for (let i = 0; i < data.length; i += 4) red += data[i] > data[i + 2] + 90;
            return red / (width * height);
        }"""
        at(0)
        without = page.evaluate(share)
        at(10)
        with_lid = page.evaluate(share)
        assert with_lid > without + 0.02
        at(35)
        assert page.evaluate(share) == pytest.approx(without, abs=0.01)
        block = at(35)
        assert at(40) != block

        page.locator("#film").focus()
        before = page.evaluate(PICTURE)
        page.keyboard.press("ArrowRight")
        turned = page.evaluate(PICTURE)
        assert turned != before
        page.locator("#film").dblclick()
        assert page.evaluate(PICTURE) == before
        # Turning is no stepping.
        expect(page.locator("#film-time")).to_have_text("0.200 s")


def test_a_wall_that_turns_does_so_by_the_right_hand(browser: Browser, tmp_path: Path) -> None:
    east = Block((0.04, 0.0, 0.0), (0.09, 0.03, 0.05))
    north = Block((-0.03, 0.04, 0.0), (0.0, 0.09, 0.05))
    seen = []
    for name, scene in {
        "turned": turning(math.pi / 2, east),
        "there": turning(1e-9, north),
        "before": turning(1e-9, east),
    }.items():
        page_path = page_of(made_up(tmp_path / name, scene), scene)
        with opened(browser, page_path) as page:
            page.keyboard.press("End")
            page.evaluate(PICTURE)
            image = page.locator("#film").screenshot()
            seen.append(np.asarray(Image.open(BytesIO(image)).convert("RGB"), dtype=float))
    turned, there, before = seen

    def unlike(one: np.ndarray, other: np.ndarray) -> float:
        return float((np.abs(one - other).max(axis=-1) > 20).mean())

    assert unlike(turned, there) < 0.002
    assert unlike(turned, before) > 0.02


@pytest.mark.parametrize("size", [LAPTOP, PHONE])
def test_nothing_sticks_out_and_everything_has_a_name(
    browser: Browser, path: Path, size: dict[str, int]
) -> None:
    with opened(browser, path, size=size) as page:
        assert page.evaluate(CUT) == []
        controls = page.locator("button, input, select, canvas")
        for number in range(controls.count()):
            assert controls.nth(number).evaluate(
                "one => one.ariaLabel || one.innerText || one.labels?.[0]?.innerText"
            )
