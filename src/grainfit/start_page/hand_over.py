"""What comes of a calibration that has ended: its state, cards and the customer's sheet."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from grainfit.calibration.provenance import Provenance
from grainfit.calibration_file.load import parse_text, read_text
from grainfit.cards import FORMAT_TITLES, material_card, render, require_format
from grainfit.errors import InputError, StoreError
from grainfit.work_folder.open_folder import open_folder

#: Name of the customer's sheet beside the formats of a card, and its title on the page.
SHEET, _SHEET_TITLE = "sheet", "Customer’s sheet (PDF)"
_KINDS = {"json": "application/json", "csv": "text/csv; charset=utf-8"}
_ENDINGS = {"json": "json", "csv": "csv", "yade": "py"}


@dataclass(frozen=True)
class Outcome:
    """What came of the latest calibration in a work folder.

    Parameters
    ----------
    state : str
        How it ended; empty while it runs, and without one.
    offers : mapping of str to str
        What `handed_over` makes, titles by name; nothing without an answer.
    is_of_earlier_file : bool
        Whether the calibration file says something else now.
    """

    state: str = ""
    offers: Mapping[str, str] = field(default_factory=dict)
    is_of_earlier_file: bool = False


def outcome(folder: Path, file: Path) -> Outcome:
    """Read what came of a calibration file; nothing where the work folder cannot be read."""
    with suppress(StoreError), open_folder(folder) as opened:
        if opened.calibration is None or opened.is_at_work:
            return Outcome()
        result, _ = opened.read_result()
        offers = {SHEET: _SHEET_TITLE, **FORMAT_TITLES} if result and result.parameters else {}
        text = Provenance.from_json(opened.calibration.about.get("provenance", {})).text
        return Outcome(opened.state, offers, bool(text) and _is_changed(file, text))
    return Outcome()


def _is_changed(file: Path, text: str) -> bool:
    """Return whether a calibration file has other values than a text; comments do not count."""
    try:
        return parse_text(read_text(file), file) != parse_text(text, file)
    except InputError:
        return True


def handed_over(folder: Path, name: str) -> tuple[str, str, bytes]:
    """Make one of the offers of an `Outcome`.

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
