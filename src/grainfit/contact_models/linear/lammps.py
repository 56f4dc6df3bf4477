"""Linear springs in the syntax of LAMMPS: ``hooke`` and ``linear_history``."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.contact_models.base import Kind
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.lammps import HertzMindlinLammps
from grainfit.contact_models.lammps import LammpsKeywords
from grainfit.contact_models.linear.model import springs, tangential_damping_ratio

_MEANING = (
    "hooke: k_n N/m, restitution. linear_history: k_t N/m, tangential over normal damping, "
    "sliding friction."
)


class LinearLammps(LammpsKeywords):
    """``hooke`` with ``damping coeff_restitution``, and ``tangential linear_history``."""

    legend = _MEANING
    equations = HertzMindlinLammps.equations
    beside: tuple[Kind, ...] = ("rolling",)

    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return normal and tangential force of a contact."""
        found = springs(contact)
        return {
            "normal": f"hooke {found.normal} {contact.value('restitution')} "
            "damping coeff_restitution",
            "tangential": f"tangential linear_history {found.tangential} "
            f"{tangential_damping_ratio(contact)} {contact.value('sliding_friction')}",
        }
