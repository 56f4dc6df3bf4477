"""The report as people have it: in a browser that is not connected to anything."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page
from pypdfium2 import PdfDocument
from scipy.stats import norm

import needs
from benchmarks import campaigns, chromium
from benchmarks.axe import violations
from grainfit.analysis.analysis import Analysis, analyse
from grainfit.metamodels.metamodels import Metamodels
from grainfit.report.page import write_report

pytestmark = needs.CHROMIUM

SECTIONS = (
    "answer",
    "particles",
    "convergence",
    "surfaces",
    "explorer",
    "predicted",
    "sensitivity",
    "tradeoff",
    "undetermined",
    "verification",
    "runs",
    "reproduce",
)
#: Those that are opened just to see that they are whole.
#: Five parameters show what fourteen show; they have the test of the explorer.
STATES = (
    "one_parameter",
    pytest.param("fourteen_parameters", marks=pytest.mark.thorough),
    "no_run_finished",
    "running_half_way",
    "all_failed",
    "only_failures_yet",
    "unreachable",
    "undecided",
)
LAPTOP = {"width": 1366, "height": 768}
PHONE = {"width": 390, "height": 844}
#: Normal text on its background, by the Web Content Accessibility Guidelines.
CONTRAST = 4.5
UNFOLD = "document.querySelectorAll('details.folded').forEach((one) => { one.open = true; })"
MEGABYTE = 1_000_000

#: All that is read on the page: its text as it is seen, and that of the figures.
READ = """() => [
    document.body.innerText,
    ...[...document.querySelectorAll("svg text")].map((text) => text.textContent),
].join("\\n")"""

#: Texts that hardly differ from what is behind them, with their contrast.
FAINT = """(least) => {
    const canvas = document.createElement("canvas");
    const context = canvas.getContext("2d", { willReadFrequently: true });
    const laid = (colour, below) => {
        for (const style of [`rgb(${below})`, colour]) {
            context.fillStyle = style;
            context.fillRect(0, 0, 1, 1);
        }
        return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
    };
    const behind = (element) => element
        ? laid(getComputedStyle(element).backgroundColor, behind(element.parentElement))
        : [255, 255, 255];
    const luminance = (colour) => {
        const [red, green, blue] = colour.map((value) => {
            const share = value / 255;
            return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
        });
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    };
    const faint = [];
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
        const element = texts.currentNode.parentElement;
        if (!texts.currentNode.data.trim() || !element.checkVisibility()) continue;
        if (element.closest("script, style, .contourlabels, .colorbar, .modebar")) continue;
        const style = getComputedStyle(element);
        const colour = element.closest("svg") ? style.fill : style.color;
        const background = behind(element);
        const [dark, light] = [luminance(background), luminance(laid(colour, background))]
            .sort((one, other) => one - other);
        const contrast = (light + 0.05) / (dark + 0.05);
        if (contrast < least) faint.push(`${texts.currentNode.data.trim()}: ${contrast}`);
    }
    return faint;
}"""


#: Figures that are wider than their places, and what sticks out of its section.
CUT = """() => {
    const right = (element) => Math.floor(element.getBoundingClientRect().right);
    const figures = [...document.querySelectorAll(".figure")]
        .filter((place) => right(place.querySelector(".main-svg")) > right(place) + 1);
    const parts = [...document.querySelectorAll("section:not(#runs) *")]
        .filter((part) => !part.closest("svg") && right(part) > right(part.closest("section")) + 1);
    return [...figures, ...parts].map((part) => part.outerHTML.slice(0, 100));
}"""


#: Controls and explanations that the keyboard does not come to.
UNREACHED = """() => {
    const words = (one) => one.dataset.explanation ?? one.title;
    const stops = "abbr[tabindex='0'], th[scope=row] abbr";
    const EXPLAINED = new Set([...document.querySelectorAll(stops)].map(words));
    return [
    ...document.querySelectorAll("a, abbr, button, input, select, summary, canvas.particles-3d"),
]
    .filter((one) => one.checkVisibility() && one.tabIndex < 0)
    .filter((one) => !one.closest(".modebar, button > *, label > *, summary > *"))
    // The arrow keys go on from the one stop of a row of equals.
    .filter((one) => !one.closest("[data-roving]")?.querySelector("[tabindex='0']"))
    // An explanation is a stop once; what the symbol of a row means stands beside it.
    .filter((one) => !one.closest("abbr") || !EXPLAINED.has(words(one)))
    .map((one) => one.outerHTML);
}"""

#: Number of stops of the tab key.
STOPS = """() => [...document.querySelectorAll("*")].filter(
    (one) => one.tabIndex >= 0 && !one.disabled && one.checkVisibility({ visibilityProperty: true })
).length"""

MOVE = """(sliders, place) => sliders.forEach((slider, i) => {
    slider.value = Number(slider.min) + place[i] * (slider.max - slider.min);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
})"""


@dataclass(frozen=True)
class Report:
    """A report and the metamodels that it rests on."""

    path: Path
    metamodels: Metamodels | None


@dataclass
class Opened:
    """A page and what happened on it that should not."""

    page: Page
    faults: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.page.on("console", self._note_console)
        self.page.on("pageerror", lambda error: self.faults.append(f"error: {error}"))
        self.page.on("dialog", self._note_dialog)
        self.page.on("request", self._note_request)

    def _note_console(self, message: Any) -> None:
        if message.type in ("error", "warning"):
            self.faults.append(f"{message.type}: {message.text}")

    def _note_dialog(self, dialog: Any) -> None:
        self.faults.append(f"dialog: {dialog.message}")
        dialog.dismiss()

    def _note_request(self, request: Any) -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            self.faults.append(f"request: {request.url}")


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium.browser() as started:
        yield started


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Report]:
    """Write the report of a campaign, once."""

    @cache
    def written(name: str) -> Report:
        analyses = []

        def analyse_and_tell(*arguments: Any, **options: Any) -> Analysis:
            analyses.append(analyse(*arguments, **options))
            return analyses[-1]

        with (
            campaigns.campaign(name, tmp_path_factory.mktemp(name)) as folder,
            pytest.MonkeyPatch.context() as patch,
        ):
            patch.setattr("grainfit.analysis.analysis.analyse", analyse_and_tell)
            return Report(write_report(folder), analyses[0].metamodels)

    return written


@contextmanager
def opened(browser: Browser, path: Path) -> Iterator[Opened]:
    context = browser.new_context(viewport=LAPTOP, offline=True, reduced_motion="reduce")
    try:
        found = Opened(context.new_page())
        found.page.goto(path.as_uri())
        yield found
    finally:
        context.close()


def comes_true(page: Page, condition: str) -> bool:
    """Wait until it is; Playwright's own way needs `eval`, which the page forbids."""
    deadline = time.monotonic() + 20
    while not page.evaluate(condition):
        if time.monotonic() > deadline:
            return False
        page.wait_for_timeout(200)
    return True


@pytest.fixture(scope="module")
def usual(browser: Browser, report: Callable[[str], Report]) -> Iterator[Opened]:
    """Open the report of the usual calibration, for tests that leave it as it was."""
    with opened(browser, report("two_parameters").path) as found:
        found.page.evaluate(UNFOLD)
        yield found


@pytest.mark.parametrize("name", STATES)
def test_a_report_is_whole_whatever_state_the_calibration_is_in(
    browser: Browser, report: Callable[[str], Report], name: str
) -> None:
    with opened(browser, report(name).path) as found:
        _require_whole(found)


def test_the_usual_report_is_whole_on_a_laptop_and_a_phone(
    usual: Opened, report: Callable[[str], Report]
) -> None:
    _require_whole(usual)
    _require_phone(usual.page)
    path = report("two_parameters").path
    assert path.stat().st_size < 4 * MEGABYTE
    notice = r"plotly\.js \(\w+ - minified\) v[\d.]+\s+\* Copyright"
    assert len(re.findall(notice, path.read_text(encoding="utf-8"))) == 1


def _require_whole(found: Opened) -> None:
    page = found.page
    # Before its drawings: with all of them, axe takes ten times as long, and finds the same.
    page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true")
    assert violations(page) == []
    assert page.evaluate(chromium.DRAW) == ""
    assert page.eval_on_selector_all("section", "all => all.map((one) => one.id)") == list(SECTIONS)
    empty = "all => all.filter((one) => one.innerText.trim().length < 30).map((one) => one.id)"
    assert page.eval_on_selector_all("section", empty) == []
    text = page.evaluate(READ)
    assert re.findall(r".*\b(?:NaN|undefined|None(?! of)|Infinity)\b.*", text) == []
    # Plotly would send figures to its cloud.
    assert page.locator(".modebar-btn[data-title*=Share]").count() == 0
    assert page.evaluate("document.documentElement.scrollWidth") <= LAPTOP["width"]
    assert found.faults == []


def _require_phone(page: Page) -> None:
    """It is not scrolled sideways, and the keyboard reaches what scrolls in it."""
    page.set_viewport_size(PHONE)
    width = page.evaluate("document.documentElement.scrollWidth")
    broken = violations(page)
    page.set_viewport_size(LAPTOP)
    assert width <= PHONE["width"]
    assert broken == []


def test_names_are_text_whatever_they_are(
    browser: Browser, report: Callable[[str], Report]
) -> None:
    names = (*campaigns.NASTY_PARAMETERS, *campaigns.NASTY_RESPONSES)
    with opened(browser, report("nasty_names").path) as found:
        _require_whole(found)
        page = found.page
        _require_phone(page)
        assert page.evaluate("window.executed") is None
        assert page.title().count(campaigns.NASTY_CALIBRATION) == 1
        texts = "all => all.map((one) => one.textContent.trim())"
        shown = page.eval_on_selector_all("main *", texts)
        assert [name for name in names if name not in shown] == []
        drawn = "\n".join(page.eval_on_selector_all(".main-svg text", texts))
        assert [name for name in names if name not in drawn] == []
        text = page.evaluate(READ)
        assert campaigns.NASTY_CALIBRATION in text
        assert campaigns.NASTY_FILE in text
        assert campaigns.NASTY_TEXT.strip() in text
        assert campaigns.NASTY_REASON in text


def test_the_explorer_predicts_what_the_metamodels_do(
    usual: Opened, browser: Browser, report: Callable[[str], Report]
) -> None:
    _require_same_predictions(usual.page, report("two_parameters").metamodels)
    with opened(browser, report("five_parameters").path) as found:
        _require_same_predictions(found.page, report("five_parameters").metamodels)
        _require_whole(found)


def _require_same_predictions(page: Page, metamodels: Metamodels | None) -> None:
    """Move the sliders to some places and compare what the page predicts with what Python does."""
    assert metamodels is not None
    problem = metamodels.problem
    assert comes_true(page, "!!document.querySelector('#explorer [data-mean]')")
    responses = page.locator("#explorer [data-response]")
    for place in np.random.default_rng(1).integers(0, 1001, (2, problem.dimension)) / 1000:
        page.eval_on_selector_all("#explorer input[type=range]", MOVE, place.tolist())
        means, variances = metamodels.predict(place)
        half_widths = norm.ppf(0.975) * np.sqrt(variances)
        shown = responses.evaluate_all(
            "all => all.map(({ dataset: { response, mean, halfWidth } }) =>"
            " [response, Number(mean), Number(halfWidth)])"
        )
        assert [name for name, _, _ in shown] == [target.name for target in problem.targets]
        assert [mean for _, mean, _ in shown] == pytest.approx(means[0], rel=1e-6)
        assert [half for _, _, half in shown] == pytest.approx(half_widths[0], rel=1e-6)


def test_the_table_of_runs_sorts_by_number_and_filters(usual: Opened) -> None:
    runs = usual.page.locator("#runs")
    header = runs.locator("thead th").filter(has_text="Deviation")
    column = 1 + header.evaluate("(header) => header.cellIndex")
    orders = []
    for _ in range(2):
        header.get_by_role("button").click()
        cells = runs.locator(f"tbody td:nth-child({column})").all_inner_texts()
        orders.append([float(cell) for cell in cells])
    assert len(set(orders[0])) > 5
    assert orders[0] == sorted(orders[0])
    assert orders[1] == orders[0][::-1]
    rows = runs.locator("tbody tr:visible")
    runs.get_by_role("searchbox").fill("VERIFI")
    assert {row.split("\t")[1] for row in rows.all_inner_texts()} == {"verification"}
    runs.get_by_role("searchbox").fill("")
    assert rows.count() == len(orders[0])
    runs.get_by_label("Outcome").select_option("failed")
    assert rows.count() == 0
    runs.get_by_label("Outcome").select_option("any")


def test_text_stands_out_from_what_is_behind_it(usual: Opened) -> None:
    page = usual.page
    assert page.evaluate(chromium.DRAW) == ""
    for scheme in ("dark", "light"):
        page.emulate_media(color_scheme=scheme)
        # Figures are painted again, one after another.
        comes_true(page, f"!({FAINT})({CONTRAST}).length")
        assert page.evaluate(FAINT, CONTRAST) == []
        assert violations(page) == []


def test_each_broken_rule_of_accessibility_is_found(
    browser: Browser, report: Callable[[str], Report]
) -> None:
    damages = {
        "select-name": "for (const one of $$('#runs label')) one.replaceWith(...one.children)",
        "color-contrast": "$$('.page-header .quiet')[0].style.color = '#999'",
        "heading-order": "$$('#runs h2')[0].outerHTML = '<h5 id=runs-title>All</h5>'",
        "html-has-lang": "document.documentElement.lang = ''",
    }
    with opened(browser, report("two_parameters").path) as found:
        found.page.evaluate(UNFOLD)
        damage = "; ".join(damages.values())
        found.page.evaluate(f"const $$ = (one) => document.querySelectorAll(one); {damage}")
        assert {words.partition(":")[0] for words in violations(found.page)} == damages.keys()


def test_the_keyboard_reaches_what_the_mouse_does(
    browser: Browser, report: Callable[[str], Report]
) -> None:
    focus = "document.activeElement"
    with opened(browser, report("two_parameters").path) as found:
        page = found.page
        page.keyboard.press("Tab")
        assert page.evaluate(f"{focus}.innerText") == "Skip to the answer"
        page.keyboard.press("Enter")
        assert page.evaluate("location.hash") == "#answer"
        page.evaluate(UNFOLD)
        for _ in range(100):
            page.keyboard.press("Tab")
            if page.evaluate(f"{focus}.type") == "range":
                break
        before = page.evaluate(f"{focus}.value")
        page.keyboard.press("ArrowRight")
        assert float(page.evaluate(f"{focus}.value")) > float(before)
        assert page.evaluate(UNREACHED) == []
        # Each folded section is a stop besides.
        assert page.evaluate(STOPS) <= 60 + page.locator("details.folded").count()


def test_the_arrow_keys_go_from_run_to_run(
    browser: Browser, report: Callable[[str], Report]
) -> None:
    with opened(browser, report("two_parameters").path) as found:
        page = found.page
        page.evaluate(UNFOLD)
        links = page.locator("#runs-table tbody a")
        links.nth(0).focus()
        page.keyboard.press("ArrowDown")
        assert page.evaluate("document.activeElement.textContent") == links.nth(1).text_content()
        assert page.locator("#runs-table tbody a[tabindex='0']").count() == 1


def test_a_mark_leads_to_its_run(browser: Browser, report: Callable[[str], Report]) -> None:
    with opened(browser, report("two_parameters").path) as found:
        page = found.page
        assert page.evaluate(chromium.DRAW) == ""
        page.locator("[data-filter=stage]").select_option("verification")
        page.evaluate(
            """() => {
                const place = document.querySelector("[data-figure=convergence-misfit]");
                const [data] = place.data.filter((one) => one.meta?.runs?.includes("run 3"));
                const pointNumber = data.meta.runs.indexOf("run 3");
                place.emit("plotly_click", { points: [{ data, pointNumber }] });
            }"""
        )
        assert comes_true(page, "location.hash === '#run-3'")
        assert page.locator("#run-3").is_visible()


def test_a_link_unfolds_its_section_and_figures_are_drawn_without_scrolling(
    browser: Browser, report: Callable[[str], Report]
) -> None:
    drawn = "place => place.querySelector('.main-svg') !== null"
    with opened(browser, report("two_parameters").path) as found:
        page = found.page
        assert page.evaluate("document.documentElement.scrollHeight") < 3000
        unfolded = page.locator("#answer > details[open]").count()
        page.locator(".contents a[href='#answer']").click()
        page.wait_for_timeout(100)
        assert page.locator("#answer > details[open]").count() == unfolded
        page.set_viewport_size(PHONE)
        assert page.evaluate("document.documentElement.scrollHeight") < 5000
        page.set_viewport_size(LAPTOP)
        figures = page.locator("#convergence .figure")
        assert not figures.first.is_visible()
        page.locator(".contents a[href='#convergence']").click()
        figures.last.wait_for(state="visible")
        assert comes_true(
            page, f"[...document.querySelectorAll('#convergence .figure')].every({drawn})"
        )
        page.evaluate("location.hash = '#run-3'")
        page.locator("#run-3").wait_for(state="visible")
        assert found.faults == []


def test_two_parameters_print_on_few_pages_with_a_surface_of_each_response(
    browser: Browser, report: Callable[[str], Report]
) -> None:
    with opened(browser, report("two_parameters").path) as found:
        page = found.page
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert page.locator(".surface.figure").count() == 2
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        assert page.locator(".surface.figure").count() == 1
        printed = page.pdf(format="A4", prefer_css_page_size=True, print_background=True)
        assert len(re.findall(rb"/Type\s*/Page[^s]", printed)) <= 8


def test_axes_keep_a_height_on_paper(browser: Browser, report: Callable[[str], Report]) -> None:
    axes = "all => all.map((one) => Math.round(one.getBoundingClientRect().height))"
    with opened(browser, report("two_parameters").path) as found:
        found.page.evaluate(UNFOLD)
        shown = found.page.locator("#convergence .figure .nsewdrag")
        before = shown.evaluate_all(axes)
        found.page.evaluate("dispatchEvent(new Event('beforeprint'))")
        printed = shown.evaluate_all(axes)
        found.page.evaluate("dispatchEvent(new Event('afterprint'))")
        assert len(before) > 1
        assert min(printed) >= 150
        assert shown.evaluate_all(axes) == before


def test_the_answer_is_read_without_scrolling(usual: Opened) -> None:
    usual.page.evaluate("for (const one of document.querySelectorAll('details')) one.open = false")
    box = usual.page.locator("#answer").evaluate("(one) => one.getBoundingClientRect().toJSON()")
    top = box["top"] + usual.page.evaluate("scrollY")
    assert top >= 0
    assert top + box["height"] <= LAPTOP["height"]


def test_it_prints_all_that_it_shows(browser: Browser, report: Callable[[str], Report]) -> None:
    with opened(browser, report("two_parameters").path) as found:
        page = found.page
        printed = page.pdf(format="A4", print_background=True)
        page.evaluate(UNFOLD)
        titles = page.eval_on_selector_all(
            # On paper the table alone shows every run.
            ".figure:not([data-figure='runs-parallel']) :is(.xtitle, .ytitle)",
            "all => all.filter((one) => one.checkVisibility()).map((one) => one.textContent)",
        )
        undrawn = page.locator(".figure:not(:has(.main-svg))").count()
        # As it is done for a printer: the page hears of it while it is laid out for the screen.
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        page.wait_for_timeout(500)
        page.emulate_media(media="print")
        cut = page.evaluate(CUT)
    assert undrawn == 0
    assert cut == []
    document = PdfDocument(printed)
    words = _letters("".join(sheet.get_textpage().get_text_bounded() for sheet in document))
    margins = [sheet.render(grayscale=True).to_numpy()[:, -20:] for sheet in document]
    document.close()
    assert len(margins) > 1
    assert len(titles) > 10
    assert [title for title in titles if _letters(title) not in words] == []
    assert [np.ptp(margin) for margin in margins] == [0] * len(margins)


def _letters(text: str) -> str:
    """All but white space, also where it has no width."""
    return re.sub(r"[\s\u200b]", "", text)
