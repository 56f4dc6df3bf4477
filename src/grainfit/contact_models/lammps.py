"""Contact laws for LAMMPS: ``pair_style granular`` and ``fix wall/gran granular``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from grainfit.contact_models.base import ContactLaw, SolverKeywords
from grainfit.contact_models.contact import Contact
from grainfit.one_line import OneLine


class LammpsKeywords(SolverKeywords, ABC, OneLine):
    """Keywords of a contact model for LAMMPS."""

    solver: ClassVar[str] = "lammps"
    #: Meaning of the coefficients in short, for a comment in a deck.
    legend: str = ""

    @abstractmethod
    def clauses(self, contact: Contact) -> Mapping[str, str]:
        """Return the clauses of ``pair_coeff`` or ``fix wall/gran`` for a contact.

        Keys are the parts of the granular model: ``"normal"`` (with its damping),
        ``"tangential"``, ``"rolling"``, ``"twisting"``. A later model replaces clauses of an
        earlier one.
        """

    def notes(self, gravity: float) -> str:  # noqa: ARG002 (a door: not every model needs it)
        """Return the meaning of the coefficients for a material card, in lines of text."""
        return self.legend


def lammps_keywords(law: ContactLaw) -> list[LammpsKeywords]:
    """Return the LAMMPS keywords of all models of a contact law that have them."""
    return [keywords for keywords in law.keywords if isinstance(keywords, LammpsKeywords)]


def lammps_clauses(law: ContactLaw, contact: Contact) -> list[str]:
    """Return all clauses for a contact, in the order that LAMMPS needs."""
    clauses: dict[str, str] = {}
    contact = law.with_springs(contact)
    for keywords in lammps_keywords(law):
        clauses |= keywords.clauses(contact)
    return list(clauses.values())
