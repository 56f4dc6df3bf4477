"""The page of the atlas in a browser: the curves are those of the package."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from typer.testing import CliRunner

from benchmarks import chromium
from grainfit.atlas.shelf import Atlas
from grainfit.atlas.strata import SIZE, strata
from grainfit.atlas_page.page import atlas_page
from grainfit.cli.app import app
from tests.needs import CHROMIUM

DENSITY = 900.0


def test_the_command_writes_a_page_that_needs_no_network(tmp_path: Path) -> None:
    path = tmp_path / "a page's name.html"

    found = CliRunner().invoke(app, ["atlas", "--output", str(path)])

    assert found.exit_code == 0, found.output
    page = path.read_text(encoding="utf-8")
    assert "heap (lifted cylinder" in page
    assert "http://" not in page.replace("http://www.w3.org/2000/svg", "")


@CHROMIUM
@pytest.mark.slow
def test_the_page_shows_what_the_package_predicts(tmp_path: Path) -> None:
    path, empty = tmp_path / "atlas.html", tmp_path / "empty.html"
    path.write_text(atlas_page(Atlas()), encoding="utf-8")
    empty.write_text(atlas_page(Atlas(tmp_path)), encoding="utf-8")
    faults: list[str] = []
    with chromium.browser() as browser:
        page = browser.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(empty.as_uri())
        assert "no runs" in page.inner_text("#atlas-charts")
        page.goto(path.as_uri())
        page.fill("#atlas-diameter", "4")
        page.fill("#atlas-density", "900")
        page.wait_for_timeout(500)
        shown = page.locator("#atlas-charts h2").all_inner_texts()
        values = page.locator("#atlas-sliders output").all_inner_texts()
        for index, name in enumerate(page.locator("#atlas-test option").all_inner_texts()):
            page.select_option("#atlas-test", str(index))
            assert page.locator("#atlas-charts h2").count() >= 1, name
    assert faults == []
    surrogate = Atlas().of_stratum("heap")
    assert surrogate is not None
    spans = list(strata()["heap"].ranges.items())
    # The usual apparatus, and the middle of all else.
    usual = [n == SIZE or (s.low < 1 < s.high and "." not in n) for n, s in spans]
    shares = [float(s.share(1.0)) if one else 0.5 for (_, s), one in zip(spans, usual, strict=True)]
    assert float(values[5]) == pytest.approx(spans[5][1].at(0.5), rel=0.01)
    angle = surrogate.models["angle_of_repose"].predict(np.array([shares]))[0][0]
    density = surrogate.models["bulk_density"].predict(np.array([shares]))[0][0]
    texts = dict(text.split(": ", 1) for text in shown)
    assert float(texts["angle of repose"].split("\u00b0")[0]) == pytest.approx(angle, rel=0.01)
    assert float(texts["bulk density"].split()[0]) == pytest.approx(density * DENSITY, rel=0.01)


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    """Open the page of the shipped atlas."""
    path = tmp_path / "atlas.html"
    path.write_text(atlas_page(Atlas()), encoding="utf-8")
    with chromium.browser() as browser:
        opened = browser.new_page()
        opened.goto(path.as_uri())
        yield opened


@CHROMIUM
def test_the_page_shows_no_impossible_numbers(page: Page) -> None:
    heads = page.locator("#atlas-charts h2")
    for slider in page.locator("#atlas-sliders input").all():
        slider.press("Home")
    # Smooth spheres that roll freely: the interval of the metamodel goes on below zero.
    expect(heads.nth(1)).to_contain_text(re.compile("angle of repose: 0.*°, 95\u00a0% 0.0 to"))
    for given in ("0", "-1", "", "3,5", "2 mm"):
        page.fill("#atlas-diameter", given)
        expect(page.locator("#atlas-diameter")).to_have_attribute("aria-invalid", "true")
        expect(heads).to_have_count(0)
        expect(page.locator("#atlas-charts")).to_contain_text("particle diameter")
        page.fill("#atlas-diameter", "2")
        expect(page.locator("#atlas-diameter")).to_have_attribute("aria-invalid", "false")
        expect(heads).not_to_have_count(0)


@CHROMIUM
def test_values_have_the_digits_of_their_interval_and_stay_in_another_test(page: Page) -> None:
    heads = page.locator("#atlas-charts h2")
    for head in heads.all_inner_texts():
        value, low, high = (
            float(one) for one in re.findall(r"-?\d+\.?\d*", head.replace("95", "", 1))
        )
        assert low < value < high, head
    first = page.locator("#atlas-sliders input").first
    shown = page.locator("#atlas-sliders output").first
    first.press("End")
    expect(shown).to_have_text("1.5")
    page.select_option("#atlas-test", "1")
    expect(shown).to_have_text("1.5")
