"""Contact laws for LIGGGHTS: keywords of ``gran model``, and the properties they need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Generic, TypeVar

from grainfit.contact_models.base import ContactLaw, SolverKeywords
from grainfit.contact_models.contact import Contact
from grainfit.one_line import OneLine

Value = TypeVar("Value")


@dataclass(frozen=True)
class LiggghtsKeywords(SolverKeywords, OneLine):
    """Keywords of a contact model for LIGGGHTS.

    Parameters
    ----------
    model : str
        Part of ``pair_style gran model ...`` and ``fix wall/gran model ...``.
    body_properties, pair_properties : mapping of str to str
        ``property/global`` of type ``peratomtype`` and ``peratomtypepair``, with the key of its
        parameter in the sections of bodies and of contacts.
    dashpot_difference : str
        See `SolverKeywords`.
    """

    solver: ClassVar[str] = "liggghts"
    model: str
    body_properties: Mapping[str, str] = field(default_factory=dict)
    pair_properties: Mapping[str, str] = field(default_factory=dict)
    dashpot_difference: str = ""

    def constants(self, contact: Contact) -> Mapping[str, float]:  # noqa: ARG002 (a door)
        """Return values of ``peratomtypepair`` that are computed of a contact, by property."""
        return {}


def liggghts_keywords(law: ContactLaw) -> list[LiggghtsKeywords]:
    """Return the LIGGGHTS keywords of all models of a contact law that have them."""
    return [keywords for keywords in law.keywords if isinstance(keywords, LiggghtsKeywords)]


def liggghts_model(law: ContactLaw) -> str:
    """Return the keywords of ``gran model``, for pairs and walls alike."""
    return " ".join(keywords.model for keywords in liggghts_keywords(law))


@dataclass(frozen=True)
class LiggghtsProperties(Generic[Value]):
    """Values of ``property/global`` for a type of particles and one or several of walls.

    Parameters
    ----------
    bodies : mapping of str to list
        One value for each type, by property.
    pairs : mapping of str to list of list
        Rows of the matrix of types, by property.
    keys : mapping of str to str
        Key of the parameter, by property.
    """

    bodies: Mapping[str, list[Value]]
    pairs: Mapping[str, Sequence[Sequence[Value | float]]]
    keys: Mapping[str, str]


def liggghts_properties(
    law: ContactLaw, walls: Sequence[Mapping[str, Value]], contacts: Sequence[Contact] = ()
) -> LiggghtsProperties[Value]:
    """Return the properties that the models of a contact law read.

    Parameters
    ----------
    law : ContactLaw
        The contact models.
    walls : sequence of mapping
        For each type of walls, the material by dotted name, with the parameters of that wall.
        Values are numbers, or texts that stand for them.
    contacts : sequence of Contact
        That of two particles, and of a particle with each of the walls: needed by models of one
        size of spheres.
    """
    found = liggghts_keywords(law)
    bodies = {name: key for keywords in found for name, key in keywords.body_properties.items()}
    pairs = {name: key for keywords in found for name, key in keywords.pair_properties.items()}
    constants = [
        {name: value for words in found for name, value in words.constants(contact).items()}
        for contact in contacts
    ]
    names = constants[0] if constants else ()
    return LiggghtsProperties(
        {name: _of_bodies(key, walls) for name, key in bodies.items()},
        {name: _matrix(_of_pairs(key, walls)) for name, key in pairs.items()}
        | {name: _matrix([values[name] for values in constants]) for name in names},
        bodies | pairs,
    )


def _of_bodies(key: str, walls: Sequence[Mapping[str, Value]]) -> list[Value]:
    return [walls[0][f"particle.{key}"], *(wall[f"wall.{key}"] for wall in walls)]


def _of_pairs(key: str, walls: Sequence[Mapping[str, Value]]) -> list[Value]:
    values = [walls[0][f"particle_particle.{key}"]]
    return [*values, *(wall[f"particle_wall.{key}"] for wall in walls)]


def _matrix(values: Sequence[Value]) -> list[list[Value]]:
    types = range(len(values))
    # Walls never meet walls, but LIGGGHTS requires a value.
    return [[values[min(i, j) or max(i, j)] for j in types] for i in types]
