"""Write the page: one file that works offline and contains everything that it shows."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import datetime
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from markupsafe import Markup

from grainfit.errors import StoreError
from grainfit.files import write_atomically, writing
from grainfit.formatting import plain
from grainfit.one_thread import one_thread
from grainfit.report import messages
from grainfit.report.rendering import fill_template, script_json
from grainfit.report.section import ReportContext
from grainfit.report.sections.registry import FOLDED, SECTIONS
from grainfit.report.verdict import shown_verdict
from grainfit.work_folder.saved_calibration import SavedCalibration

REPORT_NAME = "report.html"
#: Enough to draw a figure; a grid of contours would be three times as large otherwise.
_FIGURE_DIGITS = 6


def write_report(
    source: str | Path | SavedCalibration,
    output: str | Path | None = None,
    *,
    on_progress: Callable[[str], None] | None = None,
    on_warning: Callable[[str], None] | None = None,
) -> Path:
    """Write the report of the calibration in a work folder: one HTML file, complete or absent.

    It can be written at any time, also while the calibration is running; nothing else in the folder
    is changed.

    Parameters
    ----------
    source : path or SavedCalibration
        The work folder, or the calibration read from it.
    output : path, optional
        The file to write; ``report.html`` in the folder by default.
    on_progress : callable, optional
        Called with a few words before each step.
    on_warning : callable, optional
        Called with why there is no answer to be shown, if there is none.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    StoreError
        The folder is not a work folder, nothing was calibrated in it, or the report cannot be
        written.
    """
    tell = on_progress or (lambda _words: None)
    tell("reading the runs")
    reading = SavedCalibration.of(source)
    tell(f"analysing {len(reading.known)} parameter sets")
    with one_thread():
        analysis = reading.analyse()
        tell("drawing")
        context = ReportContext(reading, analysis)
        page = render_page(context)
    path = Path(output) if output is not None else reading.folder / REPORT_NAME
    _write(path, page)
    if not context.answer and on_warning is not None:
        verdict = shown_verdict(context)
        on_warning(" ".join((verdict.line, *verdict.details)))
    return path


def render_page(context: ReportContext) -> str:
    """Return the whole page."""
    sections = [section for make in SECTIONS if (section := make(context)) is not None]
    figures = {key: figure for section in sections for key, figure in section.figures.items()}
    page = fill_template(
        "page",
        name=plain(context.reading.name) or plain(context.reading.folder.absolute().name),
        written=datetime.now().astimezone().strftime("%d %B %Y, %H:%M"),
        version=version("grainfit"),
        sections=sections,
        folded=[section.__name__ for section in FOLDED],
        styles=[element_text(text) for text in _parts("styles/report.css", "style.css")],
        scripts=[element_text(text) for text in _parts("scripts/page.js", "script.js")],
        figure_index=script_json(
            {key: {"height": f.height, "description": f.description} for key, f in figures.items()}
        ),
        figures={
            key: script_json({"data": figure.data, "layout": figure.layout}, _FIGURE_DIGITS)
            for key, figure in figures.items()
        },
        data={section.key: script_json(section.data) for section in sections if section.data},
        plotly=element_text(page_part("plotly/plotly-cartesian.min.js")) if figures else None,
    )
    return valid_text(page)


def _parts(first: str, of_section: str) -> list[str]:
    """Texts of all scripts or styles: the page's own, what sections share, then each section's."""
    package = Path(str(files("grainfit.report")))
    own = package / first
    shared = sorted(path for path in own.parent.glob(f"*{own.suffix}") if path != own)
    sections = sorted((package / "sections").glob(f"*/{of_section}"))
    return [path.read_text(encoding="utf-8") for path in (own, *shared, *sections)]


def page_part(file: str) -> str:
    """Return a style or script of the report, such as ``"scripts/page.js"``."""
    return (files("grainfit.report") / file).read_text(encoding="utf-8")


def valid_text(page: str) -> str:
    """Return a page as text that can be written: names of files may contain bytes that are none."""
    return page.encode("utf-8", errors="replace").decode("utf-8")


def element_text(text: str) -> Markup:
    """Return a script or style so that nothing in it ends its element, or opens a comment."""
    safe = re.sub(r"</(?=script|style)", r"<\\/", text, flags=re.IGNORECASE)
    return Markup(safe.replace("<!--", r"<\!--"))


def _write(path: Path, page: str) -> None:
    with writing(path, StoreError, messages.CANNOT_BE_WRITTEN):
        write_atomically(path, page)
