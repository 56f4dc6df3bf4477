"""EPSD2 in the syntax of YADE: ``eta`` and ``krot`` of the ``Ip2`` functor."""

from __future__ import annotations

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.epsd.yade import CONSTANT, ROLLING_LIMIT, EpsdYade
from grainfit.contact_models.epsd2.model import rolling_stiffness_of
from grainfit.materials.equations import Equation


class Epsd2Yade(EpsdYade):
    """One rolling stiffness and one limit of the moment, those of two equal particles."""

    difference = "Rolling friction is not quite the same in YADE."
    equations = (
        Equation("rolling spring", "k_r = k_t R*^2", f"constant, {CONSTANT}"),
        ROLLING_LIMIT,
    )
    unused = ()

    def stiffness(self, contact: Contact) -> float:
        """Return the stiffness of the rolling force with the lever R*, N/m."""
        return rolling_stiffness_of(contact)
