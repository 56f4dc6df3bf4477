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
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

from grainfit.contact_models.contact import Contact, Springs
from grainfit.materials.equations import Convention, Equation
from grainfit.materials.parameters import MaterialParameter
from grainfit.materials.walls import same_on_walls
from grainfit.one_line import OneLine

#: Share of the safe time step that is safe for cohesive beds too, whose particles overlap by at
#: most `LARGEST_OVERLAP` without a load: their contacts are stiffer, and more in number.
_COHESIVE = 0.6
#: Largest overlap of cohesive particles without a load, over their diameter: those that overlap
#: more are too soft for their cohesion, which then acts as if they were smaller.
LARGEST_OVERLAP = 0.05

#: Of models of cohesion, in place of that of the contact.
RESTITUTION_WITH_COHESION = Convention(
    "restitution",
    "e",
    "speed after over speed before a normal impact without cohesion, which takes more of slow ones",
)

#: Terms that follow from the springs of a contact.
OF_SPRINGS = ("normal stiffness", "rolling spring")

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
    #: Kinds of models that can act beside it in this solver.
    beside: tuple[Kind, ...] = KINDS
    #: Whether the solver has one set of coefficients for spheres of all sizes, which are then those
    #: of a single diameter.
    one_size: bool = False


@dataclass(frozen=True)
class Attraction:
    """Attraction of two bodies in contact.

    Parameters
    ----------
    pull_off : float
        Largest tension that the contact bears when it is pulled slowly, N.
    under_load : float
        Attraction under the typical load of the contact, N.
    overlap : float
        At rest without a load, m.
    """

    pull_off: float
    under_load: float
    overlap: float


@dataclass(frozen=True)
class ContactModel(OneLine):
    """A part of the contact law of a material.

    Parameters
    ----------
    name : str
        Name of its folder.
    title : str
        Its name for people.
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
        Largest share of the Rayleigh time step for a material that is safe with this model in a
        soft bed; it gets the stiffness of the normal over that of the tangential spring, None for
        that of Hertz and Mindlin.
    step_factor : callable, optional
        Of models of contact: how much larger the step can be, given the material, the radius of
        the smallest sphere (m), and the largest stress of the bed (Pa; None if it is not known).
    springs : callable, optional
        Stiffness of a contact, of models of contact for which it is the same at every load. Terms
        that follow from it (`OF_SPRINGS`) are then the same in all solvers.
    attraction : callable, optional
        Attraction of a contact, of models of cohesion.
    """

    name: str
    title: str
    kind: Kind
    parameters: tuple[MaterialParameter, ...]
    keywords: tuple[SolverKeywords, ...]
    equations: tuple[Equation, ...] = ()
    conventions: tuple[Convention, ...] = ()
    dashpots: tuple[str, ...] = ()
    safe_time_step: Callable[[Mapping[str, float], float | None], float] | None = None
    step_factor: Callable[[Mapping[str, float], float, float | None], float] | None = None
    springs: Callable[[Contact], Springs] | None = None
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
        if not self.title:
            yield "title is missing"
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
class ContactLaw(OneLine):
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
        """Meaning of the parameters in the equations; of two meanings, that of the later model."""
        return list({one.key: one for model in self.models for one in model.conventions}.values())

    @property
    def differing_terms(self) -> list[tuple[str, Equation]]:
        """Names of solvers, each with a term that it computes in another way."""
        return [(words.solver, found) for words in self.keywords for found in words.equations]

    def equations(self, solver: str = "") -> list[Equation]:
        """Return the equation of every term, as a solver computes it; as defined without one."""
        found = [equation for model in self.models for equation in model.equations]
        found += [equation for name, equation in self.differing_terms if name == solver]
        terms: dict[str, Equation] = {}
        for equation in found:
            # A spring is that of the first model that has it.
            if self.is_load_dependent or equation.term not in {*OF_SPRINGS} & terms.keys():
                terms[equation.term] = equation
        return list(terms.values())

    @property
    def _contact(self) -> ContactModel:
        """The model of normal and tangential force."""
        return self.models[0]

    @property
    def is_load_dependent(self) -> bool:
        """Whether the stiffness of contacts grows with the load: not that of linear springs."""
        return self._contact.springs is None

    def with_springs(self, contact: Contact) -> Contact:
        """Return a contact with the springs of the law, if they are the same at every load."""
        springs = self._contact.springs
        return contact if springs is None else replace(contact, springs=springs(contact))

    def in_solver(self, solver: str) -> ContactLaw:
        """Return the law without the models that cannot act beside the others in a solver."""
        unfit = {model.name for model, _ in self.unfit(solver)}
        return ContactLaw(tuple(model for model in self.models if model.name not in unfit))

    def with_sizes(self, solver: str) -> bool:
        """Return whether a solver has coefficients that hold for one diameter."""
        return any(words.one_size for words in self.keywords if words.solver == solver)

    def unfit(self, solver: str) -> list[tuple[ContactModel, ContactModel]]:
        """Return the models that a solver cannot compute beside another one, with that one."""
        found = [(model, one) for model in self.models for one in model.keywords]
        return [
            (other, model)
            for model, words in found
            if words.solver == solver
            for other in self.models
            if other is not model and other.kind not in words.beside
        ]

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

    def time_step_fraction(
        self, material: Mapping[str, float], radius: float, stress: float | None
    ) -> float:
        """Return the largest safe share of the Rayleigh time step.

        Parameters
        ----------
        material : mapping of str to float
            Values of the simulated particles by dotted name; where one is missing, the share is
            safe for all usual values.
        radius : float
            Of the smallest sphere, m.
        stress : float or None
            Largest stress of the bed, Pa, if it is known.
        """
        ratio = None
        if self._contact.springs is not None:
            springs = self._contact.springs(Contact.between(material, radius, radius, 0.0))
            ratio = springs.normal / springs.tangential
        steps = [m.safe_time_step for m in self.models if m.safe_time_step is not None]
        share = min(step(material, ratio) for step in steps)
        if self._contact.step_factor is not None:
            share *= self._contact.step_factor(material, radius, stress)
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
        # Those of other models are differences of a stiffness that grows with the load.
        models = self.models if self.is_load_dependent else (self._contact,)
        words = [keywords for model in models for keywords in model.keywords]
        found = [keywords.difference for keywords in words if keywords.solver in solvers]
        damped = [model for model in self.models if model.is_damped(material)]
        used = (one for m in damped for one in m.keywords if one.solver in solvers)
        return " ".join(filter(None, [*found, *(one.dashpot_difference for one in used)]))

    def needs(self, solver: str) -> set[str]:
        """Return the names of the parameters that a solver computes these contacts with."""
        found = {parameter.name for model in self.models for parameter in model.parameters}
        return found - {name for w in self.keywords if w.solver == solver for name in w.unused}
