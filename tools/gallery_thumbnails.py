"""Take the thumbnails of the gallery from the built site, with Chromium.

sphinx-build docs build/site && python tools/gallery_thumbnails.py

The small pictures are kept in docs/images/gallery, so that the site is built without a browser.
"""

from __future__ import annotations

import argparse
import io
import shutil
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "build" / "site" / "generated" / "gallery"
PICTURES = ROOT / "docs" / "images" / "gallery"
_WIDTH = 480


def main() -> None:
    """Write a picture for each example of the gallery."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"))
        page = browser.new_page(viewport={"width": 1300, "height": 1000})
        for path in sorted(PAGES.glob("plot_*.html")):
            page.goto(path.as_uri())
            figure = page.locator(".plotly-graph-div").first
            figure.locator("svg.main-svg").first.wait_for()
            page.wait_for_timeout(500)
            taken = Image.open(io.BytesIO(figure.screenshot()))
            small = taken.resize((_WIDTH, round(_WIDTH * taken.height / taken.width)))
            name = path.stem.removeprefix("plot_") + ".png"
            small.convert("P", palette=Image.Palette.ADAPTIVE).save(PICTURES / name, optimize=True)
        browser.close()


if __name__ == "__main__":
    main()
