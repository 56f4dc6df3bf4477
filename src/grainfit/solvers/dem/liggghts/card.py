"""Write a material card as a file that a LIGGGHTS deck includes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.liggghts import liggghts_model, liggghts_properties
from grainfit.materials.card import MaterialCard
from grainfit.materials.walls import material_on, on_wall
from grainfit.solvers.dem.card_clumps import clump_lines, liggghts_template
from grainfit.solvers.dem.card_parts import (
    fill_card,
    require_material,
    require_sizes,
    simulated_card,
    variables,
    walls_of_card,
)
from grainfit.solvers.dem.sphere_types import SphereTypes

_TAKEN = ("rayleigh_time_step", "recommended_time_step", "contact_model")
#: Young's moduli, Pa, beyond which LIGGGHTS requires a confirmation.
_SOFT = 5e6
_HARD = 1e9


def render_liggghts(card: MaterialCard) -> str:
    """Return the card for LIGGGHTS.

    Raises
    ------
    InputError
        A parameter that LIGGGHTS needs is missing or impossible.
    """
    card = simulated_card(card)
    values, law = require_material(card, "liggghts")
    named = list(variables(card.parameters, _TAKEN))
    # Parameters at their default are not in the card.
    texts = {name: str(value) for name, value in values.items()}
    texts |= {parameter.name: f"${{{name}}}" for name, parameter in named}
    walls = walls_of_card(card)
    walls_moduli = [values[on_wall("wall.youngs_modulus", wall)] for wall in walls]
    moduli = [values["particle.youngs_modulus"], *walls_moduli]
    contacts = _contacts(card, values, walls) if law.with_sizes("liggghts") else []
    return fill_card(
        "liggghts",
        card,
        {
            "clump": clump_lines(card.sizes, values["particle.density"], liggghts_template),
            "variables": named,
            "soft": min(moduli) < _SOFT,
            "hard": max(moduli) > _HARD,
            "contact_model": liggghts_model(law),
            "walls": walls,
            "properties": liggghts_properties(
                law, [material_on(texts, wall) for wall in walls], contacts
            ),
        },
    )


def _contacts(
    card: MaterialCard, values: Mapping[str, float], walls: Sequence[str]
) -> list[Contact]:
    """Return the contact of two particles, and those with the walls."""
    sphere = SphereTypes.mean_of(require_sizes(card, "liggghts"))
    on_walls = (material_on(values, wall) for wall in walls)
    return [
        sphere.between(values, 1, 1, card.gravity),
        *(sphere.on_wall(own, 1, card.gravity) for own in on_walls),
    ]
