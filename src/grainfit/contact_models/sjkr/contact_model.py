"""The contact model SJKR: attraction by the true area of intersection, in LIGGGHTS."""

from __future__ import annotations

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.sjkr.liggghts import SJKR_LIGGGHTS
from grainfit.contact_models.sjkr.model import attraction
from grainfit.materials.parameters import CONTACTS, declare

#: Shared by SJKR and SJKR2.
COHESION_ENERGY_DENSITY = declare(
    CONTACTS,
    "cohesion_energy_density",
    "Ω",
    "J/m^3",
    "cohesion energy density",
    (0.0, 1e9),
    default=0.0,
    example='"20 kJ/m^3"',
)

SJKR = ContactModel(
    name="sjkr",
    kind="cohesion",
    parameters=COHESION_ENERGY_DENSITY,
    keywords=(SJKR_LIGGGHTS,),
    attraction=attraction,
)
