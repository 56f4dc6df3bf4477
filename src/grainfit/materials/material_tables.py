"""Starting materials as tables and sentences: the list, and one with its sources."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.errors import InputError
from grainfit.formatting import counted
from grainfit.materials import messages
from grainfit.materials.material_classes import material_classes
from grainfit.materials.published_values import QUANTITIES
from grainfit.materials.starting_materials import (
    StartingMaterial,
    materials_like,
    read_starting_material,
    typical_ranges,
)
from grainfit.tables import TextTable

_COLUMNS = ("diameter", "bulk_density", "density", "angle_of_repose")


def material_parts(words: str = "", of_class: str = "") -> list[str | TextTable]:
    """Return the starting materials that have all words, or one of them with its sources.

    Parameters
    ----------
    words : str
        Words of names, synonyms and classes; all materials without them.
    of_class : str
        Name of a class; all classes without it.

    Raises
    ------
    InputError
        There is no such class, or no such material; the fault has what is near.
    """
    found = materials_like(words, of_class)
    if words and not of_class:
        try:
            return list(_lines(read_starting_material(words)))
        except InputError:
            if not found:
                raise
    if not found:
        raise InputError(messages.NONE_OF_CLASS.fault("", words=words, name=of_class))
    if words and len(found) == 1:
        return list(_lines(found[0]))
    rows = tuple((m.name, m.material_class.name, *_cells(m), m.title) for m in found)
    header = ("material", "class", *(QUANTITIES[name][1] for name in _COLUMNS), "")
    caption = messages.LISTED(number=counted(len(found), "material"))
    parts: list[str | TextTable] = [TextTable(header, rows, caption)]
    if of_class:
        title = material_classes()[of_class].title
        parts.append(f"Typical of {title}: {typical_ranges(of_class)}.")
    return parts


def _cells(material: StartingMaterial) -> Iterator[str]:
    for name in _COLUMNS:
        value = material.published.get(name)
        yield "" if value is None else value.words


def _lines(material: StartingMaterial) -> Iterator[str]:
    known = material.material_class
    yield f"{material.name}: {material.title}, one of the class {known.name} ({known.title})."
    yield f"Other names: {', '.join(material.synonyms)}."
    if material.moisture:
        yield f"Moisture: {material.moisture}."
    yield from material.about
    for name, value in material.published.items():
        yield f"  {QUANTITIES[name][1]}: {value.words}"
        yield f"    {value.source}"
        yield f'    "{value.text}"'
    yield "A file begins with:"
    for section, values in material.sections.items():
        for key, entry in values.items():
            if entry.is_free or key == "diameter":
                yield f"  {section}.{key} = {entry.toml}"
                yield f"    {entry.source}"
    yield f"Begin with it: grainfit new FILE --material {material.name}"
