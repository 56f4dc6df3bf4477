"""EPSD in the syntax of LAMMPS: ``rolling sds``."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.contact_models.contact import TYPICAL_LOAD, Contact
from grainfit.contact_models.epsd.model import rolling_spring_of
from grainfit.contact_models.lammps import LammpsKeywords

_NOTES = """\
rolling sds: stiffness k (N/m), damping (N s/m), rolling friction; they stand for the rolling
friction EPSD of LIGGGHTS:  k = 2.25 k_n mu_r^2,  damping = 2 eta_r sqrt(I_r k) / R*,  with
k_n = 4/3 E* sqrt(R* overlap). k_n grows with the load, k does not: it is taken at a normal force of
{load:g} particle weights (1 or 20 make no visible difference to a heap), for these diameters,
this density and a gravity of {gravity} m/s^2. For other particles, or far larger loads,
work out k and damping again (docs/heap_test.md of grainfit)."""


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

    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return the rolling resistance of a contact."""
        spring = rolling_spring_of(contact, contact.value("rolling_damping"))
        friction = contact.value("rolling_friction")
        return {"rolling": f"rolling sds {spring.stiffness} {spring.damping} {friction}"}

    def notes(self, gravity: float) -> str:
        """Return the meaning of the coefficients, and the load for which they are valid."""
        return _NOTES.format(load=TYPICAL_LOAD, gravity=gravity)
