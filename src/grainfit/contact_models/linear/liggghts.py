"""Linear springs in the syntax of LIGGGHTS: ``hooke/stiffness`` with ``tangential history``."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.contact_models.base import Kind
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import damping_factor
from grainfit.contact_models.liggghts import LiggghtsKeywords
from grainfit.contact_models.linear.model import normal_damping, springs, tangential_damping_ratio


class LinearLiggghts(LiggghtsKeywords):
    """``hooke/stiffness``, whose stiffness is given: that of ``hooke`` is that of an impact."""

    beside: tuple[Kind, ...] = ("rolling",)
    # Its dashpots are in proportion to the reduced mass, those of a restitution to the root of it.
    one_size = True

    def constants(self, contact: Contact) -> Mapping[str, float]:
        """Return stiffness (N/m) and damping over the reduced mass (1/s) of a contact."""
        found = springs(contact)
        damping = normal_damping(contact, damping_factor(contact.value("restitution")))
        damping /= contact.effective_mass
        return {
            "kn": found.normal,
            "kt": found.tangential,
            "gamman": damping,
            "gammat": tangential_damping_ratio(contact) * damping,
        }


LINEAR_LIGGGHTS = LinearLiggghts(
    model="hooke/stiffness tangential history",
    pair_properties={"coefficientFriction": "sliding_friction"},
)
