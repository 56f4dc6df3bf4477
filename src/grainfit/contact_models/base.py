"""Contact models: parameters, and words for each solver that has the model.

A *contact law* is several contact models that act together, one of each kind: how two bodies push
and rub ("contact"), how they hold together ("cohesion"), and how they resist rolling ("rolling").
A model is data: its parameters, and for each solver an object with the words that the solver's
decks and material cards take.

A new contact model is a folder of `grainfit.contact_models` and a line of
`grainfit.contact_models.registry`:

1. it declares its parameters (`grainfit.materials.parameters.declare`). Give them a default at
   which the model has no effect, if there is one: then files need not name them, and a material at
   the default is the material that it was before the model existed;
2. it writes its words for every solver that has it. Where a solver takes two models in one word
   (as LAMMPS takes adhesion with the normal force), the later kind replaces the word of the
   earlier one;
3. its tests inherit `grainfit.testing.contact_model_contract.ContactModelContract`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from grainfit.materials.parameters import MaterialParameter

Kind = Literal["contact", "cohesion", "rolling"]
#: In the order in which solvers want the words.
KINDS: tuple[Kind, ...] = ("contact", "cohesion", "rolling")


class SolverWords:
    """Words of a contact model for one solver; each solver has a class of its own."""

    #: Name of the solver.
    solver: ClassVar[str]
    #: Parameters of the model that the solver has no place for, by dotted name.
    unused: tuple[str, ...] = ()


@dataclass(frozen=True)
class ContactModel:
    """A part of the contact law of a material.

    Parameters
    ----------
    name : str
        Name of its folder.
    kind : {"contact", "cohesion", "rolling"}
        Of every kind, one model acts at a time.
    parameters : tuple of MaterialParameter
        Models of one kind may share a parameter.
    words : tuple of SolverWords
        One for each solver that has the model.
    """

    name: str
    kind: Kind
    parameters: tuple[MaterialParameter, ...]
    words: tuple[SolverWords, ...]

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of the solvers that have the model."""
        return tuple(words.solver for words in self.words)

    @property
    def is_optional(self) -> bool:
        """Whether every parameter has a default, at which the model does nothing."""
        return all(parameter.default is not None for parameter in self.parameters)

    def set_parameters(self, material: Mapping[str, float]) -> list[str]:
        """Return the names of parameters that a material gives another value than the default."""
        return [
            parameter.name
            for parameter in self.parameters
            if material.get(parameter.name, parameter.default) != parameter.default
        ]


@dataclass(frozen=True)
class ContactLaw:
    """The contact models that act between the particles of a material, and on its walls.

    Parameters
    ----------
    models : tuple of ContactModel
        One of each kind, in the order of `KINDS`.
    """

    models: tuple[ContactModel, ...]

    @property
    def words(self) -> list[SolverWords]:
        """Words of all models, for all solvers."""
        return [words for model in self.models for words in model.words]

    def without(self, solver: str) -> list[ContactModel]:
        """Return the models that a solver does not have."""
        return [model for model in self.models if solver not in model.solvers]

    def needs(self, solver: str) -> set[str]:
        """Return the names of the parameters that a solver computes these contacts with."""
        found = {parameter.name for model in self.models for parameter in model.parameters}
        return found - {name for w in self.words if w.solver == solver for name in w.unused}
