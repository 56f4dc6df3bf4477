"""Chosen contact models, and how cohesive contacts are: Bond number, pull-off force, overlap."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.conditions import conditions_of
from grainfit.bulk_tests.parameter_names import DENSITY, MODULUS
from grainfit.calibration_file.content import CalibrationFile
from grainfit.contact_models.cohesive_contacts import CohesiveContact, cohesive_contact, contacts_of
from grainfit.contact_models.contact import TYPICAL_LOAD
from grainfit.contact_models.registry import COHESION, contact_law, inactive_models, with_defaults
from grainfit.errors import InputError
from grainfit.formatting import millimetres
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.walls import plain_name

#: Parameters whose intervals change how cohesive the particles are.
_COUNTING = (DENSITY, MODULUS, *COHESION)


def chosen_model_lines(file: CalibrationFile) -> Iterator[str]:
    """Yield the chosen contact models: those that act, and those that do nothing."""
    largest = {p.name: p.maximum for p in file.parameters}
    known = {**file.fixed, **largest}
    idle = {model.name: model for model in inactive_models(known, file.contact_models)}
    if acting := [name for name in file.contact_models if name not in idle]:
        yield f"Contact model instead of the usual one: {', '.join(acting)}."
    for name, model in idle.items():
        yield (
            f"The contact model {name} was chosen and does nothing: it takes "
            f"{' or '.join(parameter.name for parameter in model.parameters)} above 0."
        )


def cohesion_lines(file: CalibrationFile, bulk_tests: Mapping[str, BulkTest]) -> Iterator[str]:
    """Yield how cohesive contacts are within the intervals; nothing for a dry material."""
    largest = {p.name: p.maximum for p in file.parameters}
    # The most slender clumps have the smallest spheres.
    aspect_ratio = {**file.fixed, **largest}.get(ASPECT_RATIO)
    conditions = dict.fromkeys(
        (conditions_of(t).gravity, conditions_of(t).sizes.real.with_aspect_ratio(aspect_ratio))
        for t in bulk_tests.values()
    )
    for gravity, sizes in conditions:
        sphere = sizes.sphere_diameters[0] / sizes.diameters[0]
        for particles, diameter in _shown(sizes).items():
            found = _contacts(file, diameter, sphere * diameter, gravity)
            for (model, words), contacts in found.items():
                if any(contact.bond_number > 0 for contact in contacts):
                    yield f"Cohesion ({model}), {words}, {particles}: {_numbers(contacts)}."


def _shown(sizes: ParticleSizes) -> dict[str, float]:
    """Return the diameters to tell of, by their words."""
    if len(sizes.diameters) == 1:
        return {millimetres(sizes.diameters[0]): sizes.diameters[0]}
    mean, finest = sizes.sauter_diameter, min(sizes.diameters)
    return {
        f"{millimetres(mean)} (Sauter diameter)": mean,
        f"{millimetres(finest)} (finest)": finest,
    }


def _contacts(
    file: CalibrationFile, diameter: float, sphere: float, gravity: float
) -> dict[tuple[str, str], list[CohesiveContact]]:
    """Return the contacts at the ends of the intervals, by the model and the bodies in words.

    Attraction is that of spheres of the volume of the particles, the overlap that of their smallest
    spheres.
    """
    found: dict[tuple[str, str], list[CohesiveContact]] = {}
    is_dry_somewhere = False
    for material in _corners(file):
        try:
            law = contact_law(material, file.contact_models)
        except InputError:
            return {}
        if law.cohesion is None:
            is_dry_somewhere = True
            continue
        smallest = contacts_of(material, sphere, gravity)
        for words, contact in contacts_of(material, diameter, gravity).items():
            overlap = cohesive_contact(law, smallest[words]).overlap
            contacts = found.setdefault((law.cohesion.name, words), [])
            contacts.append(replace(cohesive_contact(law, contact), overlap=overlap))
    if is_dry_somewhere:
        for contacts in found.values():
            contacts.append(CohesiveContact(0.0, 0.0, 0.0))
    return found


def _corners(file: CalibrationFile) -> Iterator[dict[str, float]]:
    """Iterate over the materials at the ends of the intervals that count."""
    middles = {p.name: (p.minimum + p.maximum) / 2 for p in file.parameters}
    material = with_defaults({**middles, **file.fixed})
    ends = {
        p.name: (p.minimum, p.maximum) for p in file.parameters if plain_name(p.name) in _COUNTING
    }
    for values in product(*ends.values()):
        yield {**material, **dict(zip(ends, values, strict=True))}


def _numbers(contacts: list[CohesiveContact]) -> str:
    return (
        f"Bond number {_range([c.bond_number for c in contacts])} (attraction under "
        f"{TYPICAL_LOAD:g} particle weights over one), pull-off force "
        f"{_range([c.pull_off for c in contacts])} particle weights, overlap without a load "
        f"{_range([100 * c.overlap for c in contacts])} % of the diameter"
    )


def _range(values: list[float]) -> str:
    low, high = f"{min(values):.2g}", f"{max(values):.2g}"
    return low if low == high else f"{low} to {high}"
