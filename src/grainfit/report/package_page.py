"""Pages beside the report that look like it and draw particles as it does."""

from __future__ import annotations

from importlib.metadata import version
from importlib.resources import files
from typing import Any

from jinja2 import PackageLoader

from grainfit.report.page import element_text, page_part, valid_text
from grainfit.report.rendering import environment

_STYLES = (
    "styles/report.css",
    "sections/particles/style.css",
    "sections/photographs/style.css",
)


def package_page(package: str, **values: Any) -> str:
    """Return the page of a package: one file that works offline.

    Parameters
    ----------
    package : str
        Its ``page.html.jinja`` is filled in; its ``style.css`` and ``script.js``, if it has them,
        follow those of the report and of its drawings.
    **values
        Values of the other variables of the template.
    """
    own = files(package)
    styles = [page_part(file) for file in _STYLES]
    scripts = [page_part("scripts/page.js"), page_part("sections/particles/script.js")]
    for texts, name in ((styles, "style.css"), (scripts, "script.js")):
        if (own / name).is_file():
            texts.append((own / name).read_text(encoding="utf-8"))
    template = environment(PackageLoader(package, "")).get_template("page.html.jinja")
    page = template.render(
        version=version("grainfit"),
        styles=[element_text(text) for text in styles],
        scripts=[element_text(text) for text in scripts],
        **values,
    )
    return valid_text(page)
