"""Contact models: parameters, and keywords for each solver that has the model.

A *contact law* is several contact models that act together, one of each kind: normal and
tangential force ("contact"), cohesion ("cohesion"), and resistance to rolling ("rolling").
A model is data: its parameters, and for each solver an object with the keywords for the solver's
decks and material cards.

A new contact model is a folder of `grainfit.contact_models` and a line of
`grainfit.contact_models.registry`:

1. it declares its parameters (`grainfit.materials.parameters.declare`). Give them a default at
   which the model has no effect, if there is one: then files need not name them, and the model
   changes no earlier material;
2. it writes its keywords for every solver that has it. Where one keyword of a solver stands for
   two models (as in LAMMPS for adhesion and the normal force), the later kind replaces the keyword
   of the earlier one;
3. it has an equation for each of its terms and the convention of each parameter, and each solver
   the equations of the terms that it computes in another way: cards and documentation show them;
4. its tests inherit `grainfit.testing.contact_model_contract.ContactModelContract`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

from grainfit.contact_models.contact import Contact
from grainfit.materials.equations import Convention, Equation
from grainfit.materials.parameters import MaterialParameter
from grainfit.materials.walls import same_on_walls

#: Share of the safe time step that is safe for cohesive beds too, whose particles overlap by at
#: most `LARGEST_OVERLAP` without a load: their contacts are stiffer, and more in number.
_COHESIVE = 0.6
#: Largest overlap of cohesive particles without a load, over their diameter: those that overlap
#: more are too soft for their cohesion, which then acts as if they were smaller.
LARGEST_OVERLAP = 0.05

#: In the order in which solvers need the keywords.
Kind = Literal["contact", "cohesion", "rolling"]
KINDS: tuple[Kind, ...] = get_args(Kind)


class SolverKeywords:
    """Keywords of a contact model for one solver; each solver has its own class."""

    #: Name of the solver.
    solver: ClassVar[str]
    #: Parameters of the model that the solver has no place for, by dotted name.
    unused: tuple[str, ...] = ()
    #: Terms that the solver computes in another way.
    equations: tuple[Equation, ...] = ()
    #: Sentences on how far its contacts differ from those of the other solvers.
    difference: str = ""
    #: Sentences on how far they differ while one of the model's dashpots acts.
    dashpot_difference: str = ""


@dataclass(frozen=True)
class Attraction:
    """Attraction of two bodies in contact.

    Parameters
    ----------
    pull_off : float
        Largest tension that the contact bears when it is pulled slowly, N.
    under_load : float
        Attraction under the typical load of the contact, N.
    overlap, contact_radius : float
        At rest without a load, m.
    """

    pull_off: float
    under_load: float
    overlap: float
    contact_radius: float


@dataclass(frozen=True)
class ContactModel:
    """A part of the contact law of a material.

    Parameters
    ----------
    name : str
        Name of its folder.
    kind : {"contact", "cohesion", "rolling"}
        One model of each kind acts at a time.
    parameters : tuple of MaterialParameter
        Models of one kind may share a parameter.
    keywords : tuple of SolverKeywords
        One for each solver that has the model.
    equations : tuple of Equation
        One for each term. Those of terms that an earlier kind has as well replace the earlier ones.
    conventions : tuple of Convention
        One for each key of its parameters, at least.
    dashpots : tuple of str
        Names of parameters of rolling dashpots, which solvers implement in different ways.
    safe_time_step : callable, optional
        Largest share of the Rayleigh time step for a material that is safe with this model.
    attraction : callable, optional
        Attraction of a contact, of models of cohesion.
    """

    name: str
    kind: Kind
    parameters: tuple[MaterialParameter, ...]
    keywords: tuple[SolverKeywords, ...]
    equations: tuple[Equation, ...] = ()
    conventions: tuple[Convention, ...] = ()
    dashpots: tuple[str, ...] = ()
    safe_time_step: Callable[[Mapping[str, float]], float] | None = None
    attraction: Callable[[Contact], Attraction] | None = None

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of the solvers that have the model."""
        return tuple(keywords.solver for keywords in self.keywords)

    @property
    def is_optional(self) -> bool:
        """Whether every parameter has a default, at which the model does nothing."""
        return all(parameter.default is not None for parameter in self.parameters)

    def shares_parameters(self, other: ContactModel) -> bool:
        """Return whether both models have a parameter in common."""
        return not {p.name for p in self.parameters}.isdisjoint(p.name for p in other.parameters)

    def is_damped(self, material: Mapping[str, float]) -> bool:
        """Return whether a dashpot acts; one whose parameter is not known counts."""
        found = {name: same_on_walls(name, material) for name in self.dashpots}
        return any(not names or max(material[n] for n in names) > 0 for names in found.values())

    def missing(self) -> Iterator[str]:
        """Iterate over what it lacks to be used."""
        names = [parameter.name for parameter in self.parameters]
        if self.kind not in KINDS:
            yield f"its kind {self.kind!r} is none of {', '.join(KINDS)}"
        if not names:
            yield "parameters are missing"
        if not self.keywords:
            yield "no solver has keywords for it"
        yield from self._unexplained()
        if self.kind == "cohesion" and self.attraction is None:
            yield "attraction is missing"
        for parameter in self.parameters:
            if gap := parameter.missing():
                yield f"{parameter.name}: {gap}"
        for name in self.dashpots:
            if name not in names:
                yield f"its dashpot {name} is none of its parameters"

    def _unexplained(self) -> Iterator[str]:
        if not self.equations:
            yield "equations are missing"
        explained = {convention.key for convention in self.conventions}
        for key in dict.fromkeys(parameter.key for parameter in self.parameters):
            if key not in explained:
                yield f"the convention of {key} is missing"

    def set_parameters(self, material: Mapping[str, float]) -> list[str]:
        """Return the names of parameters that a material gives another value than the default."""
        return [
            name
            for parameter in self.parameters
            for name in same_on_walls(parameter.name, material)
            if material[name] != parameter.default
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
    def keywords(self) -> list[SolverKeywords]:
        """Keywords of all models, for all solvers."""
        return [keywords for model in self.models for keywords in model.keywords]

    @property
    def conventions(self) -> list[Convention]:
        """Meaning of the parameters in the equations."""
        return [convention for model in self.models for convention in model.conventions]

    @property
    def differing_terms(self) -> list[tuple[str, Equation]]:
        """Names of solvers, each with a term that it computes in another way."""
        return [(words.solver, found) for words in self.keywords for found in words.equations]

    def equations(self, solver: str = "") -> list[Equation]:
        """Return the equation of every term, as a solver computes it; as defined without one."""
        found = [equation for model in self.models for equation in model.equations]
        found += [equation for name, equation in self.differing_terms if name == solver]
        return list({equation.term: equation for equation in found}.values())

    @property
    def defaults(self) -> dict[str, float]:
        """Default values of the models' parameters that have one."""
        declared = (parameter for model in self.models for parameter in model.parameters)
        return {p.name: p.default for p in declared if p.default is not None}

    @property
    def cohesion(self) -> ContactModel | None:
        """The model of cohesion that acts."""
        return next((model for model in self.models if model.attraction is not None), None)

    def without(self, solver: str) -> list[ContactModel]:
        """Return the models that a solver does not have."""
        return [model for model in self.models if solver not in model.solvers]

    def time_step_fraction(self, material: Mapping[str, float]) -> float:
        """Return the largest safe share of the Rayleigh time step.

        Parameters
        ----------
        material : mapping of str to float
            Values by dotted name; where one is missing, the share is safe for all usual values.
        """
        share = min(m.safe_time_step(material) for m in self.models if m.safe_time_step is not None)
        return share if self.cohesion is None else _COHESIVE * share

    def solver_difference(self, material: Mapping[str, float], solvers: Collection[str]) -> str:
        """Return sentences on how far some solvers differ; empty if they agree.

        Parameters
        ----------
        material : mapping of str to float
            Values by dotted name.
        solvers : collection of str
            Names of two solvers or more.
        """
        found = [keywords.difference for keywords in self.keywords if keywords.solver in solvers]
        damped = [model for model in self.models if model.is_damped(material)]
        used = (one for m in damped for one in m.keywords if one.solver in solvers)
        return " ".join(filter(None, [*found, *(one.dashpot_difference for one in used)]))

    def needs(self, solver: str) -> set[str]:
        """Return the names of the parameters that a solver computes these contacts with."""
        found = {parameter.name for model in self.models for parameter in model.parameters}
        return found - {name for w in self.keywords if w.solver == solver for name in w.unused}
