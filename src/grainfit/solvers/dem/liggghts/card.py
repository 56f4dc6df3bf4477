"""The card as a file that a LIGGGHTS deck includes."""

from __future__ import annotations

from grainfit.materials.card import MaterialCard
from grainfit.materials.card_text import about, header
from grainfit.solvers.dem.card_parts import fill, origin, require_material, variables

_MATRICES = {
    "coefficientRestitution": "restitution",
    "coefficientFriction": "sliding_friction",
    "coefficientRollingFriction": "rolling_friction",
    "coefficientRollingViscousDamping": "rolling_damping",
}
_TAKEN = ("rayleigh_time_step", "recommended_time_step", "contact_model")
#: Young's moduli, Pa, beyond which LIGGGHTS wants to be told that they are meant.
_SOFT = 5e6
_HARD = 1e9


def render_liggghts(card: MaterialCard) -> str:
    """Return the card for LIGGGHTS.

    Raises
    ------
    InputError
        A parameter that LIGGGHTS needs is missing or impossible.
    """
    values = require_material(card, "liggghts")
    moduli = values["particle.youngs_modulus"], values["wall.youngs_modulus"]
    return fill(
        "liggghts",
        {
            "header": header(card),
            "origin": origin(card, "liggghts"),
            "card": card,
            "variables": list(variables(card.parameters, _TAKEN)),
            "about": about,
            "soft": min(moduli) < _SOFT,
            "hard": max(moduli) > _HARD,
            "matrices": _MATRICES,
        },
    )
