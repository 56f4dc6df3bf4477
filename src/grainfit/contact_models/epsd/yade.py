"""EPSD in the syntax of YADE: ``eta`` and ``krot`` of the ``Ip2`` functor, without dashpot."""

from __future__ import annotations

from collections.abc import Sequence

from grainfit.contact_models.contact import TYPICAL_LOAD, Contact
from grainfit.contact_models.epsd.model import rolling_spring_of
from grainfit.contact_models.yade import YadeArgument, YadeKeywords
from grainfit.materials.equations import Equation

_NOTES = """\
Rolling: YADE has one krot (the k_r above) and one eta for all contacts. Here they are those of two
particles with a diameter of {diameter} m."""
#: Limit of the moment of both rolling models.
ROLLING_LIMIT = Equation(
    "rolling limit",
    "|M_r| <= eta (R_1 + R_2)/2 |F|",
    "eta: mu_r/2, so that it is mu_r R* |F| of two equal spheres, and on a wall",
)
#: When the rolling spring is taken, which is a constant.
CONSTANT = f"at F_e of {TYPICAL_LOAD:g} particle weights, between particles of mean size"


class EpsdYade(YadeKeywords):
    """One rolling stiffness and one limit of the moment, those of two equal particles."""

    difference = "Rolling friction is not quite the same in YADE, which has no rolling dashpot."
    equations: tuple[Equation, ...] = (
        Equation("normal stiffness", "k_n = 4/3 E* a", f"constant for rolling, {CONSTANT}"),
        Equation("rolling damping", "c_r = 0"),
        ROLLING_LIMIT,
    )
    unused: tuple[str, ...] = (
        "particle_particle.rolling_damping",
        "particle_wall.rolling_damping",
    )

    def stiffness(self, contact: Contact) -> float:
        """Return the stiffness of the rolling force with the lever R*, N/m."""
        return rolling_spring_of(contact, rolling_damping=0.0).stiffness

    def _moment_stiffness(self, contact: Contact) -> float:
        # YADE takes a limit of zero for none.
        if not _eta(contact):
            return 0.0
        # The spring of LAMMPS is a force with the lever R* = r / 2, that of YADE a moment.
        return self.stiffness(contact) * (contact.radius / 2) ** 2

    def physics(self, contact: Contact) -> Sequence[YadeArgument]:
        """Return limit and stiffness of the moment."""
        return (
            YadeArgument("eta", f"{_eta(contact)}", "rolling friction / 2"),
            YadeArgument("krot", f"{self._moment_stiffness(contact)}", "N m"),
        )

    def on_wall(self, contact: Contact) -> Sequence[YadeArgument]:
        """Return stiffness and limit of the moment on a wall: the radius is R*."""
        limit = contact.value("rolling_friction")
        stiffness = self.stiffness(contact) * contact.radius**2 if limit else 0.0
        return (
            YadeArgument("kr", f"{stiffness}", "N m"),
            YadeArgument("maxBendPl", f"{limit} * radius", "rolling friction times radius"),
        )

    def law(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (always)
        """Return that there is a moment."""
        return (YadeArgument("includeMoment", "True"),)

    def notes(self, contact: Contact) -> str:
        """Return the differences of YADE's rolling friction, in lines of text."""
        return _NOTES.format(diameter=2 * contact.radius)


def _eta(contact: Contact) -> float:
    return contact.value("rolling_friction") / 2
