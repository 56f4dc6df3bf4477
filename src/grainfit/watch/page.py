"""The page itself: a frame that a script fills with the state, as it comes in."""

from __future__ import annotations

from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from grainfit.formatting import plain
from grainfit.report.page import element_text, page_part


def watch_page(folder: Path, nonce: str) -> str:
    """Return the page, with all that it needs but the state.

    Parameters
    ----------
    folder : Path
        The work folder.
    nonce : str
        Secret that marks the scripts and styles of the page: the browser uses no others.
    """
    environment = Environment(
        loader=PackageLoader("grainfit.watch", ""),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    styles = [
        page_part("styles/report.css"),
        page_part("sections/particles/style.css"),
        _part("style.css"),
    ]
    scripts = [
        page_part("scripts/page.js"),
        page_part("sections/particles/script.js"),
        _part("script.js"),
    ]
    page = environment.get_template("page.html.jinja").render(
        name=plain(folder.absolute().name),
        version=version("grainfit"),
        nonce=nonce,
        styles=[element_text(text) for text in styles],
        scripts=[element_text(text) for text in scripts],
    )
    # Names of files may contain bytes that are not text; a page may not.
    return page.encode("utf-8", errors="replace").decode("utf-8")


def _part(file: str) -> str:
    return (files("grainfit.watch") / file).read_text(encoding="utf-8")
