"""Contact laws for YADE: ``Ip2_FrictMat_FrictMat_MindlinPhys`` and ``Law2_ScGeom_MindlinPhys_...``.

The keywords are Python code, for a module that has a function ``_of_pairs(key, convert=float)``,
which returns a ``MatchMaker``: the converted values of a contact parameter for all pairs.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

from grainfit.contact_models.base import ContactLaw, SolverKeywords
from grainfit.contact_models.contact import Contact
from grainfit.one_line import OneLine


class YadeArgument(NamedTuple):
    """An argument of a functor: its name, a Python expression, and a remark."""

    name: str
    value: str
    remark: str = ""


class YadeFunctors(NamedTuple):
    """Classes of YADE that compute a contact: of the material, of stiffness, and of the force."""

    material: str
    physics: str
    law: str


class YadeKeywords(SolverKeywords, ABC, OneLine):
    """Keywords of a contact model for YADE.

    Without a ``MatchMaker``, a functor has one number for all contacts: that of two equal
    particles of mean size. Decks and cards write those of walls into the contacts themselves.
    """

    solver: ClassVar[str] = "yade"
    #: Of a model of normal and tangential force.
    functors: ClassVar[YadeFunctors | None] = None

    def particle(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (a door)
        """Return the arguments of the particles' material, given the contact of two equal ones."""
        return ()

    def wall(self, contact: Contact, particles: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002
        """Return the arguments of the material of a wall.

        Parameters
        ----------
        contact, particles : Contact
            Of a particle with the wall, and of two equal particles.
        """
        return ()

    @abstractmethod
    def physics(self, contact: Contact) -> Sequence[YadeArgument]:
        """Return arguments of the ``Ip2`` functor, given the contact of two equal particles."""

    def law(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (a door)
        """Return arguments of the ``Law2`` functor, given the contact of two equal particles."""
        return ()

    def on_wall(self, contact: Contact) -> Sequence[YadeArgument]:  # noqa: ARG002 (a door)
        """Return attributes of a contact with a wall that its ``Ip2`` functor cannot give it.

        Parameters
        ----------
        contact : Contact
            Of a particle with the wall.
        """
        return ()

    def notes(self, contact: Contact) -> str:  # noqa: ARG002 (a door)
        """Return differences in the meaning of the parameters in YADE, in lines of text."""
        return ""


def yade_keywords(law: ContactLaw) -> list[YadeKeywords]:
    """Return the YADE keywords of all models of a contact law that have them."""
    found = law.in_solver(YadeKeywords.solver).keywords
    return [keywords for keywords in found if isinstance(keywords, YadeKeywords)]


def yade_physics(law: ContactLaw, contact: Contact) -> list[YadeArgument]:
    """Return all arguments of the ``Ip2`` functor."""
    contact = law.with_springs(contact)
    return [argument for keywords in yade_keywords(law) for argument in keywords.physics(contact)]


def yade_law(law: ContactLaw, contact: Contact) -> list[YadeArgument]:
    """Return all arguments of the ``Law2`` functor."""
    return [argument for keywords in yade_keywords(law) for argument in keywords.law(contact)]


def yade_on_wall(law: ContactLaw, contact: Contact) -> list[YadeArgument]:
    """Return all attributes of a contact with a wall that no functor can give it."""
    return [argument for keywords in yade_keywords(law) for argument in keywords.on_wall(contact)]


def yade_body(law: ContactLaw) -> YadeKeywords:
    """Return the keywords of the model of normal and tangential force, which has functors."""
    return next(keywords for keywords in yade_keywords(law) if keywords.functors is not None)
