"""Chromium as installed on the machine, without a window."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Browser, sync_playwright

EXECUTABLE = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)

#: Draw every figure of a report, as a reader does who scrolls through all of the page; returns the
#: one that does not appear.
DRAW = """async () => {
    for (const details of document.querySelectorAll("details")) details.open = true;
    for (const place of document.querySelectorAll("[data-figure]")) {
        place.scrollIntoView({ behavior: "instant" });
        const end = performance.now() + 20000;
        while (!place.querySelector(".main-svg")) {
            if (performance.now() > end) return place.dataset.figure;
            await new Promise(requestAnimationFrame);
        }
    }
    window.scrollTo(0, 0);
    return "";
}"""


@contextmanager
def browser() -> Iterator[Browser]:
    """Start Chromium."""
    # Chromium does not start its sandbox as root.
    arguments = ["--no-sandbox"] if os.getuid() == 0 else []
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=EXECUTABLE, args=arguments)
        try:
            yield started
        finally:
            started.close()
