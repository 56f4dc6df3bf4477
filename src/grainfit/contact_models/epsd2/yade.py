"""EPSD2 in the syntax of YADE: ``eta`` and ``krot`` of the ``Ip2`` functor."""

from __future__ import annotations

from typing import ClassVar

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.epsd.yade import EpsdYade
from grainfit.contact_models.epsd2.model import rolling_stiffness_of

_NOTES = """\
ROLLING FRICTION DOES NOT: repeat the bulk test in YADE before you rely on the values.
    - YADE has one krot and one eta for all contacts. Here they are those of two particles.
    - eta is half the rolling friction: YADE limits the moment to eta times radius times normal force,
      the rolling friction EPSD2 of LIGGGHTS to mu_r R* times normal force; R* of two equal spheres
      is half their radius.
    - krot is EPSD2's k_t R*^2, which grows with the load; krot does not, and is taken for a diameter
      of {diameter} m at a normal force of {load:g} particle weights.
    - On a Wall, eta acts as a rolling friction of {on_wall:.6g}, on a Facet of {on_facet:.6g}{on_walls}."""  # noqa: E501 (lines of a card)


class Epsd2Yade(EpsdYade):
    """One rolling stiffness and one limit of the moment, those of two equal particles."""

    difference = "Rolling friction is not quite the same in YADE."
    remarks: ClassVar[str] = _NOTES
    unused = ("particle_wall.rolling_friction",)

    def stiffness(self, contact: Contact) -> float:
        """Return the stiffness of the rolling force with the lever R*, N/m."""
        return rolling_stiffness_of(contact)
