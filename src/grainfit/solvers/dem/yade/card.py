"""Write a material card as a Python module that a YADE script imports."""

from __future__ import annotations

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.yade import yade_law, yade_physics, yade_words
from grainfit.materials.card import MaterialCard
from grainfit.materials.card_text import about, header
from grainfit.solvers.dem.card_clumps import clump_lines, yade_clump
from grainfit.solvers.dem.card_parts import (
    comments,
    fill,
    origin,
    require_material,
    require_sizes,
)


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
            "has_wall_density": "wall.density" in material,
        },
    )
