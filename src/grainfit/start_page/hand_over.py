"""What comes of a calibration that has ended: its state, cards and the customer's sheet."""

from __future__ import annotations

import json
import tempfile
from contextlib import suppress
from pathlib import Path

from grainfit.campaign.work_folder import RESULT_NAME
from grainfit.cards import FORMAT_TITLES, material_card, render, require_format

#: Name of the customer's sheet beside the formats of a card, and its title on the page.
SHEET, _SHEET_TITLE = "sheet", "Customer’s sheet (PDF)"
_KINDS = {"json": "application/json", "csv": "text/csv; charset=utf-8"}
_ENDINGS = {"json": "json", "csv": "csv", "yade": "py"}


def offers(folder: Path) -> dict[str, str]:
    """Return what `handed_over` makes, titles by name; nothing before there is a result."""
    made = (folder / RESULT_NAME).exists()
    return {SHEET: _SHEET_TITLE, **FORMAT_TITLES} if made else {}


def state_of(folder: Path) -> str:
    """Return the state of the result in a work folder; empty without a result that can be read."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        return str(json.loads((folder / RESULT_NAME).read_text(encoding="utf-8"))["status"])
    return ""


def handed_over(folder: Path, name: str) -> tuple[str, str, bytes]:
    """Make one of `offers`.

    Returns
    -------
    tuple of (str, str, bytes)
        Type of the content, name of the file, and the content.

    Raises
    ------
    StoreError
        It is not a work folder, or the result in it is damaged.
    InputError
        There is no such offer, no answer, or the answer has none of the values that are needed.
    """
    if name == SHEET:
        return "application/pdf", f"{folder.stem}_sheet.pdf", _sheet(folder)
    require_format(name)
    text = render(material_card(folder), name)
    kind = _KINDS.get(name, "text/plain; charset=utf-8")
    return kind, f"{folder.stem}_{name}.{_ENDINGS.get(name, 'txt')}", text.encode()


def _sheet(folder: Path) -> bytes:
    # The page only reads: a file in the work folder is for those who ask for it there.
    from grainfit.report.sheet.sheet import write_sheet

    with tempfile.TemporaryDirectory() as place:
        return write_sheet(folder, Path(place) / "sheet.pdf").read_bytes()
