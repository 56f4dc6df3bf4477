"""Linear springs in the syntax of YADE: ``ViscElMat`` with stiffness and damping of each body."""

from __future__ import annotations

from collections.abc import Sequence

from grainfit.contact_models.base import Kind
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.linear.model import (
    damping_ratio_without_pull,
    normal_damping,
    springs,
    tangential_damping_ratio,
)
from grainfit.contact_models.yade import YadeArgument, YadeFunctors, YadeKeywords
from grainfit.materials.equations import Equation

_NOTES = """\
kn, ks, cn and cs are those of bodies, of which YADE makes those of contacts as of two springs in a
row: twice those of two particles; of walls what is missing to those of a contact, which may be
negative."""
#: In place of a coefficient of zero, which YADE takes for a rigid body.
_NONE = 1e-30


class LinearYade(YadeKeywords):
    """Bodies that give contacts the stiffness and damping of the law; no rolling resistance."""

    functors = YadeFunctors(
        "ViscElMat", "Ip2_ViscElMat_ViscElMat_ViscElPhys", "Law2_ScGeom_ViscElPhys_Basic"
    )
    beside: tuple[Kind, ...] = ()
    one_size = True
    difference = (
        "YADE lets no contact pull, so that its dashpots are stronger (a damping ratio of 0.074 "
        "instead of 0.071 at a restitution of 0.8, of 0.35 instead of 0.28 at 0.4)."
    )
    equations = (
        Equation(
            "damping factor",
            "beta = b",
            "b: the damping ratio with which impacts have the restitution e although F is never "
            "attractive, e = exp(-2 b acos(b)/sqrt(1 - b^2)) (Schwager & Poeschel 2007)",
        ),
        Equation("normal force", "F = max(F_e + c_n v_n, 0)"),
    )

    def particle(self, contact: Contact) -> Sequence[YadeArgument]:
        """Return the coefficients of a particle, given the contact of two."""
        return [YadeArgument(name, f"{2 * value}") for name, value in _coefficients(contact)]

    def wall(self, contact: Contact, particles: Contact) -> Sequence[YadeArgument]:
        """Return the coefficients of a wall, given its contact and that of two particles."""
        pairs = zip(_coefficients(contact), _coefficients(particles), strict=True)
        return [
            YadeArgument(name, f"{_missing(found, 2 * own)}") for (name, found), (_, own) in pairs
        ]

    def physics(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (names only)
        """Return the friction angle of all pairs."""
        return (YadeArgument("frictAngle", '_of_pairs("sliding_friction", atan)'),)

    def notes(self, contact: Contact) -> str:  # noqa: ARG002 (for all contacts)
        """Return the meaning of the coefficients in YADE, in lines of text."""
        return _NOTES


def _coefficients(contact: Contact) -> list[tuple[str, float]]:
    found = springs(contact)
    damping = normal_damping(contact, damping_ratio_without_pull(contact.value("restitution")))
    tangential = tangential_damping_ratio(contact) * damping
    return [("kn", found.normal), ("ks", found.tangential), ("cn", damping), ("cs", tangential)]


def _missing(wanted: float, own: float) -> float:
    """Return the coefficient that is, in a row with that of a particle, a wanted one."""
    if not own:
        return wanted
    rest = 1 / wanted - 1 / own if wanted else 1 / _NONE
    return 1 / (rest or _NONE)
