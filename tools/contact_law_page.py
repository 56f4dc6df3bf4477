"""Write the equations of docs/contact_law.md from the contact models.

python tools/contact_law_page.py
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.registry import CONTACT_MODELS
from grainfit.materials.equations import SYMBOLS
from grainfit.materials.time_step import RAYLEIGH_EQUATIONS

PAGE = Path(__file__).parents[1] / "docs" / "contact_law.md"
_BEGIN, _END = "<!-- equations: written by tools/contact_law_page.py -->", "<!-- end -->"
_SOLVERS = {"lammps": "LAMMPS", "liggghts": "LIGGGHTS", "yade": "YADE"}


def updated(page: str) -> str:
    """Return the page with the equations as the contact models have them now."""
    lines = "\n".join(_lines())
    pattern = f"{re.escape(_BEGIN)}.*{re.escape(_END)}"
    return re.sub(pattern, lambda _: f"{_BEGIN}\n\n{lines}\n\n{_END}", page, flags=re.DOTALL)


def _lines() -> Iterator[str]:
    known: dict[str, str] = {}
    for model in CONTACT_MODELS:
        solvers = ", ".join(_SOLVERS[solver] for solver in model.solvers)
        yield from (f"## `{model.name}` ({solvers})", "")
        for head, rows in _tables(model):
            # What stands in the table of an earlier law is not repeated.
            if new := [row for row in rows if row not in known]:
                yield from (*head, *new, "")
            repeated: dict[str, list[str]] = {}
            for row in rows:
                if row in known:
                    repeated.setdefault(known[row], []).append(row.split("|")[1].strip())
                known.setdefault(row, model.name)
            for law, terms in repeated.items():
                yield from (f"As of `{law}`: {', '.join(terms)}.", "")
    yield from ("## Time step", "", "| term | equation | |", "|---|---|---|")
    yield from (_row(one.term, one.formula, one.remark) for one in RAYLEIGH_EQUATIONS)
    yield from ("", "## Symbols", "", "| symbol | meaning |", "|---|---|")
    yield from (f"| `{symbol}` | {meaning} |" for symbol, meaning in SYMBOLS.items())


def _tables(model: ContactModel) -> Iterator[tuple[tuple[str, str], list[str]]]:
    """Yield the heads of the tables of a law, each with its rows."""
    rows = [_row(one.term, one.formula, one.remark) for one in model.equations]
    for words in model.keywords:
        name = _SOLVERS[words.solver]
        rows += [_row(f"{one.term} in {name}", one.formula, one.remark) for one in words.equations]
    yield ("| term | equation | |", "|---|---|---|"), rows
    rows = [f"| `{one.key}` | `{one.symbol}` | {one.meaning} |" for one in model.conventions]
    yield ("| parameter | symbol | convention |", "|---|---|---|"), rows


def _row(term: str, formula: str, remark: str) -> str:
    # A bar would end the cell.
    formula, remark = (text.replace("|", "\\|") for text in (formula, remark))
    return f"| {term} | `{formula}` | {remark} |"


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
