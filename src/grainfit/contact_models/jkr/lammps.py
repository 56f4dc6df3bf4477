"""JKR in the syntax of LAMMPS: ``jkr`` in place of Hertz."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.lammps import elastic_coefficients
from grainfit.contact_models.lammps import LammpsKeywords
from grainfit.contact_models.mass_damping import mass_damping
from grainfit.materials.equations import Equation

_NOTES = """\
{name}: E, damping, nu, surface energy (J/m^2; the work of adhesion is twice as much). LAMMPS has no
damping with the same restitution at all speeds for a cohesive force. With this one, an impact
without cohesion has the restitution of the material at the speed sqrt(g d), with a gravity of
{gravity} m/s^2; slower impacts have less, faster ones more."""


class JkrLammps(LammpsKeywords):
    """``jkr`` with ``damping mass_velocity``; Hertz stays where there is no surface energy."""

    name: ClassVar[str] = "jkr"
    legend = "Cohesion: E, damping 1/s, nu, surface energy J/m^2."
    equations = (
        Equation(
            "normal damping",
            "c_n = D m*",
            "D: rate at which an impact with the speed sqrt(g d) has the restitution e; other "
            "impacts have another one",
        ),
        Equation("tangential damping", "c_t = D m* sqrt(4 G*/E*)"),
        Equation("force that limits friction", "F_n = |F_e + 2 F_po|", "of rolling, too"),
    )

    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return the normal force of a contact; none without surface energy."""
        energy = contact.value("surface_energy")
        if energy == 0:
            return {}
        modulus, poissons_ratio = elastic_coefficients(contact)
        damping = mass_damping(contact)
        return {
            "normal": f"{self.name} {modulus} {damping} {poissons_ratio} {energy} "
            "damping mass_velocity"
        }

    def notes(self, gravity: float) -> str:
        """Return the meaning of the coefficients."""
        return _NOTES.format(name=self.name, gravity=gravity)
