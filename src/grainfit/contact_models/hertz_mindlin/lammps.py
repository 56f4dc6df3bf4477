"""Hertz-Mindlin in the syntax of LAMMPS: ``hertz/material`` and ``mindlin``."""

from __future__ import annotations

from collections.abc import Mapping

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.model import (
    particle_moduli,
    tangential_damping_ratio,
    tangential_stiffness,
)
from grainfit.contact_models.lammps import LammpsKeywords
from grainfit.materials.equations import Equation


class HertzMindlinLammps(LammpsKeywords):
    """``hertz/material`` with ``damping coeff_restitution``, and ``tangential mindlin``."""

    legend = (
        "Hertz: E, restitution, nu. Mindlin: 8 G*, tangential over normal damping, "
        "sliding friction."
    )
    equations = (
        Equation("sliding limit", "|F_t| <= mu F_n", "it limits spring and dashpot together"),
    )

    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return normal and tangential force of a contact."""
        moduli = particle_moduli(contact.material, contact.body)
        modulus, poissons_ratio = elastic_coefficients(contact)
        return {
            "normal": f"hertz/material {modulus} {contact.value('restitution')} {poissons_ratio} "
            "damping coeff_restitution",
            "tangential": f"tangential mindlin {tangential_stiffness(moduli)} "
            f"{tangential_damping_ratio(moduli)} {contact.value('sliding_friction')}",
        }

    def notes(self, gravity: float) -> str:  # noqa: ARG002 (the same at every load)
        """Return the meaning of the coefficients."""
        return (
            "hertz/material: E, restitution, nu. mindlin: 8 G*, tangential over normal damping, "
            "sliding friction."
        )


def elastic_coefficients(contact: Contact) -> tuple[float, float]:
    """Return Young's modulus (Pa) and Poisson's ratio of two particles as stiff as a contact."""
    # LAMMPS computes E* of two particles of this material, also for a wall.
    poissons_ratio = contact.material["particle.poissons_ratio"]
    moduli = particle_moduli(contact.material, contact.body)
    return 2 * (1 - poissons_ratio**2) * moduli.young, poissons_ratio
