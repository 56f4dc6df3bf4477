"""The contact model Hertz-Mindlin: sliding friction and restitution, in every solver."""

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.hertz_mindlin.lammps import HertzMindlinLammps
from grainfit.contact_models.hertz_mindlin.liggghts import HERTZ_MINDLIN_LIGGGHTS
from grainfit.contact_models.hertz_mindlin.model import safe_time_step, step_factor
from grainfit.contact_models.hertz_mindlin.yade import HertzMindlinYade
from grainfit.materials.equations import Convention, Equation
from grainfit.materials.parameters import CONTACTS, declare

_EQUATIONS = (
    Equation("effective Young's modulus", "E* = 1/((1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2)"),
    Equation(
        "effective shear modulus",
        "G* = 1/(2 (2 - nu_1) (1 + nu_1)/E_1 + 2 (2 - nu_2) (1 + nu_2)/E_2)",
    ),
    Equation(
        "reduced radius",
        "R* = 1/(1/R_1 + 1/R_2)",
        "half the radius of two equal spheres, the radius of a sphere on a wall",
    ),
    Equation("reduced mass", "m* = 1/(1/m_1 + 1/m_2)"),
    Equation("contact radius", "a = sqrt(R* delta)"),
    Equation("elastic force", "F_e = 4/3 E* a delta"),
    Equation("damping factor", "beta = -ln(e)/sqrt(ln(e)^2 + pi^2)"),
    Equation("normal damping", "c_n = 2 sqrt(5/6) beta sqrt(2 E* a m*)"),
    Equation("normal force", "F = F_e + c_n v_n", "it may pull just before bodies part"),
    Equation("force that limits friction", "F_n = |F|"),
    Equation("tangential spring", "k_t = 8 G* a"),
    Equation("tangential damping", "c_t = 2 sqrt(5/6) beta sqrt(8 G* a m*)"),
    Equation("tangential force", "F_t = k_t xi + c_t v_t"),
    Equation(
        "sliding limit",
        "k_t xi <= mu F_n",
        "it limits the spring; the dashpot acts beside it while the contact sticks",
    ),
)
_CONVENTIONS = (
    Convention("youngs_modulus", "E", "of each body; E* is that of the contact"),
    Convention("poissons_ratio", "nu", "of each body"),
    Convention(
        "sliding_friction", "mu", "largest tangential force over F_n, the same at rest and sliding"
    ),
    Convention("restitution", "e", "speed after over speed before a normal impact, at every speed"),
)

HERTZ_MINDLIN = ContactModel(
    name="hertz_mindlin",
    title="Hertz-Mindlin contact",
    kind="contact",
    parameters=(
        *declare(
            CONTACTS,
            "sliding_friction",
            "μ",
            "",
            "sliding friction coefficient",
            (0.0, 10.0),
            example="0.18",
        ),
        *declare(
            CONTACTS,
            "restitution",
            "e",
            "",
            "coefficient of restitution",
            (0.01, 1.0),
            example="0.8",
        ),
    ),
    keywords=(HertzMindlinLammps(), HERTZ_MINDLIN_LIGGGHTS, HertzMindlinYade()),
    equations=_EQUATIONS,
    conventions=_CONVENTIONS,
    safe_time_step=safe_time_step,
    step_factor=step_factor,
)
