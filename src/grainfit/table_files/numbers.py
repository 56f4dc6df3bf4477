"""Numbers in the cells of a table, with a decimal point or a decimal comma."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from grainfit.errors import Fault
from grainfit.options.places import show
from grainfit.table_files import messages

_EXPONENT = r"(?:[eE][+-]?[0-9]+)?"
_WITH_COMMA = re.compile(rf"[+-]?(?:[0-9]+,[0-9]*|,[0-9]+){_EXPONENT}")
#: A comma or a point that may separate thousands.
_GROUPS = {mark: re.compile(rf"[+-]?[1-9][0-9]{{0,2}}(?:\{mark}[0-9]{{3}})+") for mark in ",."}
_MARKS = (".", ",")


def decimal_mark(cells: Iterable[str]) -> str:
    """Return the decimal mark of numbers: a point, a comma, or "" where none has one.

    A number such as ``1,234`` does not tell: its comma may separate thousands, as may the point of
    ``1.234`` where other numbers have a comma.

    Examples
    --------
    >>> decimal_mark(["1,5", "1,234"]), decimal_mark(["1.5", "2"]), decimal_mark(["1,234"])
    (',', '.', '')
    """
    cells = list(cells)
    if not any("," in cell for cell in cells):
        return "." if any("." in cell and math.isfinite(_plain(cell)) for cell in cells) else ""
    count = dict.fromkeys(_MARKS, 0)
    for cell in cells:
        if "," in cell:
            count[","] += bool(_WITH_COMMA.fullmatch(cell) and not _GROUPS[","].fullmatch(cell))
        elif "." in cell and not _GROUPS["."].fullmatch(cell):
            count["."] += math.isfinite(_plain(cell))
    if not any(count.values()):
        return ""
    return "," if count[","] > count["."] else "."


def parse_number(text: str, mark: str, where: str) -> float | Fault:
    """Return the number in a cell, perhaps infinite or NaN, or the fault of the cell.

    Parameters
    ----------
    text : str
        Content of the cell, not empty.
    mark : str
        Decimal mark of the table.
    where : str
        Line and column of the cell.
    """
    shown, other = show(text), "." if mark == "," else ","
    if _GROUPS[other].fullmatch(text):
        whole, decimal = text.replace(other, ""), text.replace(other, mark or ".", 1)
        if text.count(other) > 1:
            return messages.NOT_A_NUMBER.fault(where, shown=shown, remedy=f"Write {whole}.")
        return messages.THOUSANDS_OR_DECIMAL.fault(where, shown=shown, whole=whole, decimal=decimal)
    number = _plain(text.replace(",", ".") if mark == "," else text)
    is_number = not math.isnan(number) or text.lower().lstrip("+-") == "nan"
    has_other = _WITH_COMMA.fullmatch(text) if other == "," else "." in text and "," not in text
    if has_other and (other == "," or is_number):
        return messages.OTHER_DECIMAL_MARK.fault(where, shown=shown, mark=mark)
    if is_number:
        return number
    remedy = messages.USE_A_COMMA() if mark == "," else messages.USE_A_POINT()
    return messages.NOT_A_NUMBER.fault(where, shown=shown, remedy=remedy)


def _plain(text: str) -> float:
    """Return the number that a text is; NaN for none."""
    # Python reads 1_000 as a thousand; in a table it means something else.
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        return math.nan
