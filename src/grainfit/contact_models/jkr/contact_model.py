"""The contact model JKR: adhesion with a surface energy, in LAMMPS."""

from grainfit.contact_models.base import RESTITUTION_WITH_COHESION, ContactModel
from grainfit.contact_models.jkr.lammps import JkrLammps
from grainfit.contact_models.jkr.model import attraction
from grainfit.materials.equations import Convention, Equation
from grainfit.materials.parameters import CONTACTS, declare

#: Shared by JKR and DMT.
SURFACE_ENERGY = declare(
    CONTACTS,
    "surface_energy",
    "γ",
    "J/m^2",
    "surface energy, half the work of adhesion",
    (0.0, 1e3),
    default=0.0,
    example='"0.05 J/m^2"',
    coarse_graining_power=1.0,
)

GAMMA = Convention(
    "surface_energy",
    "gamma",
    "half the work of adhesion of the two surfaces that touch, not all of it",
)

JKR = ContactModel(
    name="jkr",
    title="JKR adhesion",
    kind="cohesion",
    parameters=SURFACE_ENERGY,
    keywords=(JkrLammps(),),
    equations=(
        Equation(
            "contact radius",
            "delta = a^2/R* - sqrt(4 pi gamma a/E*)",
            "a: the larger of the two of an overlap",
        ),
        Equation("elastic force", "F_e = 4 E* a^3/(3 R*) - sqrt(16 pi gamma E* a^3)"),
        Equation(
            "pull-off force",
            "F_po = 3 pi gamma R*",
            "8/9 of it on a wall, where LAMMPS ends the contact at an overlap of zero",
        ),
    ),
    conventions=(GAMMA, RESTITUTION_WITH_COHESION),
    attraction=attraction,
)
