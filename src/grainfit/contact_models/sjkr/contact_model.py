"""The contact model SJKR: attraction by the true area of intersection, in LIGGGHTS."""

from grainfit.contact_models.base import RESTITUTION_WITH_COHESION, ContactModel
from grainfit.contact_models.sjkr.liggghts import SJKR_LIGGGHTS
from grainfit.contact_models.sjkr.model import attraction
from grainfit.materials.equations import Convention, Equation
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

OMEGA = Convention(
    "cohesion_energy_density",
    "Omega",
    "attraction over area of contact A; it is no surface energy, and none follows from it",
)
#: Equations that SJKR and SJKR2 share.
ATTRACTION = (
    Equation("attraction", "F_c = Omega A"),
    Equation("normal force", "F = F_e + c_n v_n - F_c"),
    Equation("force that limits friction", "F_n = |F_e + c_n v_n|", "without the attraction"),
)

SJKR = ContactModel(
    name="sjkr",
    title="SJKR cohesion",
    kind="cohesion",
    parameters=COHESION_ENERGY_DENSITY,
    keywords=(SJKR_LIGGGHTS,),
    equations=(
        Equation(
            "plane of intersection",
            "x = (d^2 + R_1^2 - R_2^2)/(2 d)",
            "of a sphere on a wall, x is the distance of its centre from the wall",
        ),
        Equation("area of contact", "A = pi (R_1^2 - x^2)", "close to 2 pi R* delta"),
        *ATTRACTION,
    ),
    conventions=(OMEGA, RESTITUTION_WITH_COHESION),
    attraction=attraction,
)
