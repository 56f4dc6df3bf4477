"""The contact model EPSD2: rolling friction without rolling damping, in every solver."""

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.epsd.contact_model import ROLLING_FRICTION, ROLLING_FRICTION_CONVENTION
from grainfit.contact_models.epsd2.lammps import Epsd2Lammps
from grainfit.contact_models.epsd2.liggghts import EPSD2_LIGGGHTS
from grainfit.contact_models.epsd2.yade import Epsd2Yade
from grainfit.materials.equations import Equation

EPSD2 = ContactModel(
    name="epsd2",
    title="EPSD2 rolling friction",
    kind="rolling",
    parameters=ROLLING_FRICTION,
    keywords=(Epsd2Lammps(), EPSD2_LIGGGHTS, Epsd2Yade()),
    equations=(
        Equation("rolling spring", "k_r = k_t R*^2"),
        Equation("rolling torque", "M_r = k_r theta"),
        Equation("rolling limit", "|M_r| <= mu_r R* F_n"),
    ),
    conventions=(ROLLING_FRICTION_CONVENTION,),
)
