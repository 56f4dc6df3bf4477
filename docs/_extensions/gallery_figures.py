"""Show Plotly figures in the gallery, with one copy of Plotly that the site has itself."""

from __future__ import annotations

import shutil
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import plotly.io as pio
from plotly.io.base_renderers import MimetypeRenderer

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_SCRIPT = "plotly.min.js"
#: Pages of the gallery are two folders deep. The theme would load scripts after the figures.
_ADDRESS = f"../../_static/{_SCRIPT}"


class _Embedded(MimetypeRenderer):
    """A figure as HTML that leaves Plotly to the page."""

    def to_mimebundle(self, fig_dict: dict[str, Any]) -> dict[str, str]:
        html = pio.to_html(fig_dict, include_plotlyjs=_ADDRESS, full_html=False, validate=False)
        return {"text/html": html}


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    pio.renderers["site"] = _Embedded()
    pio.renderers.default = "site"
    app.connect("build-finished", _copy_script)
    return {"parallel_read_safe": True}


def _copy_script(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        source = Path(str(files("plotly") / "package_data" / _SCRIPT))
        shutil.copy(source, Path(app.outdir) / "_static" / _SCRIPT)
