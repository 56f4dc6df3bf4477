"""A sheet for the laboratory as PDF: what to do, and blanks for what is measured."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping
from typing import Any
from xml.sax.saxutils import escape

from reportlab.lib.colors import HexColor
from reportlab.lib.pagesizes import A4
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.platypus import (
    Flowable,
    KeepTogether,
    Paragraph,
    SimpleDocTemplate,
    Spacer,
    Table,
    TableStyle,
)

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.formatting import plain, unit_for_people
from grainfit.interview.equipment import Way
from grainfit.pdf import BOLD, REGULAR, use_fonts
from grainfit.pdf.line_drawing import line_drawing

_MARGIN, _REPEATS = 16 * mm, 5
_WIDTH = A4[0] - 2 * _MARGIN
_LINE = HexColor("#8a929b")
_TEXT = ParagraphStyle("text", fontName=REGULAR, fontSize=9, leading=12.5)
_QUIET = ParagraphStyle("quiet", _TEXT, fontSize=7.5, leading=9.5, textColor=HexColor("#555555"))
_TITLE = ParagraphStyle("title", _TEXT, fontName=BOLD, fontSize=15, leading=20)
_HEADING = ParagraphStyle("heading", _TEXT, fontName=BOLD, fontSize=11.5, leading=18)
#: Units that are read off, where those of the responses are too large.
_USUAL = {"m": "mm", "kg/s": "g/s"}


def record_sheet(
    material: str, moisture: str, tests: Iterable[tuple[Way, Mapping[str, Any]]]
) -> bytes:
    """Return the sheet as a PDF file.

    Parameters
    ----------
    material, moisture : str
        Of the sample; empty if it is not known.
    tests : iterable of (Way, mapping)
        The tests, each with its section of the calibration file.
    """
    use_fonts()
    content = io.BytesIO()
    page = SimpleDocTemplate(
        content,
        pagesize=A4,
        title=f"Record sheet: {plain(material)}",
        invariant=1,
        **dict.fromkeys(("leftMargin", "rightMargin", "topMargin", "bottomMargin"), _MARGIN),
    )
    page.build([*_head(material, moisture), *(part for one in tests for part in _test(*one))])
    return content.getvalue()


def _head(material: str, moisture: str) -> Iterator[Flowable]:
    yield _paragraph(f"Record sheet: {material}", _TITLE)
    yield _table([[f"Moisture: {moisture}", "Sample:", "Date:", "By:"]], [0.4, 0.2, 0.2, 0.2])


def _test(way: Way, test: Mapping[str, Any]) -> Iterator[Flowable]:
    kind = BUILT_IN[way.test]
    keys = {key.name: key.in_words() for key in kind.option_keys()}
    yield Spacer(0, 5 * mm)
    steps = [_paragraph(f"{number}. {step}", _TEXT) for number, step in enumerate(way.steps, 1)]
    drawing = [line_drawing(way.drawing, _WIDTH)] if way.drawing else []
    yield KeepTogether([_paragraph(f"{way.name}: {way.title}", _HEADING), *steps, *drawing])
    yield Spacer(0, 2 * mm)
    dimensions = [
        [
            [
                _paragraph(_words(option), _TEXT),
                _paragraph(keys[option].description.partition(". ")[0], _QUIET),
            ],
            str(test.get(option, "")),
        ]
        for option in way.options_of(test)
    ]
    if dimensions:
        yield _table(dimensions, [0.7, 0.3])
        yield Spacer(0, 2 * mm)
    heading = ["Measured", *(f"{number}" for number in range(1, _REPEATS + 1)), "wrong in all ±"]
    rows = [
        [_label(kind.responses[name].unit, name), *[""] * (_REPEATS + 1)] for name in way.responses
    ]
    yield _table([heading, *rows], [0.28, *[0.11] * _REPEATS, 0.17])


def _label(unit: str, name: str) -> str:
    shown = unit_for_people(_USUAL.get(unit, unit))
    return f"{_words(name)}{f', {shown}' if shown else ''}"


def _words(name: str) -> str:
    return name.replace("_", " ").capitalize()


def _paragraph(text: str, style: ParagraphStyle) -> Paragraph:
    return Paragraph(escape(plain(text)), style)


def _table(rows: list[list[Any]], widths: list[float]) -> Table:
    cells = [[_paragraph(c, _TEXT) if isinstance(c, str) else c for c in row] for row in rows]
    style = [("GRID", (0, 0), (-1, -1), 0.5, _LINE), ("VALIGN", (0, 0), (-1, -1), "MIDDLE")]
    return Table(cells, [share * _WIDTH for share in widths], style=TableStyle(style))
