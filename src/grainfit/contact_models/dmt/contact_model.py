"""The contact model DMT: adhesion with a surface energy, in LAMMPS and YADE."""

from grainfit.contact_models.base import RESTITUTION_WITH_COHESION, ContactModel
from grainfit.contact_models.dmt.lammps import DmtLammps
from grainfit.contact_models.dmt.model import attraction
from grainfit.contact_models.dmt.yade import DmtYade
from grainfit.contact_models.jkr.contact_model import GAMMA, SURFACE_ENERGY
from grainfit.materials.equations import Equation

DMT = ContactModel(
    name="dmt",
    title="DMT adhesion",
    kind="cohesion",
    parameters=SURFACE_ENERGY,
    keywords=(DmtLammps(), DmtYade()),
    equations=(
        Equation("elastic force", "F_e = 4/3 E* a delta - 4 pi gamma R*"),
        Equation("pull-off force", "F_po = 4 pi gamma R*"),
    ),
    conventions=(GAMMA, RESTITUTION_WITH_COHESION),
    attraction=attraction,
)
