"""The card as a table, for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from grainfit.formatting import plain, spreadsheet_text
from grainfit.materials.card import MaterialCard
from grainfit.solvers.dem.card_parts import simulated_card

COLUMNS = (
    "kind",
    "name",
    "symbol",
    "unit",
    "value",
    "low_95",
    "high_95",
    "origin",
    "target",
    "tolerance",
    "deviation_percent",
    "met",
    "verdict",
    "determination",
    "simulated_value",
    "coarse_graining",
)
Cell = str | float | bool | None


def render_csv(card: MaterialCard) -> str:
    """Return a line for each parameter and each response; each line has the status."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([_as_text(cells.get(name)) for name in COLUMNS] for cells in _lines(card))
    return file.getvalue()


def _lines(card: MaterialCard) -> Iterator[dict[str, Cell]]:
    simulated = simulated_card(card).values
    factor = None if card.sizes is None else card.sizes.coarse_graining
    for parameter in card.parameters:
        low, high = parameter.interval or (None, None)
        yield {
            "kind": "parameter",
            "name": parameter.name,
            "symbol": parameter.symbol,
            "unit": parameter.unit,
            "value": parameter.value,
            "low_95": low,
            "high_95": high,
            "origin": parameter.origin,
            "verdict": card.verdict,
            "determination": parameter.determination,
            "simulated_value": simulated[parameter.name],
            "coarse_graining": factor,
        }
    for response in card.responses:
        yield {
            "kind": "response",
            "name": response.name,
            "unit": response.unit,
            "value": response.expected,
            "low_95": response.interval[0],
            "high_95": response.interval[1],
            "origin": "expected by all runs",
            "target": response.target,
            "tolerance": response.tolerance,
            "deviation_percent": response.deviation_percent,
            "met": response.verdict == "met",
            "verdict": card.verdict,
            "coarse_graining": factor,
        }


def _as_text(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, float):
        return repr(cell)
    return spreadsheet_text(plain(cell))
