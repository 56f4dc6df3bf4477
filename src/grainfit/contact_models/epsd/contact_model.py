"""The contact model EPSD: rolling friction and rolling damping, in every solver."""

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.epsd.lammps import EpsdLammps
from grainfit.contact_models.epsd.liggghts import EPSD_LIGGGHTS
from grainfit.contact_models.epsd.model import safe_time_step
from grainfit.contact_models.epsd.yade import EpsdYade
from grainfit.materials.equations import Convention, Equation
from grainfit.materials.parameters import CONTACTS, declare

#: Shared by the rolling models.
ROLLING_FRICTION = declare(
    CONTACTS,
    "rolling_friction",
    "μ_r",
    "",
    "rolling friction coefficient",
    (0.0, 10.0),
    example="{ min = 0.2, max = 1.0 }",
)
ROLLING_FRICTION_CONVENTION = Convention(
    "rolling_friction",
    "mu_r",
    "largest rolling torque over F_n R*, with the reduced radius R*, not the radius",
)

_ROLLING_DAMPING = declare(
    CONTACTS,
    "rolling_damping",
    "η_r",
    "",
    "viscous rolling damping ratio",
    (0.0, 1.0),
    example="0",
)

_EQUATIONS = (
    Equation("normal stiffness", "k_n = 4/3 E* a"),
    Equation("rolling spring", "k_r = 2.25 k_n (mu_r R*)^2"),
    Equation("inertia of rolling", "I_r = 7/5/(1/(m_1 R_1^2) + 1/(m_2 R_2^2))"),
    Equation("rolling damping", "c_r = 2 eta_r sqrt(I_r k_r)"),
    Equation("rolling torque", "M_r = k_r theta + c_r omega_r"),
    Equation(
        "rolling limit",
        "k_r theta <= mu_r R* F_n",
        "it limits the spring; the dashpot acts beside it until the limit is reached",
    ),
)

EPSD = ContactModel(
    name="epsd",
    title="EPSD rolling friction",
    kind="rolling",
    parameters=(
        *ROLLING_FRICTION,
        *_ROLLING_DAMPING,
    ),
    keywords=(EpsdLammps(), EPSD_LIGGGHTS, EpsdYade()),
    equations=_EQUATIONS,
    conventions=(
        ROLLING_FRICTION_CONVENTION,
        Convention("rolling_damping", "eta_r", "damping of rolling over the critical damping"),
    ),
    dashpots=tuple(parameter.name for parameter in _ROLLING_DAMPING),
    safe_time_step=safe_time_step,
)
