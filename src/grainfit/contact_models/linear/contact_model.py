"""The contact model of linear springs and dashpots, in every solver."""

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.hertz_mindlin.contact_model import HERTZ_MINDLIN
from grainfit.contact_models.linear.lammps import LinearLammps
from grainfit.contact_models.linear.liggghts import LINEAR_LIGGGHTS
from grainfit.contact_models.linear.model import safe_time_step, springs, step_factor
from grainfit.contact_models.linear.yade import LinearYade
from grainfit.materials.equations import Convention, Equation
from grainfit.materials.parameters import CONTACTS, declare

#: In place of terms of Hertz and Mindlin; the others are the same.
_OWN = {
    "contact radius": (
        Equation("radius of the springs", "r = min(R_1, R_2)"),
        Equation("normal stiffness", "k_n = 2 E* r", "or k_n_given, where it is not 0"),
    ),
    "elastic force": (Equation("elastic force", "F_e = k_n delta"),),
    "normal damping": (Equation("normal damping", "c_n = 2 beta sqrt(k_n m*)"),),
    "tangential spring": (
        Equation("tangential spring", "k_t = 4 G*/E* k_n", "or k_t_given, where it is not 0"),
    ),
    "tangential damping": (Equation("tangential damping", "c_t = 2 beta sqrt(k_t m*)"),),
}
_EQUATIONS = tuple(
    equation for one in HERTZ_MINDLIN.equations for equation in _OWN.get(one.term, (one,))
)
_STIFFNESS_LIMITS = (0.0, 1e12)

LINEAR = ContactModel(
    name="linear",
    title="linear springs and dashpots",
    kind="contact",
    parameters=(
        *HERTZ_MINDLIN.parameters,
        *declare(
            CONTACTS,
            "normal_stiffness",
            "k_n",
            "N/m",
            "normal stiffness; 0: from Young's moduli",
            _STIFFNESS_LIMITS,
            default=0.0,
            example='"1e4 N/m"',
            coarse_graining_power=1.0,
        ),
        *declare(
            CONTACTS,
            "tangential_stiffness",
            "k_t",
            "N/m",
            "tangential stiffness; 0: from the normal one and Poisson's ratios",
            _STIFFNESS_LIMITS,
            default=0.0,
            example='"3e3 N/m"',
            coarse_graining_power=1.0,
        ),
    ),
    keywords=(LinearLammps(), LINEAR_LIGGGHTS, LinearYade()),
    equations=_EQUATIONS,
    conventions=(
        *HERTZ_MINDLIN.conventions,
        Convention(
            "normal_stiffness", "k_n_given", "k_n of every contact, of spheres of any size; 0: none"
        ),
        Convention("tangential_stiffness", "k_t_given", "k_t of every contact; 0: none"),
    ),
    safe_time_step=safe_time_step,
    step_factor=step_factor,
    springs=springs,
)
