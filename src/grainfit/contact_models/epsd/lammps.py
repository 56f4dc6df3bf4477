"""EPSD in the syntax of LAMMPS: ``rolling sds``."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.contact_models.contact import TYPICAL_LOAD, Contact
from grainfit.contact_models.epsd.model import rolling_spring_of
from grainfit.contact_models.lammps import LammpsKeywords
from grainfit.materials.equations import Equation

_NOTES = """\
rolling sds: stiffness k_r/R*^2 (N/m), damping c_r/R*^2 (N s/m), rolling friction mu_r, for these
diameters, this density and a gravity of {gravity} m/s^2. Another load of 1 or 20 particle weights
makes no visible difference to a heap. For other particles, or far larger loads, work out stiffness
and damping again with the equations above."""


class EpsdLammps(LammpsKeywords):
    """``rolling sds`` with the stiffness that EPSD has at the typical load of the contact."""

    legend = "Rolling (EPSD): stiffness N/m, damping N s/m, rolling friction."
    difference = (
        "LAMMPS has one rolling stiffness for all loads. Without rolling damping, bulk densities "
        "on LIGGGHTS and YADE are up to 0.5 % lower, angles in shear 0.4° and of a draw-down 0.8° "
        "larger; on LIGGGHTS also dynamic and upper angle of a drum 0.6° and 0.8° smaller, mass "
        "flows 2 % smaller, and the loading modulus of a compression 7 % larger. Angles of heaps "
        "agree."
    )
    equations = (
        Equation(
            "normal stiffness",
            "k_n = 4/3 E* a",
            f"constant for rolling, at F_e of {TYPICAL_LOAD:g} particle weights",
        ),
        Equation("rolling limit", "|M_r| <= mu_r R* F_n", "it limits spring and dashpot together"),
    )

    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return the rolling resistance of a contact."""
        spring = rolling_spring_of(contact, contact.value("rolling_damping"))
        friction = contact.value("rolling_friction")
        return {"rolling": f"rolling sds {spring.stiffness} {spring.damping} {friction}"}

    def notes(self, gravity: float) -> str:
        """Return the meaning of the coefficients, and the particles for which they are valid."""
        return _NOTES.format(gravity=gravity)
