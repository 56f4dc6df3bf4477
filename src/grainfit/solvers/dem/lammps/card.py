"""Write a material card as a file that a LAMMPS deck includes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.lammps import lammps_clauses, lammps_keywords
from grainfit.formatting import without_noise
from grainfit.materials.card import MaterialCard
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.walls import material_on
from grainfit.solvers.dem.card_clumps import clump_lines, lammps_molecule
from grainfit.solvers.dem.card_parts import (
    fill_card,
    model_notes,
    require_material,
    require_sizes,
    simulated_card,
    variables,
    walls_of_card,
)
from grainfit.solvers.dem.sphere_types import SphereTypes

_TAKEN = ("rayleigh_time_step", "recommended_time_step")


@dataclass(frozen=True)
class _ContactVariable:
    """A contact of ``pair_style granular`` or ``fix wall/gran granular``.

    Parameters
    ----------
    name : str
        Name of the variable.
    types : tuple of int
        Atom types: two of particles, one of a particle on a wall.
    suffix : str
        Suffix for contacts of different diameters; empty if there is only one diameter.
    coefficients : str
        Coefficients as in the decks of bulk tests.
    wall : str
        Name of the wall, if it has one.
    """

    name: str
    types: tuple[int, ...]
    suffix: str
    coefficients: str
    wall: str = ""


def render_lammps(card: MaterialCard) -> str:
    """Return the card for LAMMPS.

    Raises
    ------
    InputError
        A parameter that LAMMPS needs is missing or impossible, or the particles' size is not known.
    """
    card = simulated_card(card)
    material, law = require_material(card, "lammps")
    sizes = require_sizes(card, "lammps")
    kinds = SphereTypes.of(sizes)
    between = list(_between_particles(law, material, kinds, card.gravity))
    walls = [
        contact
        for wall in walls_of_card(card)
        for contact in _on_wall(law, material_on(material, wall), kinds, card.gravity, wall)
    ]
    several = len(kinds.radii) > 1
    taken = (*_TAKEN, *(found.name for found in (*between, *walls)))
    return fill_card(
        "lammps",
        card,
        {
            "kinds": kinds,
            "without_noise": without_noise,
            "groups": [f"size{n + 1} type {n + 1}" for n in range(len(kinds.radii)) if several],
            "sizes": sizes,
            "molfrac": _mole_fractions(sizes),
            "reach": without_noise(max(sizes.outer_diameters) + 0.3 * sizes.sauter_diameter),
            "clump": clump_lines(sizes, material["particle.density"], lammps_molecule),
            "variables": list(variables(card.parameters, taken)),
            "notes": model_notes(_notes(law, card.gravity)),
            "hertz": law.is_load_dependent,
            "particle_contacts": between,
            "wall_contacts": walls,
        },
    )


def _notes(law: ContactLaw, gravity: float) -> list[str]:
    """Return the meaning of the coefficients, with the load for which they hold if there is one."""
    found = lammps_keywords(law)
    return [words.notes(gravity) if law.is_load_dependent else words.legend for words in found]


def _mole_fractions(sizes: ParticleSizes) -> str:
    """Return the option of ``fix pour`` for several diameters."""
    if len(sizes.diameters) == 1:
        return ""
    return f" molfrac {' '.join(map(repr, sizes.number_fractions))}"


def _between_particles(
    law: ContactLaw, material: Mapping[str, float], kinds: SphereTypes, gravity: float
) -> Iterator[_ContactVariable]:
    count = len(kinds.radii)
    for i in range(1, count + 1):
        for j in range(i, count + 1):
            suffix = f"_{i}_{j}" if count > 1 else ""
            coefficients = " ".join(lammps_clauses(law, kinds.between(material, i, j, gravity)))
            name = f"particle_particle_contact{suffix}"
            yield _ContactVariable(name, (i, j), suffix, coefficients)


def _on_wall(
    law: ContactLaw, material: Mapping[str, float], kinds: SphereTypes, gravity: float, wall: str
) -> Iterator[_ContactVariable]:
    section = f"particle_wall_{wall}" if wall else "particle_wall"
    count = len(kinds.radii)
    for i in range(1, count + 1):
        suffix = f"_{i}" if count > 1 else ""
        coefficients = " ".join(lammps_clauses(law, kinds.on_wall(material, i, gravity)))
        yield _ContactVariable(f"{section}_contact{suffix}", (i,), suffix, coefficients, wall)
