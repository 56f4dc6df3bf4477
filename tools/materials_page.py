"""Write the tables of docs/starting_materials.md from the files of the materials.

python tools/materials_page.py
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from grainfit.materials.from_published import sections_of
from grainfit.materials.material_classes import material_classes
from grainfit.materials.published_values import PublishedValue
from grainfit.materials.starting_materials import StartingMaterial, materials_like
from grainfit.materials.starting_values import StartingValue

PAGE = Path(__file__).parents[1] / "docs" / "starting_materials.md"
_BEGIN, _END = "<!-- materials: written by tools/materials_page.py -->", "<!-- end -->"
_BEGIN_OWN, _END_OWN = (
    "<!-- own frictions: written by tools/materials_page.py -->",
    "<!-- end of own frictions -->",
)
_COLUMNS = {
    "diameter": "diameter, mm",
    "bulk_density": "bulk density, kg/m³",
    "density": "density, kg/m³",
    "angle_of_repose": "angle of repose, °",
    "wall_friction": "friction on metal",
}
_OWN_COLUMNS = {
    ("particle", "diameter"): "diameter",
    ("particle", "density"): "density",
    ("particle_particle", "sliding_friction"): "sliding friction",
    ("particle_particle", "rolling_friction"): "rolling friction",
    ("particle_particle", "restitution"): "restitution",
    ("particle_wall", "sliding_friction"): "sliding friction on the wall",
}


def updated(page: str) -> str:
    """Return the page with the materials as their files have them now."""
    page = _between(page, _BEGIN, _END, _lines())
    return _between(page, _BEGIN_OWN, _END_OWN, _own_lines())


def _between(page: str, begin: str, end: str, lines: Iterator[str]) -> str:
    text = "\n".join((begin, "", *lines, "", end))
    pattern = f"{re.escape(begin)}.*?{re.escape(end)}"
    return re.sub(pattern, lambda _: text, page, flags=re.DOTALL)


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


def _own_lines() -> Iterator[str]:
    head = ["material", *_OWN_COLUMNS.values()]
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for material in filter(_has_own_frictions, materials_like()):
        values = [material.sections[section][key] for section, key in _OWN_COLUMNS]
        yield f"| `{material.name}` | {' | '.join(map(_own_cell, values))} |"


def _has_own_frictions(material: StartingMaterial) -> bool:
    usual = sections_of(material.published, material.material_class)
    return material.sections["particle_particle"] != usual["particle_particle"]


def _own_cell(given: StartingValue) -> str:
    words = "{min} to {max}".format(**given.value) if given.is_free else f"{given.value}"
    words = words.replace(" kg/m^3 to", " to").replace("^3", "³")
    return f"*{words}*" if given.source.startswith("No source") else words


def _cell(value: PublishedValue | None) -> str:
    return "" if value is None else value.words.removesuffix(f" {value.unit}")


def _short(source: str) -> str:
    """Return a source without the place in it."""
    return source.partition(", abstract")[0].partition(": ")[0]


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
