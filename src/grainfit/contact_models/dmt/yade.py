"""DMT in the syntax of YADE: ``gamma`` of the ``Ip2`` functor, ``includeAdhesion`` of the law."""

from __future__ import annotations

from collections.abc import Sequence

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.dmt.model import pull_off_force
from grainfit.contact_models.yade import YadeArgument, YadeKeywords
from grainfit.materials.equations import Equation

_NOTES = """\
Cohesion: gamma is one for all contacts, that of two particles. Damping is limited to the pull-off
force where bodies part: with hardly any cohesion, bodies with a restitution of 0.79 part with 0.80,
those with 0.3 with 0.42."""


class DmtYade(YadeKeywords):
    """One surface energy for all contacts of the functor."""

    difference = (
        "YADE limits the friction of cohesive contacts by the normal force plus the pull-off "
        "force, LAMMPS plus twice the pull-off force: cohesive beds do not agree."
    )
    equations = (
        Equation("normal force", "F = F_e + c_n v_n", "c_n v_n is at most F_po where bodies part"),
        Equation("force that limits friction", "F_n = |F| + F_po", "rolling by |F| alone"),
    )

    def physics(self, contact: Contact) -> Sequence[YadeArgument]:
        """Return the surface energy of two particles."""
        return (YadeArgument("gamma", f"{contact.value('surface_energy')}", "J/m^2"),)

    def law(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (always)
        """Return that there is adhesion."""
        return (YadeArgument("includeAdhesion", "True"),)

    def on_wall(self, contact: Contact) -> Sequence[YadeArgument]:
        """Return the pull-off force on a wall: the radius is R*."""
        per_radius = pull_off_force(contact.value("surface_energy"), 1.0)
        return (YadeArgument("adhesionForce", f"{per_radius} * radius", "N"),)

    def notes(self, contact: Contact) -> str:  # noqa: ARG002 (for all contacts)
        """Return the differences of YADE's adhesion, in lines of text."""
        return _NOTES
