"""Time to write and to open the report of a large calibration, and size of the report.

Five parameters, two responses and so many runs of a smooth model with scatter, analysed and written
as `grainfit report` does it. It is opened in Chromium, which has to be installed, without a network
and with an empty cache.

Usage: python benchmarks/report.py [--runs N] [--json PATH]
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from statistics import median

import campaigns
import chromium
from grainfit.report.page import write_report

#: Upper limits: seconds to write and to open it, and megabytes.
GOALS = {"writing": 20.0, "first paint": 3.0, "size": 4.0}
UNITS = {"writing": "s", "first paint": "s", "size": "MB"}
_PAINT = """() => new Promise((resolve) => {
    new PerformanceObserver((list) => {
        const found = list.getEntriesByName("first-contentful-paint");
        if (found.length) resolve(found[0].startTime / 1000);
    }).observe({ type: "paint", buffered: true });
})"""


def first_paints(page: Path, times: int) -> list[float]:
    """Open the page several times; return the seconds until it shows its first content."""
    found = []
    with chromium.browser() as browser:
        for _ in range(times):
            context = browser.new_context(viewport={"width": 1366, "height": 768}, offline=True)
            tab = context.new_page()
            tab.goto(page.as_uri(), wait_until="commit")
            found.append(float(tab.evaluate(_PAINT)))
            context.close()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        campaigns.many_runs(folder, options.runs)
        started = time.perf_counter()
        page = write_report(folder)
        figures = {
            "writing": time.perf_counter() - started,
            "first paint": median(first_paints(page, 5)),
            "size": page.stat().st_size / 1e6,
        }
    print(f"{options.runs} runs, five parameters")
    for name, found in figures.items():
        print(f"{name:12} {found:6.2f} {UNITS[name]} (goal: under {GOALS[name]:g})")
    if options.json:
        options.json.write_text(json.dumps(figures))


if __name__ == "__main__":
    main()
