"""Classes of materials, with the ranges that stand in where nothing is published."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

_FILE = Path(__file__).with_name("material_classes.toml")


@dataclass(frozen=True)
class MaterialClass:
    """A class of materials; its ranges are wide, and of no source.

    Parameters
    ----------
    name, title : str
        As in the file of a material, and for people.
    words : tuple of str
        Words in the names of its materials.
    sliding_friction, rolling_friction : tuple of float
        Intervals to search.
    restitution, wall_friction : float
        Values to begin with.
    angle_of_repose : float
        Likewise, degrees.
    diameter : str
        Likewise, with its unit.
    shape : str
        Family of clumps that comes close to its particles; empty for none.
    coarse_graining : float
        Factor that fine particles may need; 0 for none.
    cohesion : str
        Largest surface energy of a search, with its unit; empty for none.
    """

    name: str
    title: str
    words: tuple[str, ...]
    sliding_friction: tuple[float, float]
    rolling_friction: tuple[float, float]
    restitution: float
    wall_friction: float
    angle_of_repose: float
    diameter: str
    shape: str = ""
    coarse_graining: float = 0.0
    cohesion: str = ""


@cache
def material_classes() -> Mapping[str, MaterialClass]:
    """Return all classes by name."""
    tables = tomllib.loads(_FILE.read_text(encoding="utf-8"))
    return {name: _class(name, one) for name, one in tables.items()}


def class_of_words(name: str) -> MaterialClass | None:
    """Return the class whose words are in a name; None if there are none.

    Examples
    --------
    >>> found = class_of_words("wood pellets")
    >>> found and found.name
    'pellets'
    """
    words = name.lower().replace("_", " ").replace("-", " ").split()
    # The last word is what a thing is: coffee powder is a powder.
    for word in reversed(words):
        for one in material_classes().values():
            if {word, word.removesuffix("s")} & {one.name, one.name.removesuffix("s"), *one.words}:
                return one
    return None


def _class(name: str, table: Mapping[str, Any]) -> MaterialClass:
    lists = ("words", "sliding_friction", "rolling_friction")
    given: dict[str, Any] = {k: tuple(v) if k in lists else v for k, v in table.items()}
    return MaterialClass(name, **given)
