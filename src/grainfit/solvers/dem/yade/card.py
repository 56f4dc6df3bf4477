"""Write a material card as a Python module that a YADE script imports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.hertz_mindlin.yade import wall_modulus
from grainfit.contact_models.yade import (
    YadeArgument,
    yade_keywords,
    yade_law,
    yade_on_wall,
    yade_physics,
)
from grainfit.materials.card import MaterialCard
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
    young : float
        Young's modulus that gives contacts on a ``Wall`` their stiffness, Pa.
    attributes : list of YadeArgument
        What its contacts get that no functor gives them.
    """

    variable: str
    body: str
    contact: str
    has_density: bool
    young: float
    attributes: list[YadeArgument]


def _wall(
    name: str, law: ContactLaw, material: Mapping[str, float], sphere: SphereTypes, gravity: float
) -> _Wall:
    body, contact = (
        on_wall(f"{section}.", name).removesuffix(".") for section in ("wall", "particle_wall")
    )
    values = material_on(material, name)
    return _Wall(
        f"wall_{name}" if name else "wall",
        body,
        contact,
        f"{body}.density" in material,
        wall_modulus(values),
        yade_on_wall(law, sphere.on_wall(values, 1, gravity)),
    )


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
    keywords = yade_keywords(law)
    return fill_card(
        "yade",
        card,
        {
            "clump_comments": clump_comments(sizes),
            "clumps": card_clumps(sizes, material["particle.density"]),
            "weights": None if sizes.clump is None else clump_shares(sizes.clump).weights,
            "quoted": repr,
            "notes": model_notes(found.notes(contact) for found in keywords),
            "physics": yade_physics(law, contact),
            "law": ", ".join(f"{name}={value}" for name, value, _ in yade_law(law, contact)),
            "walls": [
                _wall(wall, law, material, sphere, card.gravity) for wall in walls_of_card(card)
            ],
        },
    )
