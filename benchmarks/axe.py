"""Rules of accessibility that a page breaks, by axe-core."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

from benchmarks import chromium

#: Those of the Web Content Accessibility Guidelines 2.0 and 2.1, and of good practice.
RULES = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice")
LAPTOP, PHONE = {"width": 1366, "height": 768}, {"width": 390, "height": 844}


def violations(page: Page) -> list[str]:
    """Return the violations of a page as it is now, one for each rule and element."""
    options = {"runOnly": list(RULES), "resultTypes": ["violations"]}
    found = Axe().run(page, options=options).response
    return [words for rule in found["violations"] for words in _in_words(rule)]


def violations_in(file: Path) -> list[str]:
    """Return those of a page in a file: on a laptop, light and dark, and on a phone."""
    with chromium.browser() as browser:
        page = browser.new_page(viewport=LAPTOP, reduced_motion="reduce")
        page.goto(file.as_uri())
        page.evaluate(chromium.DRAW)
        light = violations(page)
        page.set_viewport_size(PHONE)
        on_phone = violations(page)
        page.set_viewport_size(LAPTOP)
        page.emulate_media(color_scheme="dark")
        return [*light, *on_phone, *violations(page)]


def _in_words(rule: dict[str, Any]) -> Iterator[str]:
    for node in rule["nodes"]:
        summary = " ".join(node["failureSummary"].split())
        yield f"{rule['id']}: {node['html'][:200]} ({node['target']}): {summary}"
