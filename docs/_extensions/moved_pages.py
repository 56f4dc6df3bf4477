"""Pages that have moved: their old address leads to the new one, with its anchor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

#: New page by old page, both without their ending; a folder's index leads to the page of an anchor.
MOVED = {
    "benchmarks": "developers/benchmarks",
    "building_the_site": "developers/building_the_site",
    "calibration_file": "reference/calibration_file/index",
    "decisions": "developers/decisions",
}
_PAGE = """<!doctype html>
<meta charset="utf-8">
<title>This page has moved</title>
<link rel="canonical" href="{page}">
<script>
const pages = {anchors};
location.replace((pages[decodeURIComponent(location.hash.slice(1))] ?? "{page}") + location.hash);
</script>
<noscript><meta http-equiv="refresh" content="0; url={page}"></noscript>
<a href="{page}">This page has moved.</a>
"""


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("build-finished", write_pages)
    return {"parallel_read_safe": True}


def write_pages(app: Sphinx, error: Exception | None) -> None:
    """Write a page at every old address."""
    if error is None and app.builder.name == "html":
        for old, new in MOVED.items():
            text = _PAGE.format(page=f"{new}.html", anchors=json.dumps(_pages_by_anchor(app, new)))
            (Path(app.outdir) / f"{old}.html").write_text(text, encoding="utf-8")


def _pages_by_anchor(app: Sphinx, index: str) -> dict[str, str]:
    folder, _, name = index.rpartition("/")
    if name != "index":
        return {}
    found: dict[str, str] = {}
    for page in sorted(app.env.found_docs):
        if page.startswith(f"{folder}/"):
            for slug, (_, anchor, _) in app.env.metadata[page].get("myst_slugs", {}).items():
                found |= {slug: f"{page}.html", anchor: f"{page}.html"}
    return found
