"""Fonts of PDF pages: they are in the file, so that it looks the same everywhere."""

from __future__ import annotations

from pathlib import Path

from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont

__all__ = ["BOLD", "REGULAR", "use_fonts"]

#: Names of the fonts: DejaVu Sans with Latin, Greek and Cyrillic letters and signs.
REGULAR, BOLD = "DejaVuSans", "DejaVuSans-Bold"


def use_fonts() -> None:
    """Make the fonts known to ReportLab; more than once does no harm."""
    for name in (REGULAR, BOLD):
        pdfmetrics.registerFont(TTFont(name, str(Path(__file__).parent / f"{name}.ttf")))
    pdfmetrics.registerFontFamily(
        REGULAR, normal=REGULAR, bold=BOLD, italic=REGULAR, boldItalic=BOLD
    )
