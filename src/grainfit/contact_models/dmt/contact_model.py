"""The contact model DMT: adhesion with a surface energy, in LAMMPS and YADE."""

from __future__ import annotations

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.dmt.lammps import DmtLammps
from grainfit.contact_models.dmt.model import attraction
from grainfit.contact_models.dmt.yade import DmtYade
from grainfit.contact_models.jkr.contact_model import SURFACE_ENERGY

DMT = ContactModel(
    name="dmt",
    kind="cohesion",
    parameters=SURFACE_ENERGY,
    keywords=(DmtLammps(), DmtYade()),
    attraction=attraction,
)
