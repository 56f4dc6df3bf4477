"""Write a material card as a Python module that a YADE script imports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.yade import (
    YadeArgument,
    yade_body,
    yade_keywords,
    yade_law,
    yade_on_wall,
    yade_physics,
)
from grainfit.formatting import without_noise
from grainfit.materials.card import MaterialCard
from grainfit.materials.clumps import Clump
from grainfit.materials.walls import material_on, on_wall
from grainfit.solvers.dem.card_clumps import card_clumps, clump_comments
from grainfit.solvers.dem.card_parts import (
    fill_card,
    model_notes,
    require_material,
    require_sizes,
    simulated_card,
    walls_of_card,
)
from grainfit.solvers.dem.sphere_types import SphereTypes
from grainfit.solvers.dem.yade.clump_shares import clump_shares


class _Wall(NamedTuple):
    """A wall in the card.

    Parameters
    ----------
    variable, body, contact : str
        Name of its variable, and its sections.
    has_density : bool
        Whether its density is known.
    arguments : list of YadeArgument
        Of its material.
    attributes : list of YadeArgument
        What its contacts get that no functor gives them.
    """

    variable: str
    body: str
    contact: str
    has_density: bool
    arguments: Sequence[YadeArgument]
    attributes: list[YadeArgument]


def _wall(
    name: str,
    law: ContactLaw,
    material: Mapping[str, float],
    sphere: SphereTypes,
    particles: Contact,
) -> _Wall:
    body, contact = (
        on_wall(f"{section}.", name).removesuffix(".") for section in ("wall", "particle_wall")
    )
    values = material_on(material, name)
    touching = sphere.on_wall(values, 1, particles.gravity)
    return _Wall(
        f"wall_{name}" if name else "wall",
        body,
        contact,
        f"{body}.density" in material,
        yade_body(law).wall(touching, particles),
        yade_on_wall(law, touching),
    )


def _weights(clump: Clump) -> list[float]:
    return [without_noise(weight, size=1.0) for weight in clump_shares(clump).weights]


def render_yade(card: MaterialCard) -> str:
    """Return the card for YADE.

    Raises
    ------
    InputError
        A parameter that YADE needs is missing or impossible, or the particles' size is not known.
    """
    card = simulated_card(card)
    material, law = require_material(card, "yade")
    sizes = require_sizes(card, "yade")
    sphere = SphereTypes.mean_of(sizes)
    contact = sphere.between(material, 1, 1, card.gravity)
    keywords, body = yade_keywords(law), yade_body(law)
    walls = [_wall(wall, law, material, sphere, contact) for wall in walls_of_card(card)]
    return fill_card(
        "yade",
        card,
        {
            "clump_comments": clump_comments(sizes),
            "clumps": card_clumps(sizes, material["particle.density"]),
            "weights": None if sizes.clump is None else _weights(sizes.clump),
            "quoted": repr,
            "notes": model_notes(found.notes(contact) for found in keywords),
            "physics": yade_physics(law, contact),
            "law": ", ".join(f"{name}={value}" for name, value, _ in yade_law(law, contact)),
            "walls": walls,
            "set_on_walls": any(wall.attributes for wall in walls),
            "functors": body.functors,
            "particle": body.particle(contact),
        },
    )
