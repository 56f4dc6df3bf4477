"""Registry of contact models, material parameters, and the contact law of a material."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grainfit.contact_models import messages
from grainfit.contact_models.base import KINDS, ContactLaw, ContactModel, Kind
from grainfit.contact_models.dmt.contact_model import DMT
from grainfit.contact_models.epsd.contact_model import EPSD
from grainfit.contact_models.epsd2.contact_model import EPSD2
from grainfit.contact_models.hertz_mindlin.contact_model import HERTZ_MINDLIN
from grainfit.contact_models.jkr.contact_model import JKR
from grainfit.contact_models.linear.contact_model import LINEAR
from grainfit.contact_models.sjkr.contact_model import SJKR
from grainfit.contact_models.sjkr2.contact_model import SJKR2
from grainfit.errors import Fault, InputError
from grainfit.formatting import as_sentence
from grainfit.materials.parameters import BODY_PARAMETERS, SECTIONS, MaterialParameter
from grainfit.materials.walls import PLAIN, on_wall, plain_name, same_on_walls, wall_of, walls_among
from grainfit.registration import require_complete, require_unique

#: A new contact model is a line here. If several models of one kind
#: have an effect by default, or act through the same parameters, the first one acts.
CONTACT_MODELS: tuple[ContactModel, ...] = (
    HERTZ_MINDLIN,
    LINEAR,
    EPSD,
    EPSD2,
    SJKR,
    SJKR2,
    JKR,
    DMT,
)

require_unique("contact model", (model.name for model in CONTACT_MODELS))
for _model in CONTACT_MODELS:
    require_complete("contact model", _model.name, _model.missing())

#: The order of parameters is part of a calibration's identity, so that the first keys keep their
#: places; those of new models follow in the order of the models.
_FIRST_KEYS = ("sliding_friction", "rolling_friction", "restitution", "rolling_damping")


def model_titles(names: Iterable[str]) -> list[str]:
    """Return the names of contact models for people.

    Examples
    --------
    >>> model_titles(["hertz_mindlin", "epsd"])
    ['Hertz-Mindlin contact', 'EPSD rolling friction']
    """
    titles = {model.name: model.title for model in CONTACT_MODELS}
    return [titles.get(name, name) for name in names]


def material_parameters(models: Iterable[ContactModel]) -> dict[str, MaterialParameter]:
    """Return the parameters of bodies and contact models, in the order of the calibration file."""
    declared = [*BODY_PARAMETERS, *(p for model in models for p in model.parameters)]
    sections = list(SECTIONS)

    def order(parameter: MaterialParameter) -> tuple[int, int]:
        known = parameter.key in _FIRST_KEYS
        place = _FIRST_KEYS.index(parameter.key) if known else len(_FIRST_KEYS)
        return sections.index(parameter.section), place

    return {parameter.name: parameter for parameter in sorted(declared, key=order)}


#: All material parameters by dotted name, those of walls with the names of the plain wall.
MATERIAL_PARAMETERS: Mapping[str, MaterialParameter] = material_parameters(CONTACT_MODELS)

#: Names of the parameters of cohesion.
COHESION = tuple(
    dict.fromkeys(p.name for m in CONTACT_MODELS if m.attraction is not None for p in m.parameters)
)


def material_parameter(name: str) -> MaterialParameter | None:
    """Return a material parameter, also one of a wall with a name; None if there is none.

    Examples
    --------
    >>> material_parameter("particle_wall.steel.sliding_friction").symbol
    'μ_pw_steel'
    """
    known, wall = MATERIAL_PARAMETERS.get(plain_name(name)), wall_of(name)
    return known.of_wall(wall) if known is not None and wall else known


def material_units(names: Iterable[str]) -> dict[str, str]:
    """Return the SI units of those names that are material parameters."""
    known = {name: material_parameter(name) for name in names}
    return {name: found.unit for name, found in known.items() if found is not None}


def is_material_parameter(name: str) -> bool:
    """Return True for the names of material parameters, those of walls with a name included."""
    return plain_name(name) in MATERIAL_PARAMETERS


def in_order(names: Iterable[str]) -> list[str]:
    """Return the material parameters among some names, in the order of the calibration file."""
    places = {name: place for place, name in enumerate(MATERIAL_PARAMETERS)}
    return sorted(filter(is_material_parameter, names), key=lambda n: places[plain_name(n)])


def parameters_of_walls(walls: Iterable[str]) -> list[str]:
    """Return the names of all material parameters, those of walls for each of some walls."""
    walls = tuple(walls)
    return list(
        dict.fromkeys(
            one
            for name in MATERIAL_PARAMETERS
            for one in ([name] if wall_of(name) is None else [on_wall(name, w) for w in walls])
        )
    )


def default_values(walls: Iterable[str] = ()) -> dict[str, float]:
    """Return the defaults of parameters that have one, those of walls with a name included."""
    return {
        name: known.default
        for name in parameters_of_walls((PLAIN, *walls))
        if (known := MATERIAL_PARAMETERS[plain_name(name)]).default is not None
    }


def with_defaults(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values of a material, completed by the defaults of parameters not given."""
    return {**default_values(walls_among(values)), **values}


def simulated_material(values: Mapping[str, float], factor: float) -> dict[str, float]:
    """Return the values that coarse-grained particles need to behave as the real ones.

    The stresses of a bed do not change with the size of its particles, so that contact forces grow
    as the square of the factor. Young's modulus, frictions and the restitution keep their values
    then, and forces of adhesion, which grow as radius times surface energy, need a surface energy
    in proportion to the factor.

    Parameters
    ----------
    values : mapping of str to float
        Material parameters of the real particles by dotted name.
    factor : float
        Diameter of a simulated particle over that of a real one.

    References
    ----------
    Bierwisch, Kraft, Riedel & Moseler (2009), J. Mech. Phys. Solids 57:10-31.
    """
    known = {name: material_parameter(name) for name in values}
    powers = {name: 0.0 if p is None else p.coarse_graining_power for name, p in known.items()}
    return {name: value * factor ** powers[name] for name, value in values.items()}


def contact_law(
    material: Mapping[str, float],
    chosen: Iterable[str] = (),
    models: Iterable[ContactModel] = CONTACT_MODELS,
) -> ContactLaw:
    """Return the contact models that act in a material.

    Those are the chosen models and, of every other kind, the model that has a parameter away from
    its default, or else the first one that has an effect by default. A chosen model whose
    parameters are all at their defaults does nothing, as if it was not chosen.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name; parameters with a default may be missing.
    chosen : iterable of str
        Names of models.
    models : iterable of ContactModel
        The models to choose from.

    Raises
    ------
    InputError
        Two models of the same kind would act.
    """
    chosen = tuple(chosen)
    models = tuple(models)
    kinds = ([model for model in models if model.kind == kind] for kind in KINDS)
    active = (_active_of_kind(of_kind, material, chosen) for of_kind in kinds)
    return ContactLaw(tuple(model for of_kind in active for model in of_kind))


def is_load_dependent(chosen: Iterable[str]) -> bool:
    """Return whether the stiffness of contacts grows with the load: not that of linear springs."""
    return all(model.springs is None for model in _named(chosen))


def _active_of_kind(
    models: list[ContactModel], material: Mapping[str, float], chosen: tuple[str, ...]
) -> list[ContactModel]:
    """Return the model of one kind that acts, or none."""
    named = [model for model in models if model.name in chosen]
    asked_for = [model for model in named if not model.is_optional]
    asked_for += [m for m in _optional_defaults(models, named) if m.set_parameters(material)]
    if len(named) > 1 or len(asked_for) > 1:
        wrong = named if len(named) > 1 else asked_for
        raise InputError([_contradiction(model, wrong, material) for model in wrong])
    return (asked_for or [model for model in models if not model.is_optional])[:1]


def _optional_defaults(
    models: Iterable[ContactModel], named: Iterable[ContactModel] = ()
) -> list[ContactModel]:
    """Return the optional models, of those that share parameters the named or the first one."""
    defaults: list[ContactModel] = []
    for model in (*named, *models):
        if model.is_optional and not any(model.shares_parameters(other) for other in defaults):
            defaults.append(model)
    return defaults


def _contradiction(
    model: ContactModel, others: list[ContactModel], material: Mapping[str, float]
) -> Fault:
    names = " and ".join(other.name for other in others)
    key = ", ".join(model.set_parameters(material)) or model.name
    return messages.CONTRADICTION.fault(key, model=model.name, models=names)


def needed_models() -> dict[Kind, tuple[ContactModel, ...]]:
    """Return the models by kind of which every material has one."""
    needed = [model for model in CONTACT_MODELS if not model.is_optional]
    kinds = [kind for kind in KINDS if any(model.kind == kind for model in needed)]
    return {kind: tuple(model for model in needed if model.kind == kind) for kind in kinds}


def selectable_models() -> dict[Kind, tuple[str, ...]]:
    """Return the names of the models that can be chosen by name, by kind, the default first.

    Of a kind with one model, and of models that each act through parameters of their own, nothing
    need be chosen.
    """
    kinds = {kind: [m for m in CONTACT_MODELS if m.kind == kind] for kind in KINDS}
    return {
        kind: tuple(model.name for model in models)
        for kind, models in kinds.items()
        if len(models) > len(_defaults(models))
    }


def default_models(kind: Kind) -> tuple[str, ...]:
    """Return the names of the models of a kind that act without being chosen."""
    return tuple(model.name for model in _defaults([m for m in CONTACT_MODELS if m.kind == kind]))


def _defaults(models: list[ContactModel]) -> list[ContactModel]:
    return [*[model for model in models if not model.is_optional][:1], *_optional_defaults(models)]


def non_default_models(chosen: Iterable[str]) -> tuple[str, ...]:
    """Return the chosen models without those that act anyway: part of a run's identity.

    Raises
    ------
    InputError
        There is no such model, or two of one kind are chosen.
    """
    chosen = tuple(chosen)
    selectable = selectable_models()
    known = [name for names in selectable.values() for name in names]
    InputError.raise_for(
        messages.UNKNOWN_MODEL.fault("contact_models", name=name, known=", ".join(known))
        for name in chosen
        if name not in known
    )
    contact_law({}, chosen)
    defaults = {name for kind in selectable for name in default_models(kind)}
    return tuple(name for name in dict.fromkeys(chosen) if name not in defaults)


def inactive_parameters(chosen: Iterable[str]) -> frozenset[str]:
    """Return the names of parameters that belong only to models replaced by the chosen ones."""
    chosen = tuple(chosen)
    named = _named(chosen)
    kinds = {model.kind for model in named}
    active = [*contact_law({}, chosen).models, *named]
    replaced = [
        m for m in CONTACT_MODELS if m not in active and (m.kind in kinds or not m.is_optional)
    ]
    return frozenset(_names(replaced) - _names(active))


def _named(chosen: Iterable[str]) -> list[ContactModel]:
    chosen = tuple(chosen)
    return [model for model in CONTACT_MODELS if model.name in chosen]


def _names(models: Iterable[ContactModel]) -> set[str]:
    return {parameter.name for model in models for parameter in model.parameters}


def contact_law_faults(
    material: Mapping[str, float], solver: str, chosen: Iterable[str] = ()
) -> list[Fault]:
    """Return why a solver cannot compute the contacts of a material; empty if it can.

    Parameters
    ----------
    material : mapping of str to float
        Values by dotted name; parameters with a default may be missing.
    solver : str
        Name of the solver.
    chosen : iterable of str
        Names of models.
    """
    chosen = tuple(chosen)
    try:
        law = contact_law(material, chosen)
    except InputError as error:
        return list(error.faults)
    return [
        *(_not_in(solver, model, material) for model in law.without(solver)),
        *unfit_faults(law, material, solver),
        *inactive_faults(material, chosen),
    ]


def unfit_faults(law: ContactLaw, material: Mapping[str, float], solver: str) -> list[Fault]:
    """Return the faults of models that a solver cannot compute beside another one of the law.

    A model whose parameters are all zero is beside any other.
    """
    faults = []
    for other, model in law.unfit(solver):
        names = [p.name for p in other.parameters if p.name not in other.dashpots]
        acting = [one for name in names for one in same_on_walls(name, material) if material[one]]
        having = [s for s in model.solvers if s in other.solvers and not _is_unfit(other, law, s)]
        instead = f", or use {' or '.join(having)}" if having else ""
        faults += [
            messages.NOT_BESIDE.fault(
                name,
                solver=solver,
                other=other.name,
                kind=other.kind,
                model=model.name,
                instead=instead,
            )
            for name in acting
        ]
    return faults


def _is_unfit(model: ContactModel, law: ContactLaw, solver: str) -> bool:
    return any(other.name == model.name for other, _ in law.unfit(solver))


def size_faults(law: ContactLaw, solver: str, *, is_one_size: bool) -> list[Fault]:
    """Return why a solver cannot compute the contacts of particles of several sizes, or of clumps.

    Parameters
    ----------
    law : ContactLaw
        The contact models that act.
    solver : str
        Name of the solver.
    is_one_size : bool
        Whether all particles are spheres of one diameter.
    """
    unfit = [
        model
        for model in law.models
        for words in model.keywords
        if words.solver == solver and words.one_size and not is_one_size
    ]
    return [
        messages.ONE_SIZE.fault(
            "particle.diameter", solver=solver, model=model.name, remedy=_of_all_sizes(model)
        )
        for model in unfit
    ]


def _of_all_sizes(model: ContactModel) -> str:
    able = [words.solver for words in model.keywords if not words.one_size]
    if not able:
        return "Give one diameter, without a shape."
    return f"Use {' or '.join(able)}, or give one diameter, without a shape."


def inactive_faults(material: Mapping[str, float], chosen: Iterable[str]) -> list[Fault]:
    """Return the faults of values that have no effect with the chosen contact models."""
    chosen = tuple(chosen)
    without_effect = inactive_parameters(chosen)
    return [
        no_effect(name, chosen)
        for name in sorted(material)
        if plain_name(name) in without_effect
        and material[name] != MATERIAL_PARAMETERS[plain_name(name)].default
    ]


def inactive_models(material: Mapping[str, float], chosen: Iterable[str]) -> list[ContactModel]:
    """Return the chosen models that do nothing, because their parameters are at their defaults."""
    chosen = tuple(chosen)
    return [
        model
        for model in CONTACT_MODELS
        if model.name in chosen and model.is_optional and not model.set_parameters(material)
    ]


def no_effect(name: str, chosen: Iterable[str]) -> Fault:
    """Return the fault of a parameter that the chosen contact models do not have."""
    own = [m for m in CONTACT_MODELS if plain_name(name) in _names([m])]
    if all(model.name not in default_models(model.kind) for model in own) and not any(
        other.kind == model.kind for model in own for other in _named(chosen)
    ):
        return messages.NOT_CHOSEN.fault(name, kind=own[0].kind, model=own[0].name)
    return messages.NO_EFFECT.fault(name, models=" and ".join(chosen))


def _not_in(solver: str, model: ContactModel, material: Mapping[str, float]) -> Fault:
    key, remedy = ", ".join(model.set_parameters(material)) or model.name, _instead(solver, model)
    return messages.NOT_IN_SOLVER.fault(key, model=model.name, solver=solver, remedy=remedy)


def _instead(solver: str, model: ContactModel) -> str:
    """Return a remedy for a model that a solver does not have."""
    alike = [
        f'{other.kind} = "{other.name}"'
        for other in CONTACT_MODELS
        if other.kind == model.kind and other.shares_parameters(model) and solver in other.solvers
    ]
    # True of calibrated values too: those of one model are not those of another.
    other_way = (
        f"calibrate with a model that {solver} has: [contact_models] {' or '.join(alike)}"
        if alike
        else "leave it out"
    )
    having = " or ".join(model.solvers)
    way = f"use {having}, or {other_way}." if having else f"{other_way}."
    return as_sentence(way)
