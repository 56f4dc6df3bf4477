"""The card as a Python module that a YADE script imports."""

from __future__ import annotations

from grainfit.contact_models.hertz_mindlin import model as contact
from grainfit.materials.card import MaterialCard
from grainfit.materials.card_text import about, header
from grainfit.solvers.dem.card_parts import (
    CONTACT_PARAMETERS,
    fill,
    origin,
    require_material,
    require_sizes,
)

#: YADE has nothing that would take these.
_UNUSED = (
    "particle_particle.rolling_damping",
    "particle_wall.rolling_damping",
    "particle_wall.rolling_friction",
)
_NEEDED = tuple(name for name in CONTACT_PARAMETERS if name not in _UNUSED)


def render_yade(card: MaterialCard) -> str:
    """Return the card for YADE.

    Raises
    ------
    InputError
        A parameter that YADE needs is missing or impossible, or the particles' size is not known.
    """
    material = require_material(card, "yade", _NEEDED)
    diameter = require_sizes(card, "yade").sauter_diameter
    radius = diameter / 2
    without_damping = {**material, "particle_particle.rolling_damping": 0.0}
    spring = contact.rolling_between_particles(without_damping, radius, radius, card.gravity)
    on_wall = material.get("particle_wall.rolling_friction")
    return fill(
        "yade",
        {
            "header": header(card),
            "origin": origin(card, "yade"),
            "card": card,
            "about": about,
            "quoted": repr,
            "diameter": diameter,
            "load": f"{contact.TYPICAL_LOAD:g}",
            "eta": material["particle_particle.rolling_friction"] / 2,
            # The spring of LAMMPS is a force with the lever R* = r / 2, that of YADE a moment.
            "krot": spring.stiffness * (radius / 2) ** 2,
            "instead": "" if on_wall is None else f", not of {on_wall!r}",
            "has_wall_density": "wall.density" in material,
        },
    )
