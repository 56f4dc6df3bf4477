"""Write a material card as a Python module that a YADE script imports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.yade import yade_law, yade_physics, yade_words
from grainfit.materials.card import MaterialCard
from grainfit.materials.card_text import about, header
from grainfit.materials.walls import on_wall
from grainfit.solvers.dem.card_clumps import clump_lines, yade_clump
from grainfit.solvers.dem.card_parts import (
    comments,
    fill,
    origin,
    require_material,
    require_sizes,
    walls_of_card,
)


class _Wall(NamedTuple):
    """A wall in the card: name of its variable, its sections, and whether its density is known."""

    variable: str
    body: str
    contact: str
    has_density: bool


def _wall(name: str, material: Mapping[str, float]) -> _Wall:
    body, contact = (
        on_wall(f"{section}.", name).removesuffix(".") for section in ("wall", "particle_wall")
    )
    return _Wall(f"wall_{name}" if name else "wall", body, contact, f"{body}.density" in material)


def render_yade(card: MaterialCard) -> str:
    """Return the card for YADE.

    Raises
    ------
    InputError
        A parameter that YADE needs is missing or impossible, or the particles' size is not known.
    """
    material, law = require_material(card, "yade")
    radius = require_sizes(card, "yade").sauter_diameter / 2
    contact = Contact.between(material, radius, radius, card.gravity)
    words = yade_words(law)
    return fill(
        "yade",
        {
            "header": header(card),
            "origin": origin(card, "yade"),
            "card": card,
            "clump": clump_lines(card.sizes, material["particle.density"], yade_clump),
            "about": about,
            "quoted": repr,
            "notes": comments(found.notes(contact) for found in words),
            "physics": yade_physics(law, contact),
            "law": ", ".join(f"{name}={value}" for name, value, _ in yade_law(law, contact)),
            "walls": [_wall(wall, material) for wall in walls_of_card(card)],
        },
    )
