"""The card as a file that a LAMMPS deck includes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.contact_models.hertz_mindlin import model as contact
from grainfit.materials.card import MaterialCard
from grainfit.materials.card_text import about, header
from grainfit.solvers.dem.card_parts import fill, origin, require_material, require_sizes, variables

_TAKEN = ("rayleigh_time_step", "recommended_time_step")


@dataclass(frozen=True)
class _Contact:
    """A contact of ``pair_style granular`` or ``fix wall/gran granular``.

    Parameters
    ----------
    name : str
        Of the variable.
    types : tuple of int
        Atom types: two of particles, one of a particle on a wall.
    suffix : str
        Tells contacts of different diameters apart; empty when there is one diameter.
    coefficients : str
        As the deck of the heap test has them.
    """

    name: str
    types: tuple[int, ...]
    suffix: str
    coefficients: str


def render_lammps(card: MaterialCard) -> str:
    """Return the card for LAMMPS.

    Raises
    ------
    InputError
        A parameter that LAMMPS needs is missing or impossible, or the particles' size is not known.
    """
    material = require_material(card, "lammps")
    sizes = require_sizes(card, "lammps")
    radii = [diameter / 2 for diameter in sizes.diameters]
    between = list(_between_particles(material, radii, card.gravity))
    walls = list(_on_wall(material, radii, card.gravity))
    taken = (*_TAKEN, *(found.name for found in (*between, *walls)))
    return fill(
        "lammps",
        {
            "header": header(card),
            "origin": origin(card, "lammps"),
            "card": card,
            "sizes": sizes,
            "variables": list(variables(card.parameters, taken)),
            "about": about,
            "load": f"{contact.TYPICAL_LOAD:g}",
            "particle_contacts": between,
            "wall_contacts": walls,
        },
    )


def _between_particles(
    material: Mapping[str, float], radii: list[float], gravity: float
) -> Iterator[_Contact]:
    for i, radius in enumerate(radii, 1):
        for j, other in enumerate(radii[i - 1 :], i):
            suffix = f"_{i}_{j}" if len(radii) > 1 else ""
            spring = contact.rolling_between_particles(material, radius, other, gravity)
            coefficients = _coefficients(material, "particle", spring)
            yield _Contact(f"particle_particle_contact{suffix}", (i, j), suffix, coefficients)


def _on_wall(
    material: Mapping[str, float], radii: list[float], gravity: float
) -> Iterator[_Contact]:
    friction = material["particle_wall.rolling_friction"]
    for i, radius in enumerate(radii, 1):
        suffix = f"_{i}" if len(radii) > 1 else ""
        spring = contact.rolling_on_wall(material, radius, gravity, friction)
        coefficients = _coefficients(material, "wall", spring)
        yield _Contact(f"particle_wall_contact{suffix}", (i,), suffix, coefficients)


def _coefficients(material: Mapping[str, float], body: str, spring: contact.RollingSpring) -> str:
    found = contact.lammps_coefficients(material, body)
    return (
        f"hertz/material {found['modulus']!r} {found['restitution']!r} "
        f"{material['particle.poissons_ratio']!r} damping coeff_restitution "
        f"tangential mindlin {found['tangential_stiffness']!r} {found['tangential_damping']!r} "
        f"{material[f'particle_{body}.sliding_friction']!r} "
        f"rolling sds {spring.stiffness!r} {spring.damping!r} "
        f"{material[f'particle_{body}.rolling_friction']!r}"
    )
