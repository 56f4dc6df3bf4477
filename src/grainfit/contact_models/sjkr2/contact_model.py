"""The contact model SJKR2: attraction by an approximate area, in LIGGGHTS."""

from grainfit.contact_models.base import RESTITUTION_WITH_COHESION, ContactModel
from grainfit.contact_models.sjkr.contact_model import ATTRACTION, COHESION_ENERGY_DENSITY, OMEGA
from grainfit.contact_models.sjkr2.liggghts import SJKR2_LIGGGHTS
from grainfit.contact_models.sjkr2.model import attraction
from grainfit.materials.equations import Equation

SJKR2 = ContactModel(
    name="sjkr2",
    title="SJKR2 cohesion",
    kind="cohesion",
    parameters=COHESION_ENERGY_DENSITY,
    keywords=(SJKR2_LIGGGHTS,),
    equations=(
        Equation("area of contact", "A = 4 pi R* delta", "2 pi R* delta on a wall"),
        *ATTRACTION,
    ),
    conventions=(OMEGA, RESTITUTION_WITH_COHESION),
    attraction=attraction,
)
