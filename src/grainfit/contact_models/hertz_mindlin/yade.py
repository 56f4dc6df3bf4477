"""Hertz-Mindlin in the syntax of YADE: restitution and friction angle of the ``Ip2`` functor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import particle_moduli
from grainfit.contact_models.yade import YadeArgument, YadeFunctors, YadeKeywords
from grainfit.materials.equations import Equation

#: R* of a particle on a wall in YADE over its radius; on a ``Facet`` it is two thirds.
WALL_RADIUS_SHARE = 1 / 2
#: 1/Pa: a body that hardly deforms, in place of one that does not at all.
_LEAST_COMPLIANCE = 1e-30


class HertzMindlinYade(YadeKeywords):
    """``en`` and ``frictAngle`` of ``Ip2_FrictMat_FrictMat_MindlinPhys``."""

    functors = YadeFunctors(
        "FrictMat", "Ip2_FrictMat_FrictMat_MindlinPhys", "Law2_ScGeom_MindlinPhys_Mindlin"
    )
    difference = (
        "YADE keeps the tangential force while a contact unloads: steep impacts, which stick (5° "
        "from the normal), rebound with up to 11 % less tangential speed, and contacts that stick "
        "lose more energy."
    )
    equations = (
        Equation(
            "damping factor",
            "b = sqrt(1/(1 - (1 + e)^2 exp(h)) - 1)",
            "h: a polynomial of e, with which impacts have the restitution e although F is never "
            "attractive (Thornton et al. 2013, eq. B7)",
        ),
        Equation("normal damping", "c_n = 2 b sqrt(2 E* a m*)"),
        Equation("normal force", "F = max(F_e + c_n v_n, 0)"),
        Equation("tangential damping", "c_t = 2 b sqrt(8 G* a m*)"),
        Equation(
            "tangential force",
            "F_t = F_s + c_t v_t",
            "F_s: sum of the increments k_t dxi, which stay while the contact unloads",
        ),
        Equation(
            "sliding limit",
            "F_s <= mu F_n",
            "it limits the spring; the dashpot acts beside it while the contact sticks",
        ),
    )

    def particle(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (names only)
        """Return the elasticity of the particles."""
        return (
            YadeArgument("young", 'PARAMETERS["particle.youngs_modulus"]'),
            YadeArgument("poisson", 'PARAMETERS["particle.poissons_ratio"]'),
        )

    def wall(self, contact: Contact, particles: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002
        """Return the elasticity with which contacts are as stiff as those with the real wall."""
        young = wall_modulus(contact.material)
        return (
            YadeArgument("young", f"{young}", "Pa, not that of the real wall: see above"),
            YadeArgument("poisson", f"{contact.material['particle.poissons_ratio']}"),
        )

    def physics(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (names only)
        """Return restitution and friction angle of all pairs."""
        return (
            YadeArgument("en", '_of_pairs("restitution")'),
            YadeArgument("frictAngle", '_of_pairs("sliding_friction", atan)'),
        )

    def notes(self, contact: Contact) -> str:  # noqa: ARG002 (for all contacts)
        """Return the meaning of the parameters in YADE, in lines of text."""
        return (
            "Young's modulus, Poisson's ratio, density, sliding friction and restitution mean the "
            "same in YADE."
        )


def wall_modulus(material: Mapping[str, float], radius_share: float = WALL_RADIUS_SHARE) -> float:
    """Return the Young's modulus that gives contacts with a wall their stiffness in YADE, Pa.

    YADE takes R* of a particle on a wall as a share of its radius, so that contacts would be
    sqrt(share) times as stiff. A wall with this modulus and the Poisson's ratio of the particles
    has E* sqrt(R*) of the particle on the real wall. It is negative for a wall that does not
    deform: then E* must be above that of a rigid wall.

    Parameters
    ----------
    material : mapping of str to float
        All material parameters by dotted name.
    radius_share : float
        R* of YADE over the radius.
    """
    wanted = particle_moduli(material, "wall").young / radius_share**0.5
    flatness = 1 - material["particle.poissons_ratio"] ** 2
    compliance = 1 / wanted - flatness / material["particle.youngs_modulus"]
    return flatness / (compliance or _LEAST_COMPLIANCE)
