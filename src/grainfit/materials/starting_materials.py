"""Starting materials: values and intervals to begin a calibration with, and their sources.

Each is a TOML file of the folder ``starting``, with its ``class``, ``synonyms`` and ``moisture``.
Tables below ``published`` are what public texts say. Some files have a table for each parameter
beside them, with its ``value`` as a calibration file takes it and its ``source``; of the others,
parameters follow from what is published and from their class. None of them is calibrated for
anybody's material. Tables below ``suggested`` are parameters that the file has as comments.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from grainfit.errors import InputError
from grainfit.materials import messages
from grainfit.materials.from_published import (
    example_targets_of,
    remarks_on,
    sections_of,
    suggested_of,
)
from grainfit.materials.material_classes import MaterialClass, class_of_words, material_classes
from grainfit.materials.published_values import QUANTITIES, PublishedValue, read_published
from grainfit.materials.starting_values import Sections, StartingValue

_FOLDER = Path(__file__).with_name("starting")
_SECTIONS = ("particle", "wall", "particle_particle", "particle_wall")


@dataclass(frozen=True)
class StartingMaterial:
    """A material to start from.

    Parameters
    ----------
    name, title : str
        Name of its file, and its name for people.
    about : tuple of str
        Lines on what its values stand for.
    example_targets : mapping of str to str
        Typical responses, to be replaced by measurements.
    sections : mapping of str to mapping of str to StartingValue
        Parameters by section and key of the calibration file.
    suggested : mapping of str to mapping of str to StartingValue
        Likewise, parameters for particles that are no dry spheres: comments in the file.
    material_class : MaterialClass
        Its class.
    synonyms : tuple of str
        Other names.
    moisture : str
        That of the published values, where a text says it.
    published : mapping of str to PublishedValue
        What public texts say, by quantity.
    """

    name: str
    title: str
    about: tuple[str, ...]
    example_targets: Mapping[str, str]
    sections: Sections
    suggested: Sections
    material_class: MaterialClass
    synonyms: tuple[str, ...]
    moisture: str
    published: Mapping[str, PublishedValue]

    @property
    def published_lines(self) -> list[str]:
        """What is published, a line for each quantity with its source."""
        moisture = [f"moisture: {self.moisture}"] if self.moisture else []
        return moisture + [
            f"{QUANTITIES[name][1]}: {value.words} ({value.source})"
            for name, value in self.published.items()
        ]

    @property
    def names(self) -> tuple[str, ...]:
        """Its name, title and synonyms, in lower case with spaces."""
        return tuple(map(_plain, (self.name, self.title, *self.synonyms)))

    def matches(self, word: str) -> bool:
        """Return whether a text is in its names or its class."""
        return any(_plain(word) in text for text in (*self.names, self.material_class.name))

    def has_word(self, word: str) -> bool:
        """Return whether a whole word, singular or plural, is in its names."""
        words = {part.strip("(),") for text in self.names for part in text.split()}
        return bool({word, word.removesuffix("s"), f"{word}s"} & words)


def starting_material_names() -> tuple[str, ...]:
    """Return the names of all starting materials."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def read_starting_material(name: str) -> StartingMaterial:
    """Read a starting material.

    Parameters
    ----------
    name : str
        One of `starting_material_names`, a synonym, or one word of its name, such as ``sand``;
        spaces and hyphens are as good as underscores.

    Raises
    ------
    InputError
        There is no such material; the fault has the nearest ones and the ranges of their class.
    """
    stem = _stem_of(name)
    if not stem:
        instead = near_materials(name)
        raise InputError(
            messages.NO_STARTING_MATERIAL.fault("material", name=name, instead=instead)
        )
    return _read(stem)


def material_of_class(of_class: MaterialClass, title: str) -> StartingMaterial:
    """Return a material of which nothing is published: all of it is usual for its class."""
    return StartingMaterial(
        name=of_class.name,
        title=title,
        about=tuple(remarks_on({}, of_class)),
        example_targets=example_targets_of({}, of_class),
        sections=sections_of({}, of_class),
        suggested=suggested_of(of_class),
        material_class=of_class,
        synonyms=(),
        moisture="",
        published={},
    )


def near_materials(name: str) -> str:
    """Return what is near an unknown material: names, and what its class usually has."""
    near, known = _sharing_a_word(name), class_of_words(name)
    if not near:
        near = _written_alike(name) if known is None else materials_like(of_class=known.name)
    if known is None and near:
        known = near[0].material_class
    if known is None:
        return messages.NOTHING_NEAR()
    names, ranges = ", ".join(m.name for m in near), typical_ranges(known.name)
    return messages.NEAR_MATERIALS(names=names, title=known.title, ranges=ranges)


def materials_like(words: str = "", of_class: str = "") -> list[StartingMaterial]:
    """Return the materials that have all words in their names, synonyms or class.

    Parameters
    ----------
    words : str
        Any words; all materials without them.
    of_class : str
        Name of a class; all classes without it.

    Raises
    ------
    InputError
        There is no such class.
    """
    known = material_classes()
    if of_class and of_class not in known:
        raise InputError(messages.NO_CLASS.fault("--class", name=of_class, known=", ".join(known)))
    return [
        material
        for material in map(_read, starting_material_names())
        if of_class in ("", material.material_class.name)
        and all(material.matches(word) for word in words.split())
    ]


def typical_ranges(of_class: str) -> str:
    """Return the ranges that the materials of a class have, in words."""
    members, known = materials_like(of_class=of_class), material_classes()[of_class]
    parts = []
    for name in ("diameter", "density", "bulk_density", "angle_of_repose", "wall_friction"):
        found = [material.published[name] for material in members if name in material.published]
        if found:
            low = min(value.high if value.low is None else value.low for value in found)
            whole = PublishedValue(low, max(value.high for value in found), found[0].unit, "", "")
            parts.append(f"{QUANTITIES[name][1]} {whole.shown}")
    for name, (low, high) in (
        ("sliding", known.sliding_friction),
        ("rolling", known.rolling_friction),
    ):
        parts.append(f"{name} friction to search {low:g} to {high:g}")
    return ", ".join(parts)


def _sharing_a_word(name: str) -> list[StartingMaterial]:
    words = [word for word in _plain(name).split() if len(word) > 2]
    return [m for m in materials_like() if any(m.has_word(word) for word in words)]


def _written_alike(name: str) -> list[StartingMaterial]:
    names = {text: material for material in materials_like() for text in material.names}
    alike = get_close_matches(_plain(name)[:64], names, n=4, cutoff=0.7)
    return list({names[found].name: names[found] for found in alike}.values())


def _stem_of(name: str) -> str:
    known = starting_material_names()
    wanted = _plain(name)
    stem = wanted.replace(" ", "_")
    if stem in known:
        return stem
    alike = [material.name for material in materials_like() if wanted in material.names]
    if len(alike) != 1:
        # One word is enough where it says which: sand, plastic.
        alike = [other for other in known if stem in other.split("_")]
    return alike[0] if len(alike) == 1 else ""


def _plain(text: str) -> str:
    return " ".join(text.lower().replace("-", " ").replace("_", " ").split())


@cache
def _read(stem: str) -> StartingMaterial:
    data = tomllib.loads((_FOLDER / f"{stem}.toml").read_text(encoding="utf-8"))
    of_class = material_classes()[data["class"]]
    published = read_published(data.get("published", {}))
    own = {name: data[name] for name in _SECTIONS if name in data}
    about = tuple(data.get("about", ()))
    return StartingMaterial(
        name=stem,
        title=data["title"],
        about=about if own else (*about, *remarks_on(published, of_class)),
        example_targets=data.get("example_targets") or example_targets_of(published, of_class),
        sections=_values(own) if own else sections_of(published, of_class),
        suggested=_values(data.get("suggested", {})) if own else suggested_of(of_class),
        material_class=of_class,
        synonyms=tuple(data["synonyms"]),
        moisture=data.get("moisture", ""),
        published=published,
    )


def _values(sections: Mapping[str, Any]) -> Sections:
    return {
        section: {key: StartingValue(**entry) for key, entry in entries.items()}
        for section, entries in sections.items()
    }
