"""Write the table of docs/starting_materials.md from the files of the materials.

python tools/materials_page.py
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from grainfit.materials.material_classes import material_classes
from grainfit.materials.published_values import PublishedValue
from grainfit.materials.starting_materials import materials_like

PAGE = Path(__file__).parents[1] / "docs" / "starting_materials.md"
_BEGIN, _END = "<!-- materials: written by tools/materials_page.py -->", "<!-- end -->"
_COLUMNS = {
    "diameter": "diameter, mm",
    "bulk_density": "bulk density, kg/m³",
    "density": "density, kg/m³",
    "angle_of_repose": "angle of repose, °",
    "wall_friction": "friction on metal",
}


def updated(page: str) -> str:
    """Return the page with the materials as their files have them now."""
    lines = "\n".join(_lines())
    pattern = f"{re.escape(_BEGIN)}.*{re.escape(_END)}"
    return re.sub(pattern, lambda _: f"{_BEGIN}\n\n{lines}\n\n{_END}", page, flags=re.DOTALL)


def _lines() -> Iterator[str]:
    sources: dict[str, int] = {}
    head = ["material", "moisture", *_COLUMNS.values(), "sources"]
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for name, known in material_classes().items():
        yield f"| **{known.title}** |{' |' * (len(head) - 1)}"
        for material in materials_like(of_class=name):
            cells = [_cell(material.published.get(column)) for column in _COLUMNS]
            used = dict.fromkeys(_short(v.source) for v in material.published.values())
            for source in used:
                sources.setdefault(source, len(sources) + 1)
            numbers = ", ".join(f"P{sources[source]}" for source in used)
            row = [f"`{material.name}`", material.moisture, *cells, numbers or "below"]
            yield f"| {' | '.join(row)} |"
    yield ""
    for source, number in sources.items():
        yield f"- P{number}: {source}."


def _cell(value: PublishedValue | None) -> str:
    return "" if value is None else value.words.removesuffix(f" {value.unit}")


def _short(source: str) -> str:
    """Return a source without the place in it."""
    return source.partition(", abstract")[0].partition(": ")[0]


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
