"""Pages that have moved: their old address leads to the new one, with its anchor."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

#: New address by old address.
MOVED = {
    "benchmarks": "developers/benchmarks",
    "decisions": "developers/decisions",
}
_PAGE = """<!doctype html>
<meta charset="utf-8">
<title>This page has moved</title>
<link rel="canonical" href="{0}">
<script>location.replace("{0}" + location.hash)</script>
<noscript><meta http-equiv="refresh" content="0; url={0}"></noscript>
<a href="{0}">This page has moved.</a>
"""


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("build-finished", write_pages)
    return {"parallel_read_safe": True}


def write_pages(app: Sphinx, error: Exception | None) -> None:
    """Write a page at every old address."""
    if error is None and app.builder.name == "html":
        for old, new in MOVED.items():
            page = Path(app.outdir) / f"{old}.html"
            page.write_text(_PAGE.format(f"{new}.html"), encoding="utf-8")
