"""The card as a table, for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import Any

from grainfit.contact_models.registry import contact_law, with_defaults
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
    "bias",
    "simulated_value",
    "coarse_graining",
    "formula",
    "meaning",
)
Cell = str | float | bool | None


def render_csv(card: MaterialCard) -> str:
    """Return a line for each parameter, response, equation of the contact law, and convention.

    Each line has the status.
    """
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([_as_text(cells.get(name)) for name in COLUMNS] for cells in _lines(card))
    return file.getvalue()


def _lines(card: MaterialCard) -> Iterator[dict[str, Any]]:
    simulated = simulated_card(card).values
    factor = None if card.sizes is None else card.sizes.coarse_graining
    common = {"verdict": card.verdict, "coarse_graining": factor}
    for parameter in card.parameters:
        low, high = parameter.interval or (None, None)
        yield (
            vars(parameter)
            | common
            | {
                "kind": "parameter",
                "low_95": low,
                "high_95": high,
                "simulated_value": simulated[parameter.name],
            }
        )
    for response in card.responses:
        low, high = response.interval
        yield (
            vars(response)
            | common
            | {
                "kind": "response",
                "value": response.expected,
                "low_95": low,
                "high_95": high,
                "origin": "expected by all runs",
                "met": response.verdict == "met",
            }
        )
    yield from (common | line for line in _law_lines(card))


def _law_lines(card: MaterialCard) -> Iterator[dict[str, Any]]:
    """Yield the equations of the contact models and their conventions; none of own models."""
    if not card.contact_models:
        return
    law = contact_law(with_defaults(card.values), card.contact_models)
    equations = [("contact law", equation) for equation in law.equations()]
    for solver, found in [*equations, *law.differing_terms]:
        line = {"kind": "equation", "name": found.term, "origin": solver}
        yield line | {"formula": found.formula, "meaning": found.remark}
    for convention in law.conventions:
        line = {"kind": "convention", "name": convention.key}
        yield line | {"symbol": convention.symbol, "meaning": convention.meaning}


def _as_text(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, float):
        return repr(cell)
    return spreadsheet_text(plain(cell))
