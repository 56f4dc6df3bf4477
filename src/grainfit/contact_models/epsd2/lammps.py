"""EPSD2 in the syntax of LAMMPS: ``rolling sds`` without damping."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.contact_models.contact import TYPICAL_LOAD, Contact
from grainfit.contact_models.epsd2.model import rolling_stiffness_of
from grainfit.contact_models.lammps import LammpsKeywords

_NOTES = """\
rolling sds: stiffness k (N/m), damping 0, rolling friction; they stand for the rolling friction
EPSD2 of LIGGGHTS:  k = k_t = 8 G* sqrt(R* overlap). k_t grows with the load, k does not: it is
taken at a normal force of {load:g} particle weights, for these diameters, this density and a
gravity of {gravity} m/s^2. For other particles, or far larger loads, work out k again
(docs/heap_test.md of grainfit)."""


class Epsd2Lammps(LammpsKeywords):
    """``rolling sds`` with the stiffness that EPSD2 has at the typical load of the contact."""

    legend = "Rolling (EPSD2): stiffness N/m, no damping, rolling friction."

    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return the rolling resistance of a contact."""
        friction = contact.value("rolling_friction")
        return {"rolling": f"rolling sds {rolling_stiffness_of(contact)} 0.0 {friction}"}

    def notes(self, gravity: float) -> str:
        """Return the meaning of the coefficients, and the load for which they are valid."""
        return _NOTES.format(load=TYPICAL_LOAD, gravity=gravity)
