"""The contact model SJKR2: attraction by an approximate area, in LIGGGHTS."""

from __future__ import annotations

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.sjkr.contact_model import COHESION_ENERGY_DENSITY
from grainfit.contact_models.sjkr2.liggghts import SJKR2_LIGGGHTS
from grainfit.contact_models.sjkr2.model import attraction

SJKR2 = ContactModel(
    name="sjkr2",
    kind="cohesion",
    parameters=COHESION_ENERGY_DENSITY,
    keywords=(SJKR2_LIGGGHTS,),
    attraction=attraction,
)
