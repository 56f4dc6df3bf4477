"""Walls with names: the parameters of each of several walls.

``wall.steel.youngs_modulus`` is that of the wall called steel, and ``wall.youngs_modulus`` that of
the plain wall, which has no name: ``""``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

Value = TypeVar("Value")

#: Sections that every wall has.
WALL_SECTIONS = ("wall", "particle_wall")
#: The wall without a name.
PLAIN = ""


def _parts(name: str) -> tuple[str, str, str] | None:
    """Section, wall and key of a parameter of a wall; None for other parameters."""
    section, *rest = name.split(".")
    if section not in WALL_SECTIONS or not 1 <= len(rest) <= 2:
        return None
    return section, rest[0] if len(rest) == 2 else PLAIN, rest[-1]


def wall_of(name: str) -> str | None:
    """Return the wall that a parameter belongs to; None for one of the particles.

    Examples
    --------
    >>> wall_of("wall.steel.density"), wall_of("wall.density"), wall_of("particle.density")
    ('steel', '', None)
    """
    parts = _parts(name)
    return None if parts is None else parts[1]


def plain_name(name: str) -> str:
    """Return the name of a parameter without its wall.

    Examples
    --------
    >>> plain_name("particle_wall.steel.restitution")
    'particle_wall.restitution'
    """
    parts = _parts(name)
    return name if parts is None else f"{parts[0]}.{parts[2]}"


def on_wall(name: str, wall: str) -> str:
    """Return the name that a parameter of the plain wall has for another wall.

    Examples
    --------
    >>> on_wall("particle_wall.restitution", "steel"), on_wall("particle.density", "steel")
    ('particle_wall.steel.restitution', 'particle.density')
    """
    parts = _parts(name)
    if parts is None or not wall:
        return name
    return f"{parts[0]}.{wall}.{parts[2]}"


def walls_among(names: Iterable[str]) -> tuple[str, ...]:
    """Return the walls that some parameters belong to, each once."""
    found = (wall_of(name) for name in names)
    return tuple(dict.fromkeys(wall for wall in found if wall is not None))


def same_on_walls(name: str, names: Iterable[str]) -> list[str]:
    """Return those names that are of one parameter, on any wall."""
    return [one for one in names if plain_name(one) == name]


def material_on(material: Mapping[str, Value], wall: str) -> dict[str, Value]:
    """Return the parameters of the particles and of one wall, by plain names.

    Values are numbers, or texts that stand for them.
    """
    return {
        plain_name(name): value for name, value in material.items() if wall_of(name) in (None, wall)
    }


def parameters_of(material: Mapping[str, float], wall: str) -> dict[str, float]:
    """Return the parameters of one wall alone, by plain names."""
    return {plain_name(name): value for name, value in material.items() if wall_of(name) == wall}


def with_plain_wall(material: Mapping[str, float], walls: Sequence[str]) -> dict[str, float]:
    """Return a material by plain names, with a plain wall even where nothing is made of it.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name.
    walls : sequence of str
        Walls that there are: without the plain one, the first of them stands for it, and without
        any, the particles do.
    """
    if walls:
        return material_on(material, PLAIN if PLAIN in walls else walls[0])
    sections = {"particle": "wall", "particle_particle": "particle_wall"}
    like_particles = {
        f"{sections[section]}.{key}": value
        for name, value in material.items()
        for section, _, key in (name.partition("."),)
        if section in sections
    }
    return {**like_particles, **material}
