"""Registry of contact models, material parameters, and the contact law of a material."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grainfit.contact_models.base import KINDS, ContactLaw, ContactModel, Kind
from grainfit.contact_models.epsd.contact_model import EPSD
from grainfit.contact_models.epsd2.contact_model import EPSD2
from grainfit.contact_models.hertz_mindlin.contact_model import HERTZ_MINDLIN
from grainfit.errors import Fault, InputError
from grainfit.materials.parameters import BODY_PARAMETERS, SECTIONS, MaterialParameter

#: A new contact model is a line here. If several models of one kind
#: have an effect by default, the first one acts.
CONTACT_MODELS: tuple[ContactModel, ...] = (
    HERTZ_MINDLIN,
    EPSD,
    EPSD2,
)

#: The order of parameters is part of a calibration's identity, so that the first keys keep their
#: places; those of new models follow in the order of the models.
_FIRST_KEYS = ("sliding_friction", "rolling_friction", "restitution", "rolling_damping")


def material_parameters(models: Iterable[ContactModel]) -> dict[str, MaterialParameter]:
    """Return the parameters of bodies and contact models, in the order of the calibration file."""
    declared = [*BODY_PARAMETERS, *(p for model in models for p in model.parameters)]
    sections = list(SECTIONS)

    def order(parameter: MaterialParameter) -> tuple[int, int]:
        known = parameter.key in _FIRST_KEYS
        place = _FIRST_KEYS.index(parameter.key) if known else len(_FIRST_KEYS)
        return sections.index(parameter.section), place

    return {parameter.name: parameter for parameter in sorted(declared, key=order)}


#: All material parameters by dotted name.
MATERIAL_PARAMETERS: Mapping[str, MaterialParameter] = material_parameters(CONTACT_MODELS)


def with_defaults(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values of a material, completed by the defaults of parameters not given."""
    defaults = {
        name: known.default
        for name, known in MATERIAL_PARAMETERS.items()
        if known.default is not None
    }
    return {**defaults, **values}


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
    known = MATERIAL_PARAMETERS
    powers = {name: known[name].coarse_graining_power for name in values.keys() & known.keys()}
    return {name: value * factor ** powers.get(name, 0.0) for name, value in values.items()}


def contact_law(
    material: Mapping[str, float],
    chosen: Iterable[str] = (),
    models: Iterable[ContactModel] = CONTACT_MODELS,
) -> ContactLaw:
    """Return the contact models that act in a material.

    Those are the chosen models and, of every other kind, the model that has a parameter away from
    its default, or else the first one that has an effect by default.

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
    laws = (_acting([m for m in models if m.kind == kind], material, chosen) for kind in KINDS)
    return ContactLaw(tuple(model for acting in laws for model in acting))


def _acting(
    models: list[ContactModel], material: Mapping[str, float], chosen: tuple[str, ...]
) -> list[ContactModel]:
    """Return the model of one kind that acts, or none."""
    asked_for = [
        model
        for model in models
        if model.name in chosen or (model.is_optional and model.set_parameters(material))
    ]
    if len(asked_for) > 1:
        raise InputError([_contradiction(model, asked_for, material) for model in asked_for])
    return (asked_for or [model for model in models if not model.is_optional])[:1]


def _contradiction(
    model: ContactModel, others: list[ContactModel], material: Mapping[str, float]
) -> Fault:
    names = " and ".join(other.name for other in others)
    return Fault(
        ", ".join(model.set_parameters(material)) or model.name,
        f"belongs to the contact model {model.name}; {names} cannot act together.",
        "Leave out the parameters of all but one of them.",
    )


def selectable_models() -> dict[Kind, tuple[str, ...]]:
    """Return the names of the models that must be chosen by name, by kind, the usual one first.

    Of a kind with one model, and of models that act through a parameter of their own, nothing need
    be chosen.
    """
    needed = {
        kind: tuple(m.name for m in CONTACT_MODELS if m.kind == kind and not m.is_optional)
        for kind in KINDS
    }
    return {kind: names for kind, names in needed.items() if len(names) > 1}


def unusual_models(chosen: Iterable[str]) -> tuple[str, ...]:
    """Return the chosen models without those that act anyway: part of a run's identity.

    Raises
    ------
    InputError
        There is no such model, or two of one kind are chosen.
    """
    chosen = tuple(chosen)
    selectable = selectable_models()
    faults = [
        Fault(
            "contact_models",
            f"{name!r} is no model to choose.",
            f"Use {', '.join(n for names in selectable.values() for n in names)}.",
        )
        for name in chosen
        if not any(name in names for names in selectable.values())
    ]
    if faults:
        raise InputError(faults)
    contact_law({}, chosen)
    usual = {names[0] for names in selectable.values()}
    return tuple(name for name in dict.fromkeys(chosen) if name not in usual)


def parameters_without_effect(chosen: Iterable[str]) -> frozenset[str]:
    """Return the names of parameters that belong only to models replaced by the chosen ones."""
    law = contact_law({}, chosen)
    acting = {parameter.name for model in law.models for parameter in model.parameters}
    replaced = [m for m in CONTACT_MODELS if not m.is_optional and m not in law.models]
    return frozenset(p.name for model in replaced for p in model.parameters) - acting


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
    idle = sorted(parameters_without_effect(chosen) & material.keys())
    return [
        *(_not_in(solver, model, material) for model in law.without(solver)),
        *(no_effect(name, chosen) for name in idle),
    ]


def no_effect(name: str, chosen: Iterable[str]) -> Fault:
    """Return the fault of a parameter that the chosen contact models do not have."""
    models = " and ".join(chosen)
    return Fault(name, f"is no parameter of the contact model {models}.", "Leave it out.")


def _not_in(solver: str, model: ContactModel, material: Mapping[str, float]) -> Fault:
    having = " or ".join(model.solvers)
    return Fault(
        ", ".join(model.set_parameters(material)) or model.name,
        f"belongs to the contact model {model.name}, which {solver} does not have.",
        f"Use {having}, or leave it out." if having else "Leave it out.",
    )
