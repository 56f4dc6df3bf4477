"""The contact model JKR: adhesion with a surface energy, in LAMMPS."""

from __future__ import annotations

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.jkr.lammps import JkrLammps
from grainfit.contact_models.jkr.model import attraction
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

JKR = ContactModel(
    name="jkr",
    kind="cohesion",
    parameters=SURFACE_ENERGY,
    keywords=(JkrLammps(),),
    attraction=attraction,
)
