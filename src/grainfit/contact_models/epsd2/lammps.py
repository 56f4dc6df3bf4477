"""EPSD2 in the syntax of LAMMPS: ``rolling sds`` without damping."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.contact_models.contact import TYPICAL_LOAD, Contact
from grainfit.contact_models.epsd2.model import rolling_stiffness_of
from grainfit.contact_models.lammps import LammpsKeywords
from grainfit.materials.equations import Equation

_NOTES = """\
rolling sds: stiffness k_r/R*^2 (N/m), damping 0, rolling friction mu_r, for these diameters, this
density and a gravity of {gravity} m/s^2. For other particles, or far larger loads, work out the
stiffness again with the equations above."""


class Epsd2Lammps(LammpsKeywords):
    """``rolling sds`` with the stiffness that EPSD2 has at the typical load of the contact."""

    legend = "Rolling (EPSD2): stiffness N/m, no damping, rolling friction."
    equations = (
        Equation(
            "rolling spring",
            "k_r = k_t R*^2",
            f"constant, with k_t at F_e of {TYPICAL_LOAD:g} particle weights",
        ),
    )

    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return the rolling resistance of a contact."""
        friction = contact.value("rolling_friction")
        return {"rolling": f"rolling sds {rolling_stiffness_of(contact)} 0.0 {friction}"}

    def notes(self, gravity: float) -> str:
        """Return the meaning of the coefficients, and the particles for which they are valid."""
        return _NOTES.format(gravity=gravity)
