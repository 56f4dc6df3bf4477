"""Write the table of the real materials from kept results."""

from __future__ import annotations

import re
from pathlib import Path

from grainfit.files import write_atomically
from grainfit.formatting import (
    plain_ends,
    plain_interval,
    plain_probability,
    unit_for_people,
    with_unit,
)
from grainfit.result import HoldoutResponse, Result
from grainfit.student import NORMAL_QUANTILE

ROOT = Path(__file__).parents[2]
#: Folders of results, without those of runs.
KEPT = ROOT / "docs" / "recorded"
PAGE = ROOT / "docs" / "studies" / "real_materials.md"
#: Examples in the order of the table.
MATERIALS = ("karlsruhe_sand", "granular_urea", "mcc_drum")

_MARKED = re.compile("(?<=<!-- table -->\n).*(?=<!-- end of table -->)", re.DOTALL)
_HEAD = (
    "| material | calibrated on: measured → expected | predicted | expected, 95 % | measured "
    "| without calibration | probability | |\n|---|---|---|---|---|---|---|---|\n"
)


def write_page() -> Path:
    """Write the table into the page, and return its path."""
    write_atomically(PAGE, page())
    return PAGE


def page() -> str:
    """Return the page with the table of the kept results."""
    lines = [line for name in MATERIALS if _kept(name).exists() for line in _lines(name)]
    text = PAGE.read_text(encoding="utf-8")
    return _MARKED.sub(lambda _: _HEAD + "".join(lines), text)


def _kept(name: str) -> Path:
    return KEPT / name / "result.json"


def _lines(name: str) -> list[str]:
    result = Result.from_json(_kept(name))
    link = f"[{result.name}](../../examples/{name}/calibration.toml), {result.status}"
    fitted = "; ".join(
        f"{response.replace('_', ' ')} {plain_interval(found.target, found.tolerance)}"
        f" → {with_unit(plain_interval(*found.expected), unit_for_people(found.unit))}"
        for response, found in result.responses.items()
    )
    predicted = [
        (one.test, response, found)
        for one in result.holdouts
        for response, found in one.responses.items()
    ]
    # Material and what it was calibrated on stand in its first line alone.
    heads = [(link, fitted), *[("", "")] * (len(predicted) - 1)]
    return [
        _line(material, of_fit, *one)
        for (material, of_fit), one in zip(heads, predicted, strict=True)
    ]


def _line(material: str, fitted: str, test: str, response: str, found: HoldoutResponse) -> str:
    half = NORMAL_QUANTILE * (found.uncertainty or 0.0)
    verdict = found.verdict or ""
    words = f"{test.replace('_', ' ')}: {response.replace('_', ' ')}"
    unit = unit_for_people(found.unit)
    cells = (
        material,
        fitted,
        f"{words}, {unit}" if unit else words,
        plain_ends(*found.interval),
        plain_interval(found.measured or 0.0, half),
        plain_ends(*found.prior),
        plain_probability(found.probability or 0.0),
        f"**{verdict}**" if verdict == "does not predict" else verdict,
    )
    return f"| {' | '.join(cells)} |\n"
